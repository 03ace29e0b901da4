#include "core/haptic/device/path.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace tactus::haptic {
namespace {

using std::numbers::pi;

// Whole periods are removed before the product with 2 pi, so that the sine is exact after hours.
double phase_of(double turns) noexcept { return 2 * pi * (turns - std::floor(turns)); }

} // namespace

PathPoint RowPath::at(double time_s) const noexcept {
  if (rows_.empty())
    return {};
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), time_s,
                                      [](double t, const PathRow& row) { return t < row.time_s; });
  if (after == rows_.begin())
    return {after->position, {}, after->buttons};
  const auto before = std::prev(after);
  if (after == rows_.end())
    return {before->position, {}, before->buttons};
  const double span_s = after->time_s - before->time_s;
  const Vec3 displacement = after->position - before->position;
  const double fraction = (time_s - before->time_s) / span_s;
  return {before->position + displacement * fraction, displacement * (1.0 / span_s),
          before->buttons};
}

PathPoint LinePath::at(double time_s) const noexcept {
  const double phase = phase_of(time_s / period_s);
  const Vec3 displacement = to - from;
  return {from + displacement * (0.5 * (1.0 - math::cos(phase))),
          displacement * (math::sin(phase) * pi / period_s), 0};
}

PathPoint CirclePath::at(double time_s) const noexcept {
  const double phase = phase_of(time_s / period_s);
  const double speed = radius_m * 2 * pi / period_s;
  PathPoint point;
  point.position = centre;
  point.position[first] += radius_m * math::cos(phase);
  point.position[second] += radius_m * math::sin(phase);
  point.velocity[first] = -speed * math::sin(phase);
  point.velocity[second] = speed * math::cos(phase);
  return point;
}

PathPoint LissajousPath::at(double time_s) const noexcept {
  PathPoint point;
  for (int axis = 0; axis < 3; ++axis) {
    const double phase = phase_of(frequency_hz[axis] * time_s);
    point.position[axis] = centre[axis] + amplitude[axis] * math::sin(phase);
    point.velocity[axis] = amplitude[axis] * 2 * pi * frequency_hz[axis] * math::cos(phase);
  }
  return point;
}

} // namespace tactus::haptic
