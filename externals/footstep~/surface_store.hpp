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

struct BuiltInSurface {
  std::string_view name, text;
};
[[nodiscard]] std::span<const BuiltInSurface> built_in_surfaces() noexcept;

/// A recipe with a number of its own: the same text has the same number, so that a foot that goes
/// on standing on it goes on sounding.
struct Surface {
  std::string name, text;
  std::uint64_t id = 0;
  Recipe recipe;
};

/// Surfaces by name: one of the fifteen, or a recipe's file beside the patch or in the search path.
class SurfaceStore {
public:
  /// Null after one sentence when there is none of that name or its recipe has a mistake. Reads a
  /// file of a few kilobytes: not for the audio path.
  std::shared_ptr<const Surface> find(std::string_view name, Host& host);
  [[nodiscard]] std::shared_ptr<const Surface> built_in(std::string_view name);

private:
  static constexpr std::size_t kMaxCachedRecipes = 32; ///< texts remembered
  std::shared_ptr<const Surface> from_text(std::string_view name, std::string_view text,
                                           std::string& error_text);
  std::vector<std::shared_ptr<const Surface>> cache_;
  std::uint64_t last_id_ = 0;
};

} // namespace tactus::footstep
