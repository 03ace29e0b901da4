#include "core/dsp/complex.hpp"
#include "core/dsp/random.hpp"
#include "core/reed/instrument/valve_bore_step.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

// The step of valve, jet and port, sample by sample against its equations as docs/theory/greed.md
// has them: solved here one after the other in the valve's own coordinate (negative towards the
// mouth), with none of the rearrangements that make step_valve quick.

namespace tactus::reed {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Sample {
  double mouth_pressure, incident, reed_frequency,
      noise; // p_m, p-, f_r, share of the jet's pressure
};
struct ValveOutput {
  double angle, bore_pressure, flow, leaving; // theta, p_b, U, p+
};

class ReferenceValve {
public:
  ReferenceValve(const Parameters& parameters, double rate) : p_(parameters), T_(1 / rate) {
    const double celsius = p_.temperature;
    density_ = 1.2929 * 273.15 / (273.15 + celsius);
    const double c = 331.45 * std::sqrt(1 + celsius / 273.15);
    const double area = std::numbers::pi * p_.input_radius * p_.input_radius;
    wave_impedance_ = density_ * c / area;
    inertance_ = p_.shape == BoreShape::kCone ? T_ * area / (2 * density_ * p_.apex_distance) : 0;
    compliance_ = 2 / T_ * p_.cup_volume / (density_ * c * c);
    rest_ =
        std::clamp(p_.arm_length * p_.rest_angle, -p_.displacement_limit, p_.displacement_limit);
    x_ = rest_;
  }

  ValveOutput step(const Sample& in) {
    const double w = p_.width, m = p_.mass, omega = kTwoPi * in.reed_frequency;
    const double k = m * omega * omega;
    // The valve that has, in the midpoint rule, the poles of the one given: s_d = s - s^3 T^2/12
    // of each pole s (paper: the one given).
    double mass = m, damping = m * omega / p_.quality;
    if (p_.flow != FlowMethod::kPaper) {
      const Complex gamma = 0.5 * omega / p_.quality;
      const auto pole = -gamma + sqrt(gamma * gamma - omega * omega);
      const auto other = -gamma - sqrt(gamma * gamma - omega * omega);
      const auto moved = [&](Complex s) { return s - s * s * s * T_ * T_ / 12.0; };
      const double turn = omega * T_;
      // One term more of the series of an undamped valve: tan^2 x/x^2 = 1 + 2 x^2/3 + 17 x^4/45.
      const double product = (1.0 - (pole * pole + other * other).real() * T_ * T_ / 12) +
                             17.0 / 720 * std::pow(turn, 4);
      const double sum = -(moved(pole) + moved(other)).real() / (omega / p_.quality);
      mass = m / std::max(product, 0.5);
      damping = mass * omega / p_.quality * std::max(sum, 0.5);
    }
    const double mobility = 1 / (2 * mass / T_ + damping + 0.5 * k * T_);
    const double base = v_ * 2 * mass / T_ - k * (x_ - rest_);
    const double swept = p_.sweep ? w * p_.bore_length : 0;
    const double mouth = in.mouth_pressure + in.noise * 0.5 * density_ * u_ * u_;

    double side = 1;
    const double area = w * opening(side) + p_.leak_area;
    const double lift = side * w * p_.flow_length;
    const auto push = [&](double u) { // of mouth and flow on the valve
      return w * p_.mouth_length * mouth + lift * (mouth - 0.5 * density_ * u * u);
    };
    // What the jet will be in the middle of the step, before it is known.
    const double expected = p_.flow == FlowMethod::kPaper ? u_ : u_ + 0.5 * (u_ - mean_u_);

    const double admittance = 1 / wave_impedance_ + inertance_ + compliance_;
    const double given = 2 * in.incident / wave_impedance_ - inertance_flow_ - inertance_ * bore_ +
                         compliance_ * bore_ + compliance_flow_;
    // The valve moves with v = mobility (base + push - w lambda_b p_b): seen from the port a source
    // and an admittance, p_b = h + Z U.
    const double impedance = 1 / (admittance + swept * w * p_.bore_length * mobility);
    const double open = impedance * (given + swept * mobility * (base + push(expected)));
    double u = 0, flow = 0;
    jet(mouth, area, impedance, open, u, flow);
    // With the jet known, both from what it does now.
    double bore = impedance * (given + flow + swept * mobility * (base + push(u)));
    const double mean = mobility * (base + push(u) - w * p_.bore_length * bore);
    double x = x_ + T_ * mean, v = 2 * mean - v_;

    const double low = p_.type == ValveType::kOpen ? 0 : -p_.displacement_limit;
    const double high = p_.type == ValveType::kClosed ? 0 : p_.displacement_limit;
    if (x < low || x > high) { // a wall that moves at `contact` until the sample's end
      const double wall = std::clamp(x, low, high), contact = (wall - x_) / T_;
      const double rebound = p_.restitution * (2 * contact - v_);
      v = x < low ? std::max(rebound, 0.0) : std::min(rebound, 0.0);
      x = wall;
      jet(mouth, area, 1 / admittance, (given + swept * contact) / admittance, u, flow);
      bore = (given + swept * contact + flow) / admittance;
      ++contacts;
    }
    inertance_flow_ += inertance_ * (bore + bore_);
    compliance_flow_ = compliance_ * (bore - bore_) - compliance_flow_;
    bore_ = bore, u_ += (u - u_) / theta(), mean_u_ = u, flow_ = flow, x_ = x, v_ = v;
    return {x / p_.arm_length, bore, flow, bore - in.incident};
  }

  int contacts = 0, crossings = 0, closings = 0;

private:
  /// H, the mean over the straight way from x to x + T v, and where it lies.
  double opening(double& side) {
    const double from = x_, to = x_ + T_ * v_;
    if (p_.type == ValveType::kSwinging) {
      if (from * to < 0) {
        ++crossings;
        side = (std::abs(to) - std::abs(from)) / (to - from);
        return (from * from + to * to) / (2 * std::abs(to - from));
      }
      side = from + to < 0 ? -1 : 1;
      return 0.5 * std::abs(from + to);
    }
    side = p_.type == ValveType::kClosed ? -1 : 1;
    const double before = side * from, after = side * to;
    if (after >= 0)
      return 0.5 * (before + after);
    ++closings;
    return before > 0 ? before * before / (2 * (before - after)) : 0;
  }

  /// Weight of the end of the step in its mean u: 1/2, but for channels that settle in less than
  /// a sample or so.
  [[nodiscard]] double theta() const {
    const double samples = p_.channel_length / (60 * T_);
    return p_.flow == FlowMethod::kPaper ? 1 : 0.5 + 0.5 / (1 + 36 * samples * samples);
  }

  /// p_m - p_b = rho lambda u' + (rho/2) u|u|, p_b = h + Z A u, with u the mean over the step and
  /// u' T = (u - u_old)/theta: bisection, for the left side grows with u. Or the paper's explicit
  /// rule.
  void jet(double mouth, double area, double impedance, double open, double& u,
           double& flow) const {
    if (p_.flow == FlowMethod::kPaper) {
      const double channel = std::max(p_.channel_length, impedance * area * T_ / density_);
      flow = flow_ +
             T_ * ((mouth - bore_) * area / (channel * density_) -
                   flow_ * std::abs(flow_) / (2 * channel * area + std::abs(flow_) * T_ + 1e-30));
      u = flow / (area + 1e-9);
      return;
    }
    const double inertia = density_ * p_.channel_length / (theta() * T_);
    const auto lacking = [&](double v) {
      return mouth - open - impedance * area * v - inertia * (v - u_) -
             0.5 * density_ * v * std::abs(v);
    };
    double low = -1e5, high = 1e5;
    for (int i = 0; i < 120; ++i) {
      const double middle = 0.5 * (low + high);
      (lacking(middle) > 0 ? low : high) = middle;
    }
    u = 0.5 * (low + high);
    flow = area * u;
  }

  Parameters p_;
  double T_, density_, wave_impedance_, inertance_, compliance_, rest_;
  double x_, v_ = 0, u_ = 0, mean_u_ = 0, flow_ = 0, bore_ = 0, inertance_flow_ = 0,
             compliance_flow_ = 0;
};

/// step_valve in stretches of at most 64 samples.
std::vector<ValveOutput> run_step_valve(const Parameters& p, double rate,
                                        const std::vector<Sample>& samples, bool moving) {
  BoreDesign bore;
  bore.set(p, rate);
  const auto constants = ValveConstants::from(p, bore, rate);
  ValveState<double> state;
  std::vector<ValveOutput> found;
  const bool noisy = p.breath_noise > 0;
  for (std::size_t done = 0; done < samples.size();) {
    const std::size_t count = std::min<std::size_t>(1 + done % 64, samples.size() - done);
    std::vector<double> mouth, wave, angle(count), pressure(count), flow(count), noise;
    std::vector<ReedCoefficients<double>> coefficients;
    for (std::size_t i = 0; i < count; ++i) {
      const Sample& s = samples[done + i];
      mouth.push_back(s.mouth_pressure);
      wave.push_back(s.incident);
      noise.push_back(s.noise);
      coefficients.push_back(ReedCoefficients<double>::at(constants, kTwoPi * s.reed_frequency));
    }
    const ValveSignals<double> signal{mouth.data(),    noisy ? noise.data() : nullptr,
                                      wave.data(),     angle.data(),
                                      pressure.data(), flow.data()};
    const int n = static_cast<int>(count), stride = moving ? 1 : 0;
    const bool paper = p.flow == FlowMethod::kPaper;
    const auto* c = coefficients.data();
    if (p.type == ValveType::kSwinging)
      paper ? step_valve<true, true, false>(constants, c, stride, state, signal, n)
            : step_valve<true, false, false>(constants, c, stride, state, signal, n);
    else if (paper)
      step_valve<false, true, false>(constants, c, stride, state, signal, n);
    else if (constants.plain_port() && !moving && !noisy)
      step_valve<false, false, true>(constants, c, stride, state, signal, n);
    else
      step_valve<false, false, false>(constants, c, stride, state, signal, n);
    for (std::size_t i = 0; i < count; ++i)
      found.push_back({angle[i], pressure[i], flow[i], wave[i]});
    done += count;
  }
  return found;
}

Parameters random_instrument(Random& random) {
  const auto in = [&random](double low, double high) {
    return low * std::pow(high / low, random.uniform());
  };
  const auto perhaps = [&random](double value) { return random.uniform() < 0.5 ? value : 0.0; };
  Parameters p;
  p.type = static_cast<ValveType>(random.next() % 3);
  p.rest_angle = in(0.01, 0.06);
  if (p.type == ValveType::kClosed || (p.type == ValveType::kSwinging && random.uniform() < 0.3))
    p.rest_angle = -p.rest_angle;
  p.arm_length = in(5e-3, 1.5e-2);
  p.mass = in(2e-6, 1e-4);
  p.reed_frequency = in(150, 3000);
  p.quality = in(1, 8);
  p.width = in(5e-3, 1.5e-2);
  p.mouth_length = in(1e-3, 8e-3);
  p.bore_length = in(1e-3, 8e-3);
  p.flow_length = perhaps(in(5e-4, 3e-3));
  p.channel_length = in(5e-4, 4e-3);
  p.leak_area = perhaps(in(1e-7, 1e-6));
  p.restitution = perhaps(random.uniform());
  p.displacement_limit = in(5e-4, 3e-3);
  p.sweep = random.uniform() < 0.8;
  p.shape = random.uniform() < 0.5 ? BoreShape::kCone : BoreShape::kCylinder;
  p.input_radius = in(3e-3, 1e-2);
  p.apex_distance = in(0.05, 0.4);
  p.cup_volume = perhaps(in(5e-7, 5e-6));
  p.temperature = 40 * random.uniform();
  p.flow = random.uniform() < 0.25 ? FlowMethod::kPaper : FlowMethod::kImplicit;
  p.breath_noise = perhaps(0.1);
  return clamped(p);
}

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

} // namespace

TEST_CASE("the valve's quick step solves the plain equations of valve, jet and port") {
  Random random(77);
  int contacts = 0, crossings = 0, closings = 0, plain = 0, rebound_count = 0;
  for (int round = 0; round < 500; ++round) {
    const Parameters p = random_instrument(random);
    const double rate = round % 2 ? 48000 : 192000;
    const bool moving = round % 3 == 0;
    std::vector<Sample> samples;
    // A mouth pressure and waves from the bore with steps and noise, so that valves beat and part.
    double pressure = 0, wave = 0;
    for (int n = 0; n < 150; ++n) {
      if (n % 30 == 0)
        pressure = 12000 * (random.uniform() - 0.3);
      wave = 0.9 * wave + 800 * random.normal();
      samples.push_back({pressure, wave, p.reed_frequency * (moving ? 1 + 1e-3 * n : 1.0),
                         p.breath_noise > 0 ? 0.2 * random.normal() : 0.0});
    }
    ReferenceValve valve(p, rate);
    const std::vector<ValveOutput> found = run_step_valve(p, rate, samples, moving);
    double worst = 0;
    ValveOutput largest{1e-6, 1, 1e-9, 1};
    for (std::size_t n = 0; n < samples.size(); ++n) {
      const ValveOutput expected = valve.step(samples[n]);
      if (!(std::abs(expected.flow) < 1)) // m^3/s: the paper's explicit rule has become unstable
        break;
      largest = {std::max(largest.angle, std::abs(expected.angle)),
                 std::max(largest.bore_pressure, std::abs(expected.bore_pressure)),
                 std::max(largest.flow, std::abs(expected.flow)),
                 std::max(largest.leaving, std::abs(expected.leaving))};
      worst = std::max(
          {worst, std::abs(found[n].angle - expected.angle) / largest.angle,
           std::abs(found[n].bore_pressure - expected.bore_pressure) / largest.bore_pressure,
           std::abs(found[n].flow - expected.flow) / largest.flow,
           std::abs(found[n].leaving - expected.leaving) / largest.leaving});
    }
    CAPTURE(round);
    CAPTURE(static_cast<int>(p.type));
    CAPTURE(static_cast<int>(p.flow));
    CAPTURE(moving);
    CHECK(worst < 1e-7); // rounding, which a swinging valve in its own jet amplifies
    contacts += valve.contacts;
    rebound_count += valve.contacts > 0 && p.restitution > 0;
    crossings += valve.crossings;
    closings += valve.closings;
    plain += p.flow == FlowMethod::kImplicit && !moving && p.breath_noise == 0 &&
             p.type != ValveType::kSwinging && p.shape == BoreShape::kCylinder &&
             p.cup_volume == 0 && p.flow_length == 0;
  }
  CHECK(contacts > 1000);
  CHECK(crossings > 100);
  CHECK(closings > 100);
  CHECK(rebound_count > 30);
  CHECK(plain > 3);
}

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
    for (int n = 0; n < 2000; ++n) {
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
  p.rest_angle = 0;
  p.quality = 1e18;
  p.sweep = false;
  p.bore_length = p.mouth_length = 0;
  ClosedSystem system(p, 48000, 20);
  system.state().move(1e-4, 0);
  const double start = system.energy();
  for (int n = 0; n < 48000; ++n)
    system.step();
  CHECK(std::abs(system.energy() / start - 1) < 1e-9);
}

} // namespace tactus::reed
