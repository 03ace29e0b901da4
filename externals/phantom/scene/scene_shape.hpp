#pragma once

#include "core/haptic/scene/scene.hpp"
#include "externals/phantom/words.hpp"

#include <string>

namespace tactus::phantom {

/// Shape and pose from the words of `scene add NAME ...`.
struct ShapeChoice {
  haptic::Shape shape{haptic::Plane{}};
  haptic::Pose pose{};
  std::string refusal; ///< one sentence if the words are wrong
};
[[nodiscard]] ShapeChoice choose_shape(Words words, const Host& host);

} // namespace tactus::phantom
