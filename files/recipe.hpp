#pragma once

#include "core/footstep/recipe.hpp"

#include <string>
#include <string_view>

namespace tactus::files {

/// Reads a ground's recipe. Lines: `level 1` before any section; `[solid]`, `[friction]`,
/// `[grains]`, `[bubbles]` and `[rustle]` (up to four sections of these three kinds together),
/// `[room]`; in a section, `key value` in the units of docs/formats/surface.md; `#` begins a
/// comment. Returns an empty text, or one sentence that names the line, the key, the value and the
/// expected value; `recipe` is then unchanged.
[[nodiscard]] std::string read_recipe(std::string_view text, footstep::Recipe& recipe);

} // namespace tactus::files
