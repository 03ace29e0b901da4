#include "core/reed/instrument/valve_bore_step.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace tactus::reed {
namespace {

/// A valve on a lossless cylinder whose round trip takes a whole number of samples, nobody blowing.
class ClosedSystem {
public:
  ClosedSystem(const Parameters& p, double rate, int delay) {
    design_.set(p, rate);
    constants_ = ValveConstants::from(p, design_, rate);
    coefficients_ =
        ReedCoefficients<double>::at(constants_, 2 * std::numbers::pi * p.reed_frequency);
    line_.assign(static_cast<std::size_t>(delay), 0.0);
  }

  ValveState<double>& state() { return state_; }
  std::vector<double>& line() { return line_; }

  void step() {
    const double mouth = 0;
    double wave = -line_[at_], deflection, bore, flow;
    const ValveSignals<double> signal{&mouth, nullptr, &wave, &deflection, &bore, &flow};
    if (constants_.swinging)
      step_valve<true, false, false>(constants_, &coefficients_, 0, state_, signal, 1);
    else
      step_valve<false, false, false>(constants_, &coefficients_, 0, state_, signal, 1);
    line_[at_] = wave;
    at_ = (at_ + 1) % line_.size();
  }

  /// Spring and mass (the coefficients of the step), the waves under way, and the air in the
  /// channel.
  [[nodiscard]] double energy() const {
    const double v = state_.velocity(), x = state_.deflection();
    double sum = 0.25 * constants_.period * coefficients_.momentum * v * v +
                 0.5 * coefficients_.stiffness * x * x;
    for (const double p : line_)
      sum += constants_.period / design_.impedance() * p * p;
    return sum;
  }
  [[nodiscard]] const ValveConstants& constants() const { return constants_; }

private:
  BoreDesign design_;
  ValveConstants constants_;
  ReedCoefficients<double> coefficients_;
  ValveState<double> state_;
  std::vector<double> line_;
  std::size_t at_ = 0;
};

TEST_CASE("two hundred random valves on a lossless bore never gain energy by themselves") {
  std::mt19937 random(7);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<>(0, 1)(random));
  };
  double worst = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Parameters p;
    p.type = static_cast<ValveType>(trial % 3);
    p.rest_angle = between(0.005, 0.1) * (p.type == ValveType::kClosed ? -1 : 1);
    p.arm_length = between(3e-3, 3e-2);
    p.mass = between(1e-7, 1e-4);
    p.reed_frequency = between(50, 9000);
    p.quality = between(0.5, 1e3);
    p.width = between(1e-3, 3e-2);
    p.mouth_length = p.bore_length = between(5e-4, 2e-2);
    p.channel_length = 0; // no air in the channel that could hold energy
    p.restitution = trial % 2;
    p.input_radius = between(1e-3, 2e-2);
    p.displacement_limit = between(1e-3, 1e-2);
    ClosedSystem system(p, 48000, 20 + trial);
    const double wide = system.constants().highest - system.constants().lowest;
    system.state().move(system.constants().lowest + 0.9 * wide, wide * p.reed_frequency);
    for (double& wave : system.line())
      wave = std::normal_distribution<>(0, 300)(random);
    const double start = system.energy();
    double before = start;
    for (int n = 0; n < 4000; ++n) {
      system.step();
      const double now = system.energy();
      worst = std::max(worst, (now - before) / start);
      before = now;
    }
    CHECK(before < start);
  }
  CAPTURE(worst);
  CHECK(worst < 1e-10); // rounding
}

TEST_CASE("the free valve without damping keeps its energy to rounding") {
  Parameters p;
  p.type = ValveType::kSwinging;
  p.rest_angle = 0.0;
  p.quality = 1e18;
  p.sweep = false;
  p.bore_length = p.mouth_length = 0;
  BoreDesign design;
  design.set(p, 48000);
  const ValveConstants c = ValveConstants::from(p, design, 48000);
  const auto r = ReedCoefficients<double>::at(c, 2 * std::numbers::pi * p.reed_frequency);
  ValveState<double> state;
  state.move(1e-4, 0);
  const double start = 0.5 * r.stiffness * 1e-8;
  double mouth = 0, wave = 0, deflection, bore, flow;
  for (int n = 0; n < 48000; ++n) {
    wave = 0;
    step_valve<true, false, false>(c, &r, 0, state,
                                   {&mouth, nullptr, &wave, &deflection, &bore, &flow}, 1);
  }
  const double end = 0.25 * c.period * r.momentum * state.velocity() * state.velocity() +
                     0.5 * r.stiffness * state.deflection() * state.deflection();
  CHECK(std::abs(end / start - 1) < 1e-9);
}

} // namespace
} // namespace tactus::reed
