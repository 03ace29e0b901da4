#include "core/reed/playability/linear_stability.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/radiation.hpp"
#include "core/reed/bore/wall_loss.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;
constexpr int kNewtonSteps = 40;
constexpr int kScanPoints = 4096;
constexpr double kHighestPressure = 50e3;
constexpr double kMinFrequencyRatio =
    1e-4; // below this share of the range a root is no oscillation

double square(double x) { return x * x; }

} // namespace

/// Coefficients of the valve in the characteristic function.
struct LinearStability::Valve {
  double jet = 0;          // |u_0|
  double area = 0;         // A_0
  double opening_flow = 0; // u_0 A_1
  double swept = 0;        // w lambda_b when the sweep is on
  double pressure = 0;     // w lambda_b
  double bernoulli = 0;    // sigma mu w u_0
  double mass = 0;
  double frequency = 0; // w_r
  double damping = 0;   // w_r/Q
  bool free = true;
};

LinearStability::LinearStability(const Parameters& parameters, double length_m,
                                 const Termination* end) noexcept
    : parameters_(parameters), air_(air_at(parameters.temperature)), length_(length_m), end_(end) {
  const double area = pi * square(parameters.input_radius);
  characteristic_impedance_ = air_.density * air_.sound_speed / area;
  inertance_ =
      parameters.shape == BoreShape::kCone ? air_.density * parameters.apex_distance / area : 0;
  compliance_ = parameters.cup_volume / (air_.density * square(air_.sound_speed));
  loss_ = wall_loss(parameters, length_m, air_.sound_speed);
  direction_ = parameters.rest_angle < 0 ? -1 : 1;
}

Equilibrium LinearStability::equilibrium(double mouth_pressure,
                                         double reed_frequency_hz) const noexcept {
  const Parameters& p = parameters_;
  const double stiffness = p.mass * square(2 * pi * reed_frequency_hz);
  const double rest = p.arm_length * p.rest_angle;
  const bool stopped = p.type != ValveType::kSwinging;
  // The bore's resistance to steady flow: 0, unless R_0 < 1 replaces the losses.
  const double resistance =
      p.scalar_reflection > 0 && p.scalar_reflection < 1
          ? characteristic_impedance_ * (1 - p.scalar_reflection) / (1 + p.scalar_reflection)
          : 0;
  const auto at = [&](double bore_pressure) {
    Equilibrium e;
    e.bore_pressure = bore_pressure;
    const double drop = mouth_pressure - bore_pressure;
    e.jet_velocity = std::copysign(std::sqrt(2 * std::abs(drop) / air_.density), drop);
    const auto displaced = [&](double side) {
      return rest + p.width *
                        (p.mouth_length * mouth_pressure - p.bore_length * bore_pressure +
                         side * p.flow_length * bore_pressure) /
                        stiffness;
    };
    e.displacement = displaced(direction_);
    if (!stopped && e.displacement * direction_ < 0)
      e.displacement = displaced(-direction_);
    const double open =
        stopped ? std::max(0.0, direction_ * e.displacement) : std::abs(e.displacement);
    e.area = p.width * std::min(open, p.displacement_limit) + p.leak_area;
    e.flow = e.area * e.jet_velocity;
    return e;
  };
  Equilibrium e = at(0);
  if (resistance > 0) {
    double low = std::min(0.0, mouth_pressure), high = std::max(0.0, mouth_pressure);
    for (int i = 0; i < 60; ++i) {
      e = at(0.5 * (low + high));
      (e.bore_pressure > resistance * e.flow ? high : low) = e.bore_pressure;
    }
  }
  const double beyond_stop = stopped ? -direction_ * e.displacement : -1;
  const double beyond_limit = std::abs(e.displacement) - p.displacement_limit;
  e.free = beyond_stop < 0 && beyond_limit <= 0;
  if (beyond_stop >= 0)
    e.excess = beyond_stop / std::max(std::abs(rest), 1e-9);
  else if (beyond_limit > 0)
    e.excess = beyond_limit / p.displacement_limit;
  return e;
}

LinearStability::Value LinearStability::round_trip(Complex s) const noexcept {
  const double transit = 2 * length_ / air_.sound_speed;
  if (parameters_.scalar_reflection > 0) {
    const Complex value = -parameters_.scalar_reflection * math::exp(-transit * s);
    return {value, -transit * value};
  }
  const Complex root = math::sqrt(s);
  if (end_ != nullptr) {
    const double ratio = air_at(20).sound_speed / air_.sound_speed;
    const Termination::Value end = end_->reflectance(ratio * s);
    const double there = transit + 2 * end_->extra_length / air_.sound_speed;
    const Complex propagation = math::exp(-there * s - loss_ * root);
    return {end.value * propagation,
            (ratio * end.derivative - end.value * (there + 0.5 * loss_ / root)) * propagation};
  }
  const double scale = parameters_.end_radius / air_.sound_speed;
  const Complex j = s * scale;
  using End = OpenEnd;
  const Complex numerator = 1.0 + End::kNumerator * j;
  const Complex denominator = 1.0 + j * (End::kFirst + End::kSecond * j);
  const Complex value = -numerator / denominator * math::exp(-transit * s - loss_ * root);
  const Complex logarithmic =
      scale * (End::kNumerator / numerator - (End::kFirst + 2 * End::kSecond * j) / denominator) -
      transit - 0.5 * loss_ / root;
  return {value, value * logarithmic};
}

Complex LinearStability::input_admittance(Complex s) const noexcept {
  const Complex rt = round_trip(s).value;
  Complex y = (1.0 - rt) / ((1.0 + rt) * characteristic_impedance_) + s * compliance_;
  if (inertance_ > 0)
    y += 1.0 / (s * inertance_);
  return y;
}

LinearStability::Valve LinearStability::valve_at(const Equilibrium& state,
                                                 double reed_frequency_hz) const noexcept {
  const Parameters& p = parameters_;
  const double side =
      p.type == ValveType::kSwinging ? (state.displacement < 0 ? -1.0 : 1.0) : direction_;
  Valve v;
  v.free = state.free;
  v.jet = std::abs(state.jet_velocity);
  v.area = state.area;
  v.opening_flow = state.jet_velocity * p.width * side;
  v.pressure = p.width * p.bore_length;
  v.swept = p.sweep ? v.pressure : 0;
  v.bernoulli = side * p.flow_length * p.width * state.jet_velocity;
  v.mass = p.mass;
  v.frequency = 2 * pi * reed_frequency_hz;
  v.damping = v.frequency / p.quality;
  return v;
}

Complex LinearStability::valve_admittance(Complex s, const Equilibrium& state,
                                          double reed_frequency_hz) const noexcept {
  const Valve v = valve_at(state, reed_frequency_hz);
  const Complex jet = v.jet + s * parameters_.channel_length;
  const Complex leak = -v.area / (air_.density * jet);
  if (!v.free)
    return leak;
  const Complex inertia = v.mass * (square(v.frequency) + s * (s + v.damping));
  return leak + (v.opening_flow + s * v.swept) * (-v.pressure + v.bernoulli / jet) / inertia;
}

/// (Y_in - Y_valve) Z_0 (1 + rt) (|u_0| + s lambda) D_v/(m w_r^2), with its derivative. The factors
/// cancel the poles of both admittances, so that every zero is a mode and Newton's iteration meets
/// no pole near the imaginary axis.
LinearStability::Value LinearStability::characteristic(Complex s, const Valve& v) const noexcept {
  const auto product = [](const Value& a, const Value& b) {
    return Value{a.value * b.value, a.derivative * b.value + a.value * b.derivative};
  };
  const Value rt = round_trip(s);
  const Value sum{1.0 + rt.value, rt.derivative};
  Value lumped{s * compliance_, compliance_};
  if (inertance_ > 0) {
    const Complex y = 1.0 / (s * inertance_);
    lumped.value += y;
    lumped.derivative -= y / s;
  }
  const Value jet{v.jet + s * parameters_.channel_length, parameters_.channel_length};
  // Z_0 times the admittance of the valve's opening, times the jet's factor.
  const double channel = characteristic_impedance_ * v.area / air_.density;
  const Value shunt = product(lumped, jet);
  const Value open = product(sum, {characteristic_impedance_ * shunt.value + channel,
                                   characteristic_impedance_ * shunt.derivative});
  const Value wave = product({1.0 - rt.value, -rt.derivative}, jet);
  const Value passive{wave.value + open.value, wave.derivative + open.derivative};
  if (!v.free)
    return passive;

  const double scale = 1 / square(v.frequency);
  const Value valve{1.0 + s * (s + v.damping) * scale, (2.0 * s + v.damping) * scale};
  const Value motion{v.opening_flow + s * v.swept, v.swept};
  const Value force{v.bernoulli - v.pressure * jet.value, -v.pressure * jet.derivative};
  const double gain = characteristic_impedance_ * scale / v.mass;
  const Value feedback = product(sum, product(motion, force));
  const Value whole = product(passive, valve);
  return {whole.value - gain * feedback.value, whole.derivative - gain * feedback.derivative};
}

Mode LinearStability::refine(Complex start, const Valve& valve) const noexcept {
  const double max_step = std::max(pi * air_.sound_speed / length_ / 8, std::abs(start.imag()) / 8);
  Complex s = start;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Value f = characteristic(s, valve);
    Complex step = f.value / f.derivative;
    const double size = math::abs(step);
    if (!(size < 1e300))
      return {};
    if (size > max_step)
      step *= max_step / size;
    s -= step;
    if (s.imag() < 0)
      s = math::conj(s);
    if (size < 1e-10 * math::abs(s))
      return {s.real(), s.imag() / (2 * pi), s.imag() > 0};
  }
  return {};
}

Mode LinearStability::mode_near(double mouth_pressure, double reed_frequency_hz,
                                double frequency_hz) const noexcept {
  return refine({0, 2 * pi * frequency_hz},
                valve_at(equilibrium(mouth_pressure, reed_frequency_hz), reed_frequency_hz));
}

Mode LinearStability::bore_resonance_near(double frequency_hz) const noexcept {
  Valve closed_valve; // no opening: only Y_in remains, times a jet factor without zeros nearby
  closed_valve.free = false;
  closed_valve.jet = 1e6;
  return refine({0, 2 * pi * frequency_hz}, closed_valve);
}

Mode LinearStability::dominant_mode(double mouth_pressure,
                                    double reed_frequency_hz) const noexcept {
  const Valve valve = valve_at(equilibrium(mouth_pressure, reed_frequency_hz), reed_frequency_hz);
  const double spacing = pi * air_.sound_speed / length_;
  const double highest = std::max(2 * valve.frequency, 5 * spacing);
  Mode best;
  const auto consider = [&](Complex start) {
    const Mode mode = refine(start, valve);
    const double frequency = 2 * pi * mode.frequency_hz;
    if (mode.found && frequency > kMinFrequencyRatio * highest && frequency < 1.2 * highest &&
        (!best.found || mode.growth_rate > best.growth_rate))
      best = mode;
  };
  consider({-0.5 * valve.damping, valve.frequency});
  consider({0, valve.frequency});
  // Newton's step is short near a mode. Scan the line of zero growth, and two lines of fast growth,
  // which valves under pressure reach, for minima of the step.
  struct Line {
    double growth, resolution;
  };
  for (const Line line : {Line{0, 8}, Line{0.1 * spacing, 8}, Line{0.3 * spacing, 4}}) {
    double omega = std::min(spacing, valve.frequency) / 16;
    std::array<double, 3> step{1e300, 1e300, 1e300};
    double previous = omega;
    for (int i = 0; i < kScanPoints && omega < highest; ++i) {
      const Value f = characteristic({line.growth, omega}, valve);
      step = {step[1], step[2], math::abs(f.value / f.derivative)};
      if (i >= 2 && step[1] <= step[0] && step[1] <= step[2])
        consider({line.growth, previous});
      previous = omega;
      omega += std::min(spacing, omega) / line.resolution;
    }
  }
  return best;
}

double LinearStability::highest_pressure(double reed_frequency_hz) const noexcept {
  const Parameters& p = parameters_;
  const double stiffness = p.mass * square(2 * pi * reed_frequency_hz);
  const double rest = p.arm_length * p.rest_angle;
  const double end = p.type == ValveType::kClosed ? 0 : p.displacement_limit;
  const double pressure = stiffness * (end - rest) / (p.width * p.mouth_length);
  return std::clamp(pressure * (1 - 1e-9), 1.0, kHighestPressure);
}

Threshold LinearStability::threshold(double reed_frequency_hz, double frequency_hz) const noexcept {
  constexpr int kPressures = 48;
  constexpr int kBisections = 28;
  const double highest = highest_pressure(reed_frequency_hz);
  const double start = frequency_hz > 0 ? bore_resonance_near(frequency_hz).frequency_hz : 0;
  const auto mode_at = [&](double pressure) {
    return frequency_hz > 0 ? mode_near(pressure, reed_frequency_hz, start)
                            : dominant_mode(pressure, reed_frequency_hz);
  };
  double low = highest / 1000;
  for (int i = 1; i <= kPressures; ++i) {
    double high = highest * i / kPressures;
    Mode mode = mode_at(high);
    if (!mode.found || mode.growth_rate <= 0) {
      low = high;
      continue;
    }
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (low + high);
      const Mode there = mode_at(middle);
      if (there.found && there.growth_rate > 0) {
        high = middle;
        mode = there;
      } else {
        low = middle;
      }
    }
    return {high, mode.frequency_hz, true};
  }
  return {};
}

} // namespace tactus::reed
