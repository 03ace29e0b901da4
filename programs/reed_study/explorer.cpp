#include "programs/reed_study/explorer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactus::study {
namespace {

/// A straight move of minimum jerk (Flash & Hogan 1985): it covers 10 t^3 - 15 t^4 + 6 t^5 of the
/// path.
haptic::RowPath move(const Vec3& from, const Vec3& to, double duration_s) {
  constexpr double kRow_s = 5e-3;
  const auto rows = static_cast<std::size_t>(std::ceil(duration_s / kRow_s));
  std::vector<haptic::PathRow> path;
  path.reserve(rows + 1);
  for (std::size_t i = 0; i <= rows; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(rows);
    const double progress = t * t * t * (10 - t * (15 - 6 * t));
    path.push_back({t * duration_s, from + (to - from) * progress, 0});
  }
  return haptic::RowPath(std::move(path));
}

} // namespace

haptic::HandSettings Explorer::hand_settings(haptic::HandSettings hand) const {
  const bool wanders = settings_.strategy == Strategy::kWanders;
  hand.hold = haptic::HandSettings::Hold::kPerson;
  hand.wander_m = wanders ? settings_.wander_m : 0; // a searching hand does not also wander
  hand.wander_hz = wanders ? settings_.wander_hz : hand.wander_hz;
  return hand;
}

void Explorer::begin(haptic::SimulatedDevice& device, const Vec3& start, double period_s) const {
  device.set_state(start, {});
  device.set_path(haptic::RowPath({{0, start, 0}}));
  haptic::State state;
  (void)device.read({0, 0, period_s}, state);
  if (settings_.strategy != Strategy::kWanders)
    return;
  const haptic::Workspace& box = device.settings().workspace;
  const Vec3 drift = device.hand_point().position - start;
  device.set_path(haptic::RowPath(
      {{0, start - drift, 0}, {settings_.arrival_s, (box.min + box.max) * 0.5, 0}}));
}

void Explorer::advance(haptic::SimulatedDevice& device, double time_s) {
  if (settings_.strategy == Strategy::kWanders || time_s < next_move_s_)
    return;
  // Starts at the hand's current target position, not at the end point of the last movement.
  const Vec3 from = device.hand_point().position;
  const haptic::Workspace& box = device.settings().workspace;
  Vec3 to = (box.min + box.max) * 0.5;
  to.y = box.min.y + random_.uniform() * (box.max.y - box.min.y);
  to.z = box.min.z + random_.uniform() * (box.max.z - box.min.z);
  const double move_s =
      std::max(norm(to - from) / settings_.speed_m_per_s, settings_.shortest_move_s);
  const double stay_s = settings_.shortest_stay_s +
                        random_.uniform() * (settings_.longest_stay_s - settings_.shortest_stay_s);
  device.set_path(move(from, to, move_s));
  next_move_s_ = time_s + move_s + stay_s;
}

} // namespace tactus::study
