#pragma once

#include "core/footstep/recipe.hpp"
#include "core/object.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::footstep {

/// A recipe of data/surfaces that is compiled into the object.
struct BuiltInSurface {
  std::string_view name, text;
};
[[nodiscard]] std::span<const BuiltInSurface> built_in_surfaces() noexcept;

/// A recipe and its id. The same text has the same id, so that a foot standing on it keeps its
/// sound (Foot::set_grounds()).
struct Surface {
  std::string name, text;
  std::uint64_t id = 0;
  Recipe recipe;
};

/// Finds surfaces by name: one of the fifteen built in, or a recipe file beside the patch or in the
/// search path.
class SurfaceStore {
public:
  /// Returns null after one error if the name is unknown or its recipe has a mistake. It reads a
  /// file, so it is not for the audio path.
  std::shared_ptr<const Surface> find(std::string_view name, Host& host);
  [[nodiscard]] std::shared_ptr<const Surface> built_in(std::string_view name);

private:
  static constexpr std::size_t kMaxCachedRecipes = 32; ///< cached texts
  std::shared_ptr<const Surface> from_text(std::string_view name, std::string_view text,
                                           std::string& error_text);
  std::vector<std::shared_ptr<const Surface>> cache_;
  std::uint64_t last_id_ = 0;
};

} // namespace tactus::footstep
