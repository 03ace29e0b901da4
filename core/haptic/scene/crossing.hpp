#pragma once

#include "core/geometry/vec3.hpp"
#include "core/haptic/scene/work_limit.hpp"

namespace tactus::haptic {

/// The first contact of a straight motion with a surface: the fraction of the motion, 0..1, and the
/// surface's unit normal on the side from which the motion comes.
struct Crossing {
  double fraction;
  Vec3 normal;
};

/// Cost of one iteration of convex_crossing, in units of WorkLimit.
inline constexpr int kIterationWork = 5;

} // namespace tactus::haptic
