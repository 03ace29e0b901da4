#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstdint>
#include <optional>

/// Geometry of the Novint Falcon: three legs around the z axis, each an upper arm a that a motor
/// turns by theta and a parallelogram b that carries the grip's platform. A Delta robot with
/// offsets c, d, e, f, r, s (R. E. Stamper, PhD thesis, University of Maryland 1997; the numbers
/// are from the open driver). docs/theory/falcon.md has the drawing and the equations.
///
/// Frame here: x right, y up, z from the base towards the user, origin in the base. SI, radians.
namespace tactus::devices::falcon {

using Angles = std::array<double, 3>;
using Counts = std::array<std::int16_t, 3>;

constexpr double kRadiansPerCount = 0.01425 / (1280 * 0.110) * 6.283185307179586; ///< shaft / drum
constexpr double kRadiansAtZero = 35 * 6.283185307179586 / 360;
constexpr int kMaxMotorCounts = 4096;
constexpr Vec3 kCentre{0, 0, 0.110}; ///< m, the origin of positions outside this file

[[nodiscard]] Angles motor_angles(const Counts& encoder) noexcept;

/// The three motor angles at a position; nothing when a leg does not reach it.
[[nodiscard]] std::optional<Angles> inverse(const Vec3& position) noexcept;

struct Forward {
  Vec3 position{};
  int steps = 0;
  bool found = false;
};
/// The position at three motor angles: Newton's method on the legs' closure equations, from a
/// start near by (the last position, or kCentre) until a step is shorter than 1e-12 m.
[[nodiscard]] Forward forward(const Angles& angles, const Vec3& start = kCentre) noexcept;

/// Row i is the gradient of motor angle i over position, rad/m.
struct Gradient {
  std::array<Vec3, 3> rows{};
};
/// Nothing when the pose is out of reach or at a singularity (a leg stretched or folded).
[[nodiscard]] std::optional<Gradient> angle_gradient(const Vec3& position) noexcept;

/// Motor torques that hold the force at that position, N m: over any small motion the torques do
/// the same work as the force. All are zero where the gradient does not exist.
[[nodiscard]] std::array<double, 3> torques(const Vec3& position, const Vec3& force_n) noexcept;

/// Motor commands for torques. If one would exceed the motors' range, all three shrink by the same
/// factor, so that the force keeps its direction.
[[nodiscard]] Counts motor_counts(const std::array<double, 3>& torque_n_m,
                                  double counts_per_n_m) noexcept;

/// The largest error of a position reading on any axis at the centre: half a count on each encoder.
[[nodiscard]] double position_error_m() noexcept;

} // namespace tactus::devices::falcon
