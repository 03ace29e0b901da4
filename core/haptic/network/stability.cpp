#include "core/haptic/network/stability.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactus::haptic {
namespace {
constexpr double kSampleRate_hz = 48000; // lowest sample rate of pickups
}

StepBound max_stable_step(const Network& network) {
  struct Row {
    double stiffness = 0, damping = 0;
  };
  std::vector<Row> rows(network.masses.size());
  for (const NetworkLink& link : network.links) {
    const double damping = std::max(link.damping_n_s_per_m, link.transverse_damping_n_s_per_m);
    const auto add = [&](std::size_t mass, std::size_t other) {
      const double ends = network.masses[other].fixed ? 1 : 2;
      rows[mass].stiffness += ends * link.stiffness_n_per_m;
      rows[mass].damping += ends * damping;
    };
    add(link.a, link.b);
    add(link.b, link.a);
  }
  StepBound bound{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NetworkMass& mass = network.masses[i];
    if (mass.fixed)
      continue;
    const double a =
        (rows[i].stiffness + network.touch.stiffness_n_per_m + network.grab.stiffness_n_per_m) /
        mass.mass_kg;
    const double c =
        (rows[i].damping + network.touch.damping_n_s_per_m + network.grab.damping_n_s_per_m) /
            mass.mass_kg +
        network.drag_per_s;
    // Solves a h^2 + 2 c h = 4, in the form without cancellation.
    const double step_s = a + c > 0 ? 4 / (c + std::sqrt(c * c + 4 * a)) : bound.step_s;
    if (step_s < bound.step_s)
      bound = {step_s, i};
  }
  return bound;
}

NetworkSteps steps_per_tick(const Network& network, double max_step_s, double period_s) noexcept {
  const double load = std::max(1.0, static_cast<double>(network.links.size()) +
                                        0.25 * static_cast<double>(network.masses.size()));
  const double max_steps = std::min(std::floor(kMaxNetworkWork / load), 1.0 * kMaxStepsPerTick);
  const double min_steps = std::max(1.0, std::ceil(period_s / (kStepMargin * max_step_s) - 1e-9));
  const double desired_steps = std::max(1.0, std::floor(network.rate_hz * period_s + 0.5));
  double steps = std::max(min_steps, std::min(desired_steps, max_steps));
  const double stride = std::max(1.0, std::floor(steps / (period_s * kSampleRate_hz) + 1e-9));
  steps = std::floor(steps / stride) * stride < min_steps ? std::ceil(steps / stride) * stride
                                                          : std::floor(steps / stride) * stride;
  if (!(steps <= max_steps))
    return {};
  return {static_cast<int>(steps), static_cast<int>(stride)};
}

} // namespace tactus::haptic
