#pragma once

#include "core/haptic/scene/scene.hpp"
#include "externals/phantom/words.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace tactus::phantom {

/// The scene of a patch, whose bodies have names, and its messages: docs/scene.md.
class NamedScene {
public:
  static constexpr std::size_t kMaxSolids = 64, kMaxMeshes = 8;

  static constexpr double kMinTool_mm = 0.01, kMaxTool_mm = 50;
  /// Handles a message of the scene: add, mat, move, del, tool, k or load. Returns a sentence if
  /// the message is refused; nothing has changed then.
  [[nodiscard]] std::string handle(Words words, const Host& host);
  /// A copy for the servo. Bodies whose names are numbers come first, in numeric order. Bodies
  /// whose names are words follow, in the order in which they were first added. The events of one
  /// tick have the same order.
  [[nodiscard]] std::unique_ptr<const haptic::Scene> snapshot() const;
  /// The name of a body, also of one that was removed recently.
  [[nodiscard]] Atom name_of(std::uint64_t key) const noexcept;
  /// The largest value of a property among the bodies' materials, and that body's name; empty for
  /// an empty scene.
  struct NamedMaximum {
    std::string name;
    double value = 0;
  };
  [[nodiscard]] NamedMaximum max_of(double haptic::Material::*property) const;
  void dump(Host& host) const;

private:
  struct Entry {
    std::string name;
    bool is_number = false;
    haptic::Body body;
    std::string description; ///< the words after `scene add NAME`
  };
  struct RemovedBody {
    std::uint64_t key;
    std::string name;
    bool is_number;
  };
  static constexpr std::size_t kMaxRemoved = 128;

  [[nodiscard]] std::string add(Words words, const Host& host);
  [[nodiscard]] std::string set_material(Words words);
  [[nodiscard]] std::string move(Words words);
  [[nodiscard]] std::string remove(Words words);
  [[nodiscard]] std::string set_tool(Words words);
  [[nodiscard]] std::string load(Words words, const Host& host);
  [[nodiscard]] Entry* find(const Atom& name) noexcept;
  void remember_removed(const Entry& entry);

  std::vector<Entry> entries_;
  std::deque<RemovedBody> removed_;
  std::uint64_t keys_ = 0;
  double tool_radius_m_ = 0;
  haptic::Material material_{}; // material of bodies that are added from now on
};

} // namespace tactus::phantom
