#include "core/haptic/servo.hpp"
#include "core/haptic/simulated_device.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace tactus::haptic;

namespace {

/// A wall of stiffness K in x > 0, rendered by a sampled servo: the textbook case in which a hold
/// creates energy.
struct SampledWall final : LocalModel {
  explicit SampledWall(double k) : stiffness(k) {}
  Vec3 force(const Tick&, const State& state) noexcept override {
    return {state.position.x > 0 ? -stiffness * state.position.x : 0.0, 0, 0};
  }
  double stiffness;
};

/// The simulated handle with a person who pushes with a constant force besides.
struct PushedDevice final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return device.caps(); }
  bool read(const Tick& tick, State& state) noexcept override { return device.read(tick, state); }
  bool write(const Vec3& force) noexcept override { return device.write(force + push); }
  SimulatedDevice device;
  Vec3 push;
};

struct Rig {
  Rig(double stiffness, bool observer, double limit_n = 8) : wall(stiffness) {
    SimulatedDevice::Settings settings;
    settings.hand.hold = HandSettings::Hold::kFree;
    settings.stops = false;
    device.device.set(settings);
    ServoSettings servo_settings;
    servo_settings.chain.passivity = observer;
    servo_settings.chain.slew_n_per_s = 1e9;
    servo_settings.chain.force_limit_n = limit_n;
    servo_settings.chain.tank_j = 1e6;
    servo.exchange().settings.write(servo_settings);
    servo.attach(device, &wall);
  }
  void tick() {
    servo.step({index, static_cast<double>(index) * 1e-3, 1e-3});
    ++index;
  }
  [[nodiscard]] double x() const { return device.device.position().x; }
  [[nodiscard]] double v() const { return device.device.velocity().x; }

  SampledWall wall;
  PushedDevice device;
  Servo servo;
  std::uint64_t index = 0;
};

struct Flight {
  double arrival = 0, exit = 0, after_ten = 0, energy_after_ten = 0, lowest = 0;
};

Flight fly(double stiffness, bool observer) {
  Rig rig(stiffness, observer);
  rig.device.device.place({-0.01, 0, 0}, {0.2, 0, 0});
  Flight flight;
  bool inside = false;
  int since_exit = -1;
  for (int n = 0; n < 2000 && since_exit < 10; ++n) {
    const double before = rig.v();
    rig.tick();
    if (since_exit >= 0)
      ++since_exit;
    if (!inside && rig.x() > 0) {
      flight.arrival = before;
      inside = true;
    }
    if (inside && since_exit < 0 && rig.x() <= 0) {
      flight.exit = -rig.v();
      since_exit = 0;
    }
  }
  flight.after_ten = -rig.v();
  flight.energy_after_ten = rig.servo.chain().energy_j;
  flight.lowest = rig.servo.chain().lowest_energy_j;
  return flight;
}

struct Push {
  double peak_to_peak_m = 0, fastest = 0, middle_m = 0, energy = 0, lowest = 0;
};

Push push(double stiffness, bool observer) {
  Rig rig(stiffness, observer);
  rig.device.push = {1, 0, 0};
  rig.device.device.place({-0.002, 0, 0}, {});
  double low = 1, high = -1;
  Push result;
  for (int n = 0; n < 4000; ++n) {
    rig.tick();
    if (n < 3000)
      continue;
    low = std::min(low, rig.x());
    high = std::max(high, rig.x());
    result.fastest = std::max(result.fastest, std::abs(rig.v()));
  }
  result.peak_to_peak_m = high - low;
  result.middle_m = 0.5 * (high + low);
  result.energy = rig.servo.chain().energy_j;
  result.lowest = rig.servo.chain().lowest_energy_j;
  return result;
}

} // namespace

TEST_CASE("a handle that flies into a wall five times too stiff does not come out faster") {
  const Flight off = fly(5000, false), on = fly(5000, true);
  MESSAGE("K 5000, arrival " << off.arrival << " m/s; observer off: exit " << off.exit << " m/s, E "
                             << off.lowest << " J; on: exit " << on.exit << ", ten ticks later "
                             << on.after_ten << ", lowest E " << on.lowest << ", E then "
                             << on.energy_after_ten);
  CHECK(off.exit >= 1.10 * off.arrival);
  CHECK(on.exit <= 1.005 * on.arrival);
  CHECK(on.energy_after_ten >= -1e-9);
}

TEST_CASE("into a soft wall too the observer takes back the energy of the hold") {
  const Flight off = fly(500, false), on = fly(500, true);
  MESSAGE("K 500, arrival " << off.arrival << "; off: exit " << off.exit << ", E " << off.lowest
                            << "; on: exit " << on.exit << ", lowest E " << on.lowest);
  CHECK(on.exit < off.exit);
  CHECK(off.lowest < -5e-5);
  CHECK(on.energy_after_ten >= -1e-9);
}

TEST_CASE("a constant push on a wall five times too stiff: the observer shrinks the limit cycle") {
  const Push off = push(5000, false), on = push(5000, true);
  MESSAGE("K 5000, push 1 N, last second: off p-p "
          << off.peak_to_peak_m * 1e3 << " mm, " << off.fastest << " m/s, E " << off.energy
          << "; on p-p " << on.peak_to_peak_m * 1e3 << " mm, " << on.fastest << " m/s, lowest E "
          << on.lowest);
  CHECK(off.peak_to_peak_m > 5e-3);
  CHECK(on.peak_to_peak_m < 1.5e-3);
}

TEST_CASE("a constant push on a wall within Colgate's limit rests at F/K") {
  const Push off = push(500, false), on = push(500, true);
  MESSAGE("K 500: off p-p " << off.peak_to_peak_m * 1e3 << " mm about " << off.middle_m * 1e3
                            << "; on " << on.peak_to_peak_m * 1e3 << " about "
                            << on.middle_m * 1e3);
  CHECK(off.middle_m == doctest::Approx(2e-3).epsilon(0.01));
  CHECK(on.middle_m == doctest::Approx(2e-3).epsilon(0.01));
  CHECK(on.peak_to_peak_m <= off.peak_to_peak_m);
}

TEST_CASE("Colgate's bound K < 2(B + b)/T separates decay from growth") {
  // At T = 1 ms and B = 0.5 Ns/m the bound is 1000 N/m. A handle that never leaves the wall (here
  // a spring about zero) swings down below the bound and up above it.
  struct Spring final : LocalModel {
    explicit Spring(double k) : stiffness(k) {}
    Vec3 force(const Tick&, const State& s) noexcept override { return s.position * -stiffness; }
    double stiffness;
  };
  for (const double stiffness : {700.0, 1300.0}) {
    Rig rig(0, false);
    Spring spring(stiffness);
    rig.servo.attach(rig.device, &spring);
    rig.device.device.place({1e-3, 0, 0}, {});
    double early = 0, late = 0;
    for (int n = 0; n < 3000; ++n) {
      rig.tick();
      (n < 1000 ? early : late) = std::max(n < 1000 ? early : late, std::abs(rig.x()));
      if (n == 1999)
        late = 0;
    }
    CAPTURE(stiffness);
    CHECK((late > early) == (stiffness > 1000));
  }
}

TEST_CASE("more slots of damping raise the stable stiffness") {
  // With damp 4 the bound is 2(0.5 + 4)/1 ms = 9000 N/m, so 5000 N/m rests.
  Rig rig(5000, false);
  ServoSettings settings;
  settings.chain.passivity = false;
  settings.chain.slew_n_per_s = 1e9;
  settings.chain.force_limit_n = 1e6;
  settings.chain.damping_n_s_per_m = 4;
  rig.servo.exchange().settings.write(settings);
  rig.device.push = {1, 0, 0};
  double low = 1, high = -1;
  for (int n = 0; n < 4000; ++n) {
    rig.tick();
    if (n < 3000)
      continue;
    low = std::min(low, rig.x());
    high = std::max(high, rig.x());
  }
  CHECK(high - low < 1e-6);
  CHECK(high == doctest::Approx(1.0 / 5000).epsilon(1e-3));
}

TEST_CASE("guidance by a patch reaches the hand with an allowance and is braked away without") {
  // 1 N on a hand of 200 N/m: 5 mm at rest.
  const auto guided = [](double allowance_w) {
    SimulatedDevice device;
    Servo servo;
    ServoSettings settings;
    settings.chain.allowance_w = allowance_w;
    servo.exchange().settings.write(settings);
    servo.attach(device);
    for (std::uint64_t k = 0; k < 3000; ++k) {
      const double now = static_cast<double>(k) * 1e-3;
      Command c;
      c.force_n = {k < 100 ? 0.0 : 1.0, 0, 0};
      c.number = k + 1;
      c.heartbeat_s = now;
      servo.exchange().commands.write(c);
      servo.step({k, now, 1e-3});
    }
    return device.position().x;
  };
  const double strict = guided(0), generous = guided(0.05);
  MESSAGE("1 N of guidance on 200 N/m: " << strict * 1e3 << " mm without an allowance, "
                                         << generous * 1e3 << " mm with 50 mW");
  CHECK(strict < 0.5e-3);
  CHECK(generous == doctest::Approx(5e-3).epsilon(1e-3));
}

TEST_CASE("a stiff wall that a patch renders a tick late stays tame with the default allowance") {
  const auto peak_to_peak = [](bool observer, double allowance_w) {
    Rig rig(0, observer);
    ServoSettings settings;
    settings.chain.passivity = observer;
    settings.chain.allowance_w = allowance_w;
    rig.servo.exchange().settings.write(settings);
    rig.device.push = {1, 0, 0};
    rig.device.device.place({-0.002, 0, 0}, {});
    double low = 1, high = -1;
    for (int n = 0; n < 4000; ++n) {
      Command c;
      c.force_n = {rig.x() > 0 ? -2000 * rig.x() : 0.0, 0, 0};
      c.number = rig.index + 1;
      c.heartbeat_s = static_cast<double>(rig.index) * 1e-3;
      rig.servo.exchange().commands.write(c);
      rig.tick();
      if (n < 3000)
        continue;
      low = std::min(low, rig.x());
      high = std::max(high, rig.x());
    }
    return high - low;
  };
  const double off = peak_to_peak(false, 0), strict = peak_to_peak(true, 0),
               allowed = peak_to_peak(true, 0.05);
  MESSAGE("patch wall of 2000 N/m, push 1 N: p-p " << off * 1e3 << " mm without observer, "
                                                   << strict * 1e3 << " with, " << allowed * 1e3
                                                   << " with and 50 mW");
  CHECK(strict < off);
  CHECK(allowed < off);
}
