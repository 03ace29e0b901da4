#pragma once
#include "fem/io/inp_lines.hpp"
#include "fem/mesh/mesh.hpp"

#include <functional>
#include <optional>

namespace tactus::fem {

/// The materials, orientations and sections of a CalculiX / Abaqus file. Constants are in the unit
/// system of the file's lengths: with millimetres also N, t and s, hence MPa and t/mm^3.
class InpMaterials {
public:
  /// `unit`: metres per unit of length.
  InpMaterials(const InpLines& lines, double unit) : lines_(lines), unit_(unit) {}

  void begin_material(const InpKeyword&);
  void begin_elastic(const InpKeyword&);
  void add_elastic();
  void add_density();
  void begin_damping(const InpKeyword&);
  void begin_orientation(const InpKeyword&);
  void add_orientation();
  void begin_section(const InpKeyword&);
  void add_thickness();

  /// Rotates the directions of a part with its instance; by default there is no rotation.
  using Turn = std::function<Vec3(const Vec3&)>;
  void turn_by(Turn turn) { turn_ = std::move(turn); }

  struct Section {
    std::string elements, material, orientation;
    std::array<Vec3, 2> axes; ///< axes of a material without orientation
    int line = 0;
  };
  [[nodiscard]] const std::vector<Section>& sections() const noexcept { return sections_; }
  /// Refuses a material that the file does not define, or one without elastic constants. The
  /// density is 0 if the file has none.
  [[nodiscard]] Material material_of(const Section&) const;

private:
  struct Definition {
    Material material;
    bool elastic = false;
    int line = 0;
  };
  [[nodiscard]] Vec3 turned(const Vec3& direction) const;
  [[nodiscard]] Definition& last_material();
  [[nodiscard]] double constant(const std::string& cell, double scale, double low, double high,
                                const char* quantity) const;

  const InpLines& lines_;
  double unit_;
  std::map<std::string, Definition> materials_; ///< by name in lower case
  std::map<std::string, std::array<Vec3, 2>> orientations_;
  std::vector<Section> sections_;
  Turn turn_;
  std::string last_material_, last_orientation_;
  enum class Constants { isotropic, engineering, stiffness } type_ = Constants::isotropic;
  std::vector<std::string> constants_; ///< constants of *ELASTIC; nine of them take two lines
};

} // namespace tactus::fem
