#include "core/haptic/device/simulated_device.hpp"

#include "tests/core/haptic/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
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

SimulatedDevice::Settings free_handle() {
  SimulatedDevice::Settings settings;
  settings.stops = false;
  settings.hand.hold = Hold::kFree;
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

TEST_CASE("a constant force on the free handle gives the reference series") {
  Sim sim(free_handle());
  const struct {
    int tick;
    double x, v;
  } reference[] = {{1, 4.991677073e-06, 9.975041615e-03},
                   {10, 4.917698003e-04, 9.754115100e-02},
                   {100, 4.261226389e-02, 7.869386806e-01},
                   {1000, 1.602695179, 1.986524106}};
  int at = 0;
  double worst = 0, exact = 0;
  sim.advance(0, {1, 0, 0});
  for (const auto& row : reference) {
    const State state = sim.advance(row.tick - at, {1, 0, 0});
    at = row.tick;
    worst = std::max(
        {worst, std::abs(state.position.x / row.x - 1), std::abs(state.velocity.x / row.v - 1)});
    // Closed form: v = F/B (1 - e^(-Bt/M)), x = F/B (t - M/B (1 - e^(-Bt/M))).
    const double t = row.tick * 1e-3, decay = -std::expm1(-5 * t);
    exact = std::max({exact, std::abs(state.velocity.x / (2 * decay) - 1),
                      std::abs(state.position.x / (2 * (t - 0.2 * decay)) - 1)});
  }
  MESSAGE("free handle: relative error against the printed series "
          << worst << ", against the closed form " << exact);
  CHECK(worst < 1e-9);
  CHECK(exact < 1e-11);
}

TEST_CASE("a constant force against the hand's spring gives the reference series") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kSpring;
  Sim sim(settings);
  const std::pair<int, double> reference[] = {{1, 4.957767456e-06},
                                              {10, 4.533126135e-04},
                                              {50, 5.804718946e-03},
                                              {100, 5.963196138e-03},
                                              {1000, 4.999995309e-03}};
  int at = 0;
  double worst = 0;
  sim.advance(0, {1, 0, 0});
  for (const auto& [tick, x] : reference) {
    const State state = sim.advance(tick - at, {1, 0, 0});
    at = tick;
    worst = std::max(worst, std::abs(state.position.x / x - 1));
  }
  MESSAGE("spring hand: relative error against the printed series " << worst);
  CHECK(worst < 1e-9);
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

TEST_CASE("steps compose: one tick of 4 ms equals four of 1 ms") {
  const auto fine = MassSpringDamperStep::of(0.1, 700, 3, 1e-3);
  const auto coarse = MassSpringDamperStep::of(0.1, 700, 3, 4e-3);
  double x = 0.01, v = -0.3, y = 0.01, w = -0.3;
  for (int i = 0; i < 4; ++i)
    fine.advance(x, v, 1.7);
  coarse.advance(y, w, 1.7);
  CHECK(y == doctest::Approx(x).epsilon(1e-13));
  CHECK(w == doctest::Approx(v).epsilon(1e-13));
}

TEST_CASE("without force the energy of handle and hand only falls") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kSpring;
  Sim sim(settings);
  sim.device.set_state({0.02, -0.01, 0.03}, {0.5, 0.1, -0.9});
  double previous = 1e9;
  for (int tick = 0; tick < 2000; ++tick) {
    sim.advance(1);
    const Vec3 x = sim.device.position(), v = sim.device.velocity();
    const double energy = 0.5 * 0.1 * dot(v, v) + 0.5 * 200 * dot(x, x);
    CHECK(energy <= previous);
    previous = energy;
  }
  CHECK(previous < 1e-12);
}

TEST_CASE("a held force does exactly the work that the handle gains or dissipates") {
  auto settings = free_handle();
  Sim frictionless(settings);
  settings.viscous_n_s_per_m = 0;
  frictionless.device.set(settings);
  settings.viscous_n_s_per_m = 3;
  Sim rubbing(settings);
  tactus::Random random(12);
  for (int tick = 0; tick < 2000; ++tick) {
    const Vec3 force{5 * random.normal(), 5 * random.normal(), 5 * random.normal()};
    for (Sim* sim : {&frictionless, &rubbing}) {
      const Vec3 x = sim->device.position(), v = sim->device.velocity();
      sim->advance(1, force);
      const Vec3 y = sim->device.position(), w = sim->device.velocity();
      const double work = dot(force, y - x);
      const double gain = 0.05 * (dot(w, w) - dot(v, v));
      const double scale = 0.05 * (dot(w, w) + dot(v, v)) + std::abs(work);
      if (sim == &frictionless)
        CHECK(std::abs(gain - work) <= 1e-12 * scale);
      else
        CHECK(gain <= work + 1e-12 * scale);
    }
  }
}

TEST_CASE("with a moving hand the held values converge at first order in the tick") {
  // Reference: the same with a tick 64 times shorter.
  const auto end = [](int divide) {
    auto settings = free_handle();
    settings.hand.hold = Hold::kSpring;
    Sim sim(settings, 1e-3 / divide);
    sim.device.set_path(LissajousPath{{}, {0.02, 0, 0}, {3, 0, 0}});
    return sim.advance(200 * divide).position.x;
  };
  const double reference = end(256);
  const double coarse = std::abs(end(1) - reference), fine = std::abs(end(2) - reference),
               finer = std::abs(end(4) - reference);
  MESSAGE("error at 1, 1/2, 1/4 ms: " << coarse << " " << fine << " " << finer << " m");
  CHECK(std::log2(coarse / fine) == doctest::Approx(1).epsilon(0.1));
  CHECK(std::log2(fine / finer) == doctest::Approx(1).epsilon(0.1));
}

TEST_CASE("a rigid hand puts the handle exactly on the path, whatever the force") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kRigid;
  Sim sim(settings);
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
  State state = sim.advance(4000, {8, 0, 0});
  CHECK(state.position.x == test::approx(0.055 + 8.0 / 2e4).epsilon(1e-3));
}

TEST_CASE("the same ticks and forces give the same bits, and skipped ticks are simulated") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kPerson;
  settings.noise_m = 1e-5;
  Sim a(settings), b(settings);
  for (int i = 0; i < 500; ++i) {
    const Vec3 force{std::sin(0.1 * i), 0.5, -0.2};
    const State one = a.advance(1, force), other = b.advance(1, force);
    CHECK(one.position == other.position);
  }
  Sim c(free_handle()), d(free_handle());
  c.advance(0, {1, 0, 0});
  d.advance(0, {1, 0, 0});
  c.advance(12, {1, 0, 0});
  State state;
  REQUIRE(d.device.read({12, 0.012, 1e-3}, state));
  CHECK(state.position == c.device.position());
}

TEST_CASE("a device starts at its first reading, for any index of the tick") {
  SimulatedDevice device;
  device.set(free_handle());
  device.set_state({0.01, 0, 0}, {0.5, 0, 0});
  State state;
  REQUIRE(device.read({7000, 7.0, 1e-3}, state));
  CHECK(state.position == Vec3{0.01, 0, 0});
  CHECK(state.velocity == Vec3{0.5, 0, 0});
  REQUIRE(device.read({7001, 7.001, 1e-3}, state));
  // m v' = -b v for one tick
  const SimulatedDevice::Settings settings = free_handle();
  const double decay_per_s = settings.viscous_n_s_per_m / settings.mass_kg;
  CHECK(state.position.x ==
        test::approx(0.01 + 0.5 * (1 - std::exp(-decay_per_s * 1e-3)) / decay_per_s).epsilon(1e-9));
}

TEST_CASE("the reading has the encoder's step and noise, and then no velocity of its own") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kRigid;
  settings.resolution_m = 5e-5;
  settings.noise_m = 2e-5;
  Sim sim(settings);
  sim.device.set_path(LinePath{{-0.02, 0, 0}, {0.02, 0, 0}, 2});
  CHECK_FALSE(sim.device.caps().has_velocity);
  CHECK(sim.device.caps().position_noise_m == test::approx(4.5e-5));
  for (int i = 0; i < 1000; ++i) {
    const State state = sim.advance(1);
    const double steps = state.position.x / 5e-5;
    CHECK(std::abs(steps - std::round(steps)) < 1e-9);
    CHECK(std::abs(state.position.x - sim.device.position().x) <= 4.5e-5 * (1 + 1e-9));
  }
}

TEST_CASE("a target moves the spring hand smoothly and exactly there") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kSpring;
  Sim sim(settings);
  sim.device.set_target({0.03, -0.01, 0.02});
  double fastest = 0;
  for (int i = 0; i < 3000; ++i)
    fastest = std::max(fastest, norm(sim.advance(1).velocity));
  CHECK(norm(sim.device.position() - Vec3{0.03, -0.01, 0.02}) < 1e-6);
  CHECK(fastest < 1.0);
}

TEST_CASE("a person's tremor has its RMS and its 8 to 12 Hz at any tick") {
  for (const double period : {1e-3, 2.5e-4}) {
    tactus::Random random(9);
    NoiseOscillator tremor;
    tremor.set(10, 0.2, 1e-4, period);
    tremor.start(random);
    const int count = static_cast<int>(400 / period);
    double sum = 0;
    double band = 0, all = 0;
    // Power in the band by one-second Hann windows: a plain, independent estimate.
    const int window = static_cast<int>(1 / period);
    std::vector<double> x(static_cast<std::size_t>(window));
    for (int start = 0; start < count; start += window) {
      for (int i = 0; i < window; ++i) {
        tremor.advance(random);
        const double value = tremor.value();
        sum += value * value;
        x[static_cast<std::size_t>(i)] =
            value * 0.5 * (1 - std::cos(2 * std::numbers::pi * i / window));
      }
      for (int f = 1; f <= 40; ++f) {
        std::complex<double> line = 0;
        for (int i = 0; i < window; i += 4) // 40 Hz needs no more points
          line += x[static_cast<std::size_t>(i)] *
                  std::polar(1.0, -2 * std::numbers::pi * f * i / window);
        all += std::norm(line);
        if (f >= 7 && f <= 13)
          band += std::norm(line);
      }
    }
    const double rms = std::sqrt(sum / count);
    MESSAGE("tremor, tick " << period << " s: RMS " << rms * 1e6
                            << " um, share of power in 7..13 Hz " << band / all);
    CHECK(rms == test::approx(1e-4).epsilon(0.05)); // some 2500 independent values: 2 %
    CHECK(band / all > 0.6);
  }
}

TEST_CASE("a noise oscillator is stationary at any tick: position and velocity as in theory") {
  // x'' + 2 z w x' + w^2 x = white noise has var x = s^2, var v = (w s)^2 and no correlation of x
  // and v at one instant. A tick of a seventh of the period has strongly correlated noise in both.
  const double frequency_hz = 10, rms = 1e-4, w = 2 * std::numbers::pi * frequency_hz;
  for (const double period : {1e-3, 5e-3, 1.4e-2}) {
    tactus::Random random(21);
    NoiseOscillator noise;
    noise.set(frequency_hz, 0.2, rms, period);
    noise.start(random);
    const int count = 400000;
    double xx = 0, vv = 0, xv = 0;
    for (int n = 0; n < count; ++n) {
      noise.advance(random);
      const double x = noise.value() / rms, v = noise.rate() / (w * rms);
      xx += x * x / count;
      vv += v * v / count;
      xv += x * v / count;
    }
    MESSAGE("noise at a tick of " << period << " s: <xx> " << xx << " <vv> " << vv << " <xv> "
                                  << xv);
    // The correlation time 1/(z w) = 80 ms leaves 400 s / 80 ms = 5000 independent values or more,
    // 2 % of standard deviation in the variances; <xv> has less.
    CHECK(xx == doctest::Approx(1).epsilon(0.06));
    CHECK(vv == doctest::Approx(1).epsilon(0.06));
    CHECK(std::abs(xv) < 0.02);
  }
}

TEST_CASE("a person yields to a lasting force at F/(K tau), and stays put without one") {
  auto settings = free_handle();
  settings.hand.hold = Hold::kPerson;
  settings.hand.tremor_m = settings.hand.wander_m = 0;
  Sim still(settings);
  still.advance(5000);
  CHECK(norm(still.device.position()) == 0.0);
  Sim pushed(settings);
  pushed.advance(2000, {0.4, 0, 0});
  const double before = pushed.device.position().x;
  pushed.advance(1000, {0.4, 0, 0});
  // 0.4 N / (200 N/m * 1 s) = 2 mm/s
  CHECK(pushed.device.position().x - before == test::approx(2e-3).epsilon(0.02));

  settings.hand.tremor_m = 1e-4;
  settings.hand.wander_m = 1e-3;
  Sim alone(settings);
  double square = 0;
  for (int i = 0; i < 60000; ++i) {
    alone.advance(1);
    square += dot(alone.device.position(), alone.device.position()) / 3;
  }
  const double rms = std::sqrt(square / 60000);
  MESSAGE("a person alone for a minute: RMS " << rms * 1e3 << " mm an axis");
  CHECK(rms < 4e-3);
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

TEST_CASE("a latency gives each reading that many ticks later, and the device declares it") {
  SimulatedDevice device;
  SimulatedDevice::Settings settings;
  settings.hand.hold = HandSettings::Hold::kRigid;
  settings.latency_ticks = 3;
  device.set(settings);
  device.set_path(LinePath{{0, 0, 0}, {0.02, 0, 0}, 1});
  SimulatedDevice prompt;
  settings.latency_ticks = 0;
  prompt.set(settings);
  prompt.set_path(LinePath{{0, 0, 0}, {0.02, 0, 0}, 1});
  CHECK(device.caps().latency_ticks == 3);
  CHECK(prompt.caps().latency_ticks == 0);
  std::vector<State> without;
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Tick tick{k, static_cast<double>(k) * 1e-3, 1e-3};
    State late, now;
    REQUIRE(device.read(tick, late));
    REQUIRE(prompt.read(tick, now));
    without.push_back(now);
    const State& expected = without[k < 3 ? 0 : k - 3];
    CHECK(late.position == expected.position);
    CHECK(late.velocity == expected.velocity);
  }
}
