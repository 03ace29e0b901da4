#pragma once

#include "core/geometry/vec3.hpp"
#include "core/haptic/scene/work_limit.hpp"

namespace tactus::haptic {

/// Where a straight motion meets a surface: the fraction of the motion, and the surface's unit
/// normal, which points back to where the motion began.
struct Crossing {
  double fraction;
  Vec3 normal;
};

/// What one iteration of a rounded shape's crossing costs.
inline constexpr int kIterationWork = 5;

} // namespace tactus::haptic
