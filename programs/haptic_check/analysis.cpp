#include "programs/haptic_check/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace tactus::haptic_check {

Motion motion_of(std::span<const Record> records) noexcept {
  Motion motion;
  if (records.empty())
    return motion;
  motion.lowest = motion.highest = records.front().position;
  double smallest = std::numeric_limits<double>::infinity();
  std::size_t fresh = 0;
  const Record* before = nullptr;
  for (const Record& record : records) {
    for (int axis = 0; axis < 3; ++axis) {
      motion.lowest[axis] = std::min(motion.lowest[axis], record.position[axis]);
      motion.highest[axis] = std::max(motion.highest[axis], record.position[axis]);
      const double step = before ? std::abs(record.position[axis] - before->position[axis]) : 0.0;
      if (step > 0)
        smallest = std::min(smallest, step);
    }
    if (before && !(record.position == before->position))
      ++fresh;
    motion.max_speed_m_per_s = std::max(motion.max_speed_m_per_s, norm(record.velocity));
    motion.buttons |= record.buttons;
    before = &record;
  }
  if (records.size() > 1)
    motion.changed_fraction = static_cast<double>(fresh) / static_cast<double>(records.size() - 1);
  motion.min_step_m = std::isfinite(smallest) ? smallest : 0;
  return motion;
}

Intervals intervals_of(std::span<const Record> records, double period_s) noexcept {
  Intervals all;
  double sum = 0, squares = 0;
  for (std::size_t i = 1; i < records.size(); ++i) {
    const double interval = records[i].time_s - records[i - 1].time_s;
    const double off = interval - period_s;
    const auto* edge = std::find_if(Intervals::kEdges_s.begin(), Intervals::kEdges_s.end() - 1,
                                    [off](double one) { return std::abs(off) < one; });
    ++all.counts[static_cast<std::size_t>(edge - Intervals::kEdges_s.begin())];
    sum += off;
    squares += off * off;
    all.max_s = std::max(all.max_s, interval);
    ++all.number;
  }
  if (all.number > 0) {
    const double n = static_cast<double>(all.number);
    all.mean_s = period_s + sum / n;
    all.deviation_s = std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)));
  }
  return all;
}

WallResult wall_result(std::span<const Record> records, const Wall& wall, double from_s,
                       double limit_n, double period_s) {
  WallResult result;
  double force_depth = 0, depth_depth = 0, vibration_rms = 0;
  std::size_t hum_ticks = 0;
  // The residual of a parabola that is fitted to 40 ms of the motion (Savitzky & Golay 1964).
  const auto half = static_cast<std::size_t>(std::max(2.0, 0.02 / period_s));
  const double m = static_cast<double>(half);
  const auto weight = [m](double k) {
    return 3 * (3 * m * m + 3 * m - 1 - 5 * k * k) / ((2 * m - 1) * (2 * m + 1) * (2 * m + 3));
  };
  for (std::size_t i = 0; i < records.size(); ++i) {
    const double depth = dot(wall.point - records[i].position, wall.normal);
    if (depth <= 0 || records[i].time_s - records.front().time_s < from_s)
      continue;
    const double force = dot(records[i].force_n, wall.normal);
    ++result.ticks;
    result.max_depth_m = std::max(result.max_depth_m, depth);
    result.max_force_n = std::max(result.max_force_n, force);
    if (force < 0.98 * limit_n) {
      force_depth += force * depth;
      depth_depth += depth * depth;
    }
    if (i < half || i + half >= records.size())
      continue;
    double smooth = 0;
    bool inside = true;
    for (std::size_t k = i - half; k <= i + half; ++k) {
      const double one = dot(wall.point - records[k].position, wall.normal);
      inside = inside && one > 0;
      smooth += one * weight(static_cast<double>(k) - static_cast<double>(i));
    }
    if (inside) {
      vibration_rms += (depth - smooth) * (depth - smooth);
      ++hum_ticks;
    }
  }
  if (depth_depth > 0)
    result.stiffness_n_per_m = force_depth / depth_depth;
  if (hum_ticks > 0)
    result.vibration_rms_m = std::sqrt(vibration_rms / static_cast<double>(hum_ticks));
  return result;
}

Response response_at(std::span<const Record> records, double frequency_hz,
                     double period_s) noexcept {
  Response response;
  response.frequency_hz = frequency_hz;
  const double ticks_per_turn = 1 / (frequency_hz * period_s);
  const double turns = std::floor(static_cast<double>(records.size()) / ticks_per_turn);
  const auto count = static_cast<std::size_t>(std::lround(turns * ticks_per_turn));
  if (count == 0 || count > records.size())
    return response;
  Vec3 mean{};
  for (const Record& record : records.first(count))
    mean += record.position * (1 / static_cast<double>(count));
  std::complex<double> force, motion;
  for (const Record& record : records.first(count)) {
    const double angle = 2 * std::numbers::pi * frequency_hz * period_s *
                         static_cast<double>(record.index - records.front().index);
    const std::complex<double> turned = std::polar(2 / static_cast<double>(count), -angle);
    force += turned * record.force_n.x;
    motion += turned * (record.position.x - mean.x);
  }
  response.force_n = std::abs(force);
  response.motion_m = std::abs(motion);
  response.phase_rad = std::arg(motion * std::conj(force));
  return response;
}

} // namespace tactus::haptic_check
