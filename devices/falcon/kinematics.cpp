#include "devices/falcon/kinematics.hpp"

#include <cmath>

namespace tactus::devices::falcon {
namespace {

// m; names as in the drawing of docs/theory/falcon.md
constexpr double a = 0.060, b = 0.1025, c = 0.01443, d_e = 2 * 0.01125, f = -0.025;
constexpr double r = 0.0400, s = -0.02309;

constexpr double kCos15 = 0.9659258262890683, kSin15 = 0.25881904510252074;
constexpr double kHalf = 0.7071067811865476;
struct Leg {
  double cos_phi, sin_phi;
};
// Legs at 105, -15 and -135 degrees around z.
constexpr std::array<Leg, 3> kLegs{{{-kSin15, kCos15}, {kCos15, -kSin15}, {-kHalf, -kHalf}}};

constexpr double kTolerance_m = 1e-12;
constexpr int kMaxSteps = 32;
constexpr double kMaxStep_m = 0.03;
constexpr double kMaxCosine = 0.999; // limit of the cosine of the parallelogram's angle
constexpr double kMinSine = 1e-3;    // a leg with a smaller sine counts as stretched or folded

struct LegPoint {
  double u, v, w;      // the platform in the leg's own frame
  double cos_3, sin_3; // the parallelogram's swing out of the leg's plane
  double length;       // of the parallelogram's projection on the leg's plane
  bool within;
};

LegPoint leg_point(const Leg& leg, const Vec3& p) noexcept {
  LegPoint q{};
  q.u = p.x * leg.cos_phi + p.y * leg.sin_phi - r;
  q.v = -p.x * leg.sin_phi + p.y * leg.cos_phi - s;
  q.w = p.z;
  const double cosine = (q.v + f) / b;
  q.within = std::abs(cosine) < 1;
  q.cos_3 = std::clamp(cosine, -kMaxCosine, kMaxCosine);
  q.sin_3 = std::sqrt(1 - q.cos_3 * q.cos_3);
  q.length = d_e + b * q.sin_3;
  return q;
}

Vec3 to_base(const Leg& leg, double u, double v, double w) noexcept {
  return {u * leg.cos_phi - v * leg.sin_phi, u * leg.sin_phi + v * leg.cos_phi, w};
}

double determinant(const std::array<Vec3, 3>& rows) noexcept {
  return dot(rows[0], cross(rows[1], rows[2]));
}

// Solves (rows) x = right for x by Cramer's rule; det must not be zero.
Vec3 solve(const std::array<Vec3, 3>& rows, const Vec3& right, double det) noexcept {
  return (cross(rows[1], rows[2]) * right.x + cross(rows[2], rows[0]) * right.y +
          cross(rows[0], rows[1]) * right.z) *
         (1 / det);
}

// The motor angle of one leg and the cosine and sine of the parallelogram's angle in its plane.
struct LegAngles {
  double theta_1, cos_2, sin_2;
  bool found;
};

LegAngles leg_angles(const LegPoint& q) noexcept {
  const double reach = std::hypot(q.u + c, q.w);
  const double cosine = (reach * reach + a * a - q.length * q.length) / (2 * a * reach);
  if (!q.within || !(std::abs(cosine) <= 1))
    return {0, 0, 0, false};
  const double theta_1 = std::atan2(q.w, q.u + c) - std::acos(cosine);
  return {theta_1, (q.u + c - a * std::cos(theta_1)) / q.length,
          (q.w - a * std::sin(theta_1)) / q.length, true};
}

} // namespace

Angles motor_angles(const Counts& encoder) noexcept {
  Angles angles{};
  for (std::size_t leg = 0; leg < 3; ++leg)
    angles[leg] = kRadiansAtZero + kRadiansPerCount * encoder[leg];
  return angles;
}

std::optional<Angles> inverse(const Vec3& position) noexcept {
  Angles angles{};
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const LegAngles found = leg_angles(leg_point(kLegs[leg], position));
    if (!found.found)
      return std::nullopt;
    angles[leg] = found.theta_1;
  }
  return angles;
}

Forward forward(const Angles& angles, const Vec3& start) noexcept {
  Forward result{is_finite(start) ? start : kCentre, 0, false};
  Vec3& p = result.position;
  // g = (u + c - a cos t)^2 + (w - a sin t)^2 - length(v)^2 = 0 for each leg
  while (result.steps < kMaxSteps) {
    ++result.steps;
    std::array<Vec3, 3> rows{};
    Vec3 g;
    for (std::size_t leg = 0; leg < 3; ++leg) {
      const LegPoint q = leg_point(kLegs[leg], p);
      const double along = q.u + c - a * std::cos(angles[leg]);
      const double up = q.w - a * std::sin(angles[leg]);
      g[static_cast<int>(leg)] = along * along + up * up - q.length * q.length;
      rows[leg] = to_base(kLegs[leg], 2 * along, 2 * q.length * q.cos_3 / q.sin_3, 2 * up);
    }
    const double det = determinant(rows);
    if (!(std::abs(det) > 1e-9)) // m^3; about 1e-3 in the workspace
      return result;
    const Vec3 step = limited(solve(rows, g, det), kMaxStep_m);
    p -= step;
    if (norm(step) < kTolerance_m) {
      result.found = is_finite(p);
      for (const Leg& leg : kLegs)
        result.found = result.found && leg_point(leg, p).within;
      return result;
    }
  }
  return result;
}

std::optional<Gradient> angle_gradient(const Vec3& position) noexcept {
  Gradient gradient;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const LegPoint q = leg_point(kLegs[leg], position);
    const LegAngles found = leg_angles(q);
    const double sine = found.sin_2 * std::cos(found.theta_1) -
                        found.cos_2 * std::sin(found.theta_1); // sine of theta_2 - theta_1
    if (!found.found || !(std::abs(sine) > kMinSine))
      return std::nullopt;
    // From dg = 0: 2 length (cos_2 du + sin_2 dw + cot_3 dv) = 2 a length sine dtheta_1
    const double scale = 1 / (a * sine);
    gradient.rows[leg] =
        to_base(kLegs[leg], found.cos_2 * scale, q.cos_3 / q.sin_3 * scale, found.sin_2 * scale);
  }
  if (!(std::abs(determinant(gradient.rows)) > 1)) // 1/m^3; about 5000 in the workspace
    return std::nullopt;
  return gradient;
}

std::array<double, 3> torques(const Vec3& position, const Vec3& force_n) noexcept {
  const std::optional<Gradient> gradient = angle_gradient(position);
  if (!gradient || !is_finite(force_n))
    return {};
  // force . dp = torque . dtheta for every dp, so the force is the sum of torque_i times row i:
  // solve by Cramer's rule with the rows as columns.
  const auto& rows = gradient->rows;
  const double det = determinant(rows);
  return {dot(force_n, cross(rows[1], rows[2])) / det, dot(force_n, cross(rows[2], rows[0])) / det,
          dot(force_n, cross(rows[0], rows[1])) / det};
}

Counts motor_counts(const std::array<double, 3>& torque_n_m, double counts_per_n_m) noexcept {
  double largest = 0;
  for (const double torque : torque_n_m) {
    if (!std::isfinite(torque))
      return {};
    largest = std::max(largest, std::abs(torque * counts_per_n_m));
  }
  if (!std::isfinite(largest))
    return {};
  // Motors and encoders turn in opposite directions, hence the sign.
  const double scale =
      -counts_per_n_m * (largest > kMaxMotorCounts ? kMaxMotorCounts / largest : 1);
  Counts counts{};
  for (std::size_t motor = 0; motor < 3; ++motor)
    counts[motor] = static_cast<std::int16_t>(std::lround(torque_n_m[motor] * scale));
  return counts;
}

double position_error_m() noexcept {
  const std::optional<Gradient> gradient = angle_gradient(kCentre);
  if (!gradient)
    return 0;
  const auto& rows = gradient->rows;
  const double det = determinant(rows);
  // Columns of the inverse are dp/dtheta of each leg.
  const std::array<Vec3, 3> columns{cross(rows[1], rows[2]), cross(rows[2], rows[0]),
                                    cross(rows[0], rows[1])};
  double bound = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (const Vec3& column : columns)
      sum += std::abs(column[axis] / det);
    bound = std::max(bound, sum * kRadiansPerCount / 2);
  }
  return bound;
}

} // namespace tactus::devices::falcon
