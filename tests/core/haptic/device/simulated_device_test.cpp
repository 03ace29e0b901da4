#include "core/haptic/device/simulated_device.hpp"

#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
using tactus::Vec3;
using test::approx;
using Hold = HandSettings::Hold;

namespace {

struct Sim {
  explicit Sim(const SimulatedDevice::Settings& settings, double period = 1e-3) : period_s(period) {
    device.set(settings);
    advance(0);
  }
  State advance(int ticks, const Vec3& force = {}) {
    State state;
    for (int i = 0; i <= ticks; ++i) {
      REQUIRE(device.read({index, static_cast<double>(index) * period_s, period_s}, state));
      REQUIRE(device.write(force));
      if (i < ticks)
        ++index;
    }
    return state;
  }
  SimulatedDevice device;
  double period_s;
  std::uint64_t index = 0;
};

SimulatedDevice::Settings held(Hold hold) {
  SimulatedDevice::Settings settings;
  settings.stops = false;
  settings.hand.hold = hold;
  return settings;
}

struct XV {
  double x, v;
};

/// The same mass on a spring by Runge and Kutta's method, many steps: the independent reference.
XV runge_kutta(double mass, double k, double b, double force, double time, int steps) {
  double x = 0, v = 0;
  const double h = time / steps;
  const auto acceleration = [&](double p, double u) { return (force - k * p - b * u) / mass; };
  for (int i = 0; i < steps; ++i) {
    const double k1x = v, k1v = acceleration(x, v);
    const double k2x = v + h / 2 * k1v, k2v = acceleration(x + h / 2 * k1x, v + h / 2 * k1v);
    const double k3x = v + h / 2 * k2v, k3v = acceleration(x + h / 2 * k2x, v + h / 2 * k2v);
    const double k4x = v + h * k3v, k4v = acceleration(x + h * k3x, v + h * k3v);
    x += h / 6 * (k1x + 2 * k2x + 2 * k3x + k4x);
    v += h / 6 * (k1v + 2 * k2v + 2 * k3v + k4v);
  }
  return {x, v};
}

} // namespace

TEST_CASE("a constant force moves the free handle as the closed form says") {
  // v = F/B (1 - e^(-Bt/M)), x = F/B (t - M/B (1 - e^(-Bt/M))) with M = 0.1 kg and B = 0.5 N s/m.
  Sim sim(held(Hold::kFree));
  sim.advance(0, {1, 0, 0});
  for (const int tick : {1, 10, 100, 1000}) {
    const State state = sim.advance(tick - static_cast<int>(sim.index), {1, 0, 0});
    const double t = tick * 1e-3, decay = -std::expm1(-5 * t);
    CHECK(state.velocity.x == approx(2 * decay).epsilon(1e-11));
    CHECK(state.position.x == approx(2 * (t - 0.2 * decay)).epsilon(1e-11));
  }
}

TEST_CASE("a constant force against the hand's spring gives the reference series") {
  Sim sim(held(Hold::kSpring));
  sim.advance(0, {1, 0, 0});
  for (const auto& [tick, x] : {std::pair{1, 4.957767456e-06},
                                {10, 4.533126135e-04},
                                {50, 5.804718946e-03},
                                {100, 5.963196138e-03},
                                {1000, 4.999995309e-03}}) {
    const State state = sim.advance(tick - static_cast<int>(sim.index), {1, 0, 0});
    CHECK(state.position.x == approx(x).epsilon(1e-9));
  }
}

TEST_CASE("the exact step agrees with a fine integration over the whole range of parameters") {
  // Stiff, soft, light, heavy, over- and underdamped, with coinciding modes (K = B^2/4M).
  const struct {
    double mass, k, b, period;
  } cases[] = {{0.1, 200, 2.5, 1e-3}, {0.1, 1e-6, 0, 1e-3},  {0.01, 2e4, 20, 5e-3},
               {10, 1e4, 1, 2.5e-4},  {0.1, 1000, 20, 1e-3}, {0.05, 0, 30, 1e-3},
               {0.1, 0, 0, 1e-3}};
  for (const auto& c : cases) {
    const auto step = MassSpringDamperStep::of(c.mass, c.k, c.b, c.period);
    double x = 0, v = 0;
    for (int i = 0; i < 20; ++i)
      step.advance(x, v, 3.0);
    const XV fine = runge_kutta(c.mass, c.k, c.b, 3.0, 20 * c.period, 200000);
    CAPTURE(c.k);
    CHECK(x == doctest::Approx(fine.x).epsilon(1e-10));
    CHECK(v == doctest::Approx(fine.v).epsilon(1e-10));
  }
}

TEST_CASE("a held force does exactly the work that the handle gains or dissipates") {
  auto settings = held(Hold::kFree);
  for (const double viscous : {0.0, 3.0}) {
    settings.viscous_n_s_per_m = viscous;
    Sim sim(settings);
    tactus::Random random(12);
    for (int tick = 0; tick < 2000; ++tick) {
      const Vec3 force{5 * random.normal(), 5 * random.normal(), 5 * random.normal()};
      const Vec3 x = sim.device.position(), v = sim.device.velocity();
      sim.advance(1, force);
      const Vec3 w = sim.device.velocity();
      const double work = dot(force, sim.device.position() - x);
      const double lost = work - 0.05 * (dot(w, w) - dot(v, v));
      const double rounding = 1e-12 * (0.05 * (dot(w, w) + dot(v, v)) + std::abs(work));
      CHECK(lost >= -rounding);
      if (viscous == 0)
        CHECK(lost <= rounding);
    }
  }
}

TEST_CASE("with a moving hand the held values converge at first order in the tick") {
  // Reference: the same with a tick 256 times shorter.
  const auto end = [](int divide) {
    Sim sim(held(Hold::kSpring), 1e-3 / divide);
    sim.device.set_path(LissajousPath{{}, {0.02, 0, 0}, {3, 0, 0}});
    return sim.advance(200 * divide).position.x;
  };
  const double reference = end(256);
  const double coarse = std::abs(end(1) - reference), fine = std::abs(end(2) - reference),
               finer = std::abs(end(4) - reference);
  CHECK(std::log2(coarse / fine) == doctest::Approx(1).epsilon(0.1));
  CHECK(std::log2(fine / finer) == doctest::Approx(1).epsilon(0.1));
}

TEST_CASE("a rigid hand puts the handle exactly on the path, whatever the force") {
  Sim sim(held(Hold::kRigid));
  const CirclePath circle{{0.01, 0, 0}, 0.02, 0.5, 0, 2};
  sim.device.set_path(circle);
  for (int tick = 1; tick <= 777; ++tick) {
    const State state = sim.advance(1, {30, -30, 30});
    const PathPoint point = circle.at(tick * 1e-3);
    CHECK(state.position == point.position);
    CHECK(state.velocity == point.velocity);
  }
}

TEST_CASE("hard stops bound the handle, return less energy than they get and never pull") {
  SimulatedDevice::Settings settings;
  settings.hand.hold = Hold::kFree;
  Sim sim(settings);
  sim.device.set_state({0.04, 0, 0}, {1, 0, 0});
  double max_position = 0, back = 0;
  for (int tick = 0; tick < 300; ++tick) {
    const State state = sim.advance(1);
    max_position = std::max(max_position, state.position.x);
    back = std::max(back, -state.velocity.x);
  }
  CHECK(max_position < 0.065); // workspace 50, stop at 55 mm, entered at 1 m/s
  CHECK(back < 1.0);
  CHECK(sim.device.position().x < 0.055); // it comes off again
  // A lasting push rests at its equilibrium, F / K beyond the stop.
  CHECK(sim.advance(4000, {8, 0, 0}).position.x == approx(0.055 + 8.0 / 2e4).epsilon(1e-3));
}

TEST_CASE("the same ticks and forces give the same bits, and skipped ticks are simulated") {
  auto settings = held(Hold::kPerson);
  settings.noise_m = 1e-5;
  Sim a(settings), b(settings);
  for (int i = 0; i < 500; ++i) {
    const Vec3 force{std::sin(0.1 * i), 0.5, -0.2};
    CHECK(a.advance(1, force).position == b.advance(1, force).position);
  }
  Sim c(held(Hold::kFree)), d(held(Hold::kFree));
  c.advance(0, {1, 0, 0});
  d.advance(0, {1, 0, 0});
  c.advance(12, {1, 0, 0});
  State state;
  REQUIRE(d.device.read({12, 0.012, 1e-3}, state));
  CHECK(state.position == c.device.position());
}

TEST_CASE("a device starts at its first reading, for any index of the tick") {
  SimulatedDevice device;
  device.set(held(Hold::kFree));
  device.set_state({0.01, 0, 0}, {0.5, 0, 0});
  State state;
  REQUIRE(device.read({7000, 7.0, 1e-3}, state));
  CHECK(state.position == Vec3{0.01, 0, 0});
  CHECK(state.velocity == Vec3{0.5, 0, 0});
  REQUIRE(device.read({7001, 7.001, 1e-3}, state));
  // M v' = -B v for one tick, B/M = 5/s
  CHECK(state.position.x == approx(0.01 + 0.5 * (1 - std::exp(-5e-3)) / 5).epsilon(1e-9));
}

TEST_CASE("the reading has the encoder's step and noise, and then no velocity of its own") {
  auto settings = held(Hold::kRigid);
  settings.resolution_m = 5e-5;
  settings.noise_m = 2e-5;
  Sim sim(settings);
  sim.device.set_path(LinePath{{-0.02, 0, 0}, {0.02, 0, 0}, 2});
  CHECK_FALSE(sim.device.caps().has_velocity);
  CHECK(sim.device.caps().position_noise_m == approx(4.5e-5));
  for (int i = 0; i < 1000; ++i) {
    const State state = sim.advance(1);
    const double steps = state.position.x / 5e-5;
    CHECK(std::abs(steps - std::round(steps)) < 1e-9);
    CHECK(std::abs(state.position.x - sim.device.position().x) <= 4.5e-5 * (1 + 1e-9));
  }
}

TEST_CASE("a latency gives each reading that many ticks later, and the device declares it") {
  SimulatedDevice prompt, late;
  auto settings = held(Hold::kRigid);
  prompt.set(settings);
  settings.latency_ticks = 3;
  late.set(settings);
  CHECK(late.caps().latency_ticks == 3);
  CHECK(prompt.caps().latency_ticks == 0);
  std::vector<State> without;
  for (std::size_t k = 0; k < 100; ++k) {
    State state, now;
    for (auto* device : {&late, &prompt}) {
      if (k == 0)
        device->set_path(LinePath{{0, 0, 0}, {0.02, 0, 0}, 1});
      REQUIRE(
          device->read({k, static_cast<double>(k) * 1e-3, 1e-3}, device == &late ? state : now));
    }
    without.push_back(now);
    CHECK(state.position == without[k < 3 ? 0 : k - 3].position);
    CHECK(state.velocity == without[k < 3 ? 0 : k - 3].velocity);
  }
}

TEST_CASE("a target moves the spring hand smoothly and exactly there") {
  Sim sim(held(Hold::kSpring));
  sim.device.set_target({0.03, -0.01, 0.02});
  double fastest = 0;
  for (int i = 0; i < 3000; ++i)
    fastest = std::max(fastest, norm(sim.advance(1).velocity));
  CHECK(norm(sim.device.position() - Vec3{0.03, -0.01, 0.02}) < 1e-6);
  CHECK(fastest < 1.0);
}

TEST_CASE("a noise oscillator is stationary at any tick, with the spectrum of its equation") {
  // x'' + 2 z w x' + w^2 x = white noise has var x = s^2, var v = (w s)^2, no correlation of x and
  // v at one instant and, with u = w sqrt(1 - z^2), the autocorrelation
  //   s^2 e^(-z w t) (cos u t + z w/u sin u t).
  // A tick of a seventh of the period has strongly correlated noise in both.
  const double hz = 10, rms = 1e-4, z = 0.2, w = 2 * std::numbers::pi * hz;
  for (const double period : {1e-3, 5e-3, 1.4e-2}) {
    CAPTURE(period);
    tactus::Random random(21);
    NoiseOscillator noise;
    noise.set(hz, z, rms, period);
    noise.start(random);
    constexpr std::size_t kCount = 400000;
    std::vector<double> x;
    double vv = 0, xv = 0;
    for (std::size_t n = 0; n < kCount; ++n) {
      noise.advance(random);
      x.push_back(noise.value() / rms);
      const double v = noise.rate() / (w * rms);
      vv += v * v / kCount;
      xv += x.back() * v / kCount;
    }
    // The correlation time 1/(z w) = 80 ms leaves 400 s / 80 ms = 5000 independent values or more,
    // 2 % of standard deviation in the variances; <xv> has less.
    CHECK(vv == doctest::Approx(1).epsilon(0.06));
    CHECK(std::abs(xv) < 0.02);
    for (const double lag_s : {0.0, 0.025, 0.05, 0.1}) { // up to a period
      const auto lag = static_cast<std::size_t>(lag_s / period + 0.5);
      double sum = 0;
      for (std::size_t n = lag; n < kCount; ++n)
        sum += x[n] * x[n - lag] / static_cast<double>(kCount - lag);
      const double t = static_cast<double>(lag) * period, u = w * std::sqrt(1 - z * z);
      CHECK(std::abs(sum - std::exp(-z * w * t) * (std::cos(u * t) + z * w / u * std::sin(u * t))) <
            0.06);
    }
  }
}

TEST_CASE("a person yields to a lasting force at F/(K tau), and stays put without one") {
  auto settings = held(Hold::kPerson);
  settings.hand.tremor_m = settings.hand.wander_m = 0;
  Sim still(settings), pushed(settings);
  still.advance(5000);
  CHECK(norm(still.device.position()) == 0.0);
  pushed.advance(2000, {0.4, 0, 0});
  const double before = pushed.device.position().x;
  pushed.advance(1000, {0.4, 0, 0});
  // 0.4 N / (200 N/m * 1 s) = 2 mm/s
  CHECK(pushed.device.position().x - before == approx(2e-3).epsilon(0.02));

  settings.hand.tremor_m = 1e-4;
  settings.hand.wander_m = 1e-3;
  Sim alone(settings);
  double square = 0;
  for (int i = 0; i < 60000; ++i) {
    alone.advance(1);
    square += dot(alone.device.position(), alone.device.position()) / 3;
  }
  CHECK(std::sqrt(square / 60000) < 4e-3); // RMS on an axis
}

namespace {

/// How far from a goal 20 mm away a person's hand still is when a patch pulls it there with that
/// stiffness: the RMS of the last ticks.
double distance_after(int seconds, int last_ticks, double stiffness_n_per_m, HandSettings hand) {
  ChainSettings chain;
  chain.allowance_w = 0.05;
  test::HostedServo<SimulatedDevice> rig(chain);
  SimulatedDevice::Settings settings;
  settings.hand = hand;
  settings.hand.hold = Hold::kPerson;
  rig.device.set(settings);
  rig.attach();
  const Vec3 goal{0.02, 0, 0};
  double square = 0;
  for (int tick = 0; tick < 1000 * seconds; ++tick) {
    const Vec3 off = goal - rig.device.position();
    rig.step(off * stiffness_n_per_m);
    if (tick >= 1000 * seconds - last_ticks)
      square += dot(off, off) / last_ticks;
  }
  return std::sqrt(square);
}

} // namespace

TEST_CASE("a steady hand is guided to the goal at the rate of its yielding") {
  // In balance K (x - x_h) = k (goal - x), and the intention moves at (x - x_h)/tau: the distance
  // falls as exp(-t k/((K + k) tau)), here exp(-t/6 s), from 20 K/(K + k) = 16.7 mm on.
  HandSettings steady;
  steady.tremor_m = steady.wander_m = 0;
  const double at_6 = distance_after(6, 1, 40, steady), at_12 = distance_after(12, 1, 40, steady);
  CHECK(at_6 == approx(0.02 * 200 / 240 * std::exp(-1.0)).epsilon(0.03));
  CHECK(at_12 / at_6 == approx(std::exp(-1.0)).epsilon(0.01));
}

TEST_CASE("a hand with tremor and wander is guided there too, and stays away without a force") {
  CHECK(distance_after(30, 1000, 40, {}) < 4e-3);
  CHECK(distance_after(30, 1000, 0, {}) > 15e-3);
}

TEST_CASE("absurd forces and settings leave the simulated handle finite") {
  tactus::Random random(77);
  for (int round = 0; round < 100; ++round) {
    SimulatedDevice::Settings settings;
    settings.mass_kg = std::pow(10, -3 + 5 * random.uniform());
    settings.viscous_n_s_per_m = 1000 * random.uniform();
    settings.hand.hold = static_cast<Hold>(random.next() % 4);
    settings.hand.stiffness_n_per_m = 1e5 * random.uniform();
    settings.hand.damping_n_s_per_m = 1e3 * random.uniform();
    settings.stops = random.next() & 1;
    const double period = 1.0 / (200 + 3800 * random.uniform());
    SimulatedDevice device;
    device.set(settings);
    CHECK_FALSE(device.write({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
    for (std::uint64_t tick = 0; tick < 300; ++tick) {
      State state;
      REQUIRE(device.read({tick, static_cast<double>(tick) * period, period}, state));
      REQUIRE(is_finite(state.position));
      REQUIRE(is_finite(state.velocity));
      const double size = random.next() % 10 == 0 ? 1e6 : 40;
      static_cast<void>(device.write({size * random.normal(), size, -size}));
    }
  }
}
