#pragma once
#include "fem/io/load.hpp"
#include "fem/material/material.hpp"
#include "fem/shapes/shapes.hpp"
#include "programs/body/progress.hpp"

#include <span>
#include <string>
#include <vector>

namespace tactus::fem {

/// The body that a command line names (its shape or file, material and mesh) and the files to
/// write.
struct BodyOptions {
  std::string body; ///< a shape's name or a file
  bool is_file = false;
  std::map<std::string, double> dimensions; ///< m
  std::string profile;
  double unit = 1e-3;
  bool unit_given = false;
  MeshChoice choice;
  std::string default_material = "aluminium";                 ///< for regions without --material
  std::vector<std::pair<std::string, std::string>> materials; ///< region (or "") and name
  std::map<std::string, double> changes;                      ///< young, poisson, density, loss
  std::vector<double> axes;
  bool several_parts = false, quiet = false, straight = false, remesh = false;
  std::string part; ///< the part to use of a file with separate parts
  int threads = 1;
  double time_limit_s = 1200; ///< longest time without progress while a file is read and meshed
  double memory_bytes = 0;    ///< 0 for half of the free memory
  double fillet = 0;          ///< m
  double shrink_wrap = 0;     ///< m; 0 for no wrap, below 0 to choose the gap
  std::string output, vtu, sheet, inp; ///< paths of the table, of VTU, picture and CalculiX files

  /// The body's name without folder and ending.
  [[nodiscard]] std::string name() const;
  /// Metres per unit of the body's lengths; 0 if the file contains its unit.
  [[nodiscard]] double unit_of_body() const;
};

/// Reads a number within its range. A refusal names the option.
[[nodiscard]] double number(const std::string& option, const std::string& word, double low,
                            double high);

/// Reads a whole number within its range. A refusal names the option.
[[nodiscard]] int integer(const std::string& option, const std::string& word, int low, int high);

/// Reads a command line BODY [options] word by word into a BodyOptions. A program reads its own
/// options from option() and leaves the others to take().
class BodyReader {
public:
  /// Reads the body and --unit, wherever it stands, because lengths depend on it. `program` is
  /// named in errors.
  BodyReader(BodyOptions& options, const std::vector<std::string>& words,
             std::span<const ShapeEntry> shapes, const char* program);

  /// Goes on to the next option; returns false at the end.
  [[nodiscard]] bool next();
  [[nodiscard]] const std::string& option() const { return words_[option_]; }
  /// The option's next value. Refuses a missing value.
  const std::string& value();
  /// The next value as a number (number()) or as a length in --unit (length()).
  double number(double low, double high);
  int integer(int low, int high);
  double length(double low, double high) { return options_.unit * number(low, high); }
  [[nodiscard]] double unit() const { return options_.unit; } ///< m
  /// Reads an option of the body, its material, its mesh or its files, or a dimension of the shape;
  /// refuses any other option.
  void take();

private:
  [[nodiscard]] std::string* output_path();
  void take_dimension();

  BodyOptions& options_;
  const std::vector<std::string>& words_;
  const ShapeEntry* shape_ = nullptr;
  std::string program_;
  std::size_t option_ = 0, at_ = 0; ///< indices of the present option and of the last word read
};

/// Help text: shapes with their dimensions, and the options that take() knows.
[[nodiscard]] std::string usage_of_shapes(std::span<const ShapeEntry>);
[[nodiscard]] std::string usage_of_material();
[[nodiscard]] std::string usage_of_mesh();

/// One material per region of the mesh: as given by the options, else the file's. Refuses unknown
/// names and changes that do not apply.
[[nodiscard]] std::vector<Material> materials_of(const BodyOptions&, const Mesh&);
/// The names as a text, such as "steel, brass".
[[nodiscard]] std::string names_of_materials(std::span<const Material>);
/// Warns if --young or --density differs much from the material that it changes.
void warn_of_unusual_constants(const BodyOptions&, ProgressLine&);
/// The values of --unit.
struct LengthUnit {
  std::string_view name;
  double metres;
};
inline constexpr std::array<LengthUnit, 5> kUnits{
    {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 25.4e-3}, {"m", 1}}};
/// The unit's name; empty if it has none.
[[nodiscard]] std::string name_of_unit(double metres);
/// A length as a text, such as "12.5 mm".
[[nodiscard]] std::string format_length(double metres);
/// Warns of a body that is implausibly long or short, and asks for its unit.
void warn_of_unusual_length(const BodyOptions&, double largest_m,
                            const std::function<void(const std::string&)>& notify);
/// The material of the first region.
[[nodiscard]] Material first_material(const BodyOptions&);

/// The settings for reading the body's file, with progress on `progress`.
[[nodiscard]] LoadChoice load_choice(const BodyOptions&, ProgressLine&);

/// Refuses a file that cannot be read. Refuses pipes and devices without opening them, since
/// opening one might never return.
void check_readable(const std::string& path);

/// Reports the mesh's size. Warns of linear elements; `what` describes their effect.
void describe(const Mesh&, ProgressLine&, const std::string& what);

} // namespace tactus::fem
