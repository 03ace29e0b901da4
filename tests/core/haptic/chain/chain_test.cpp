#include "core/dsp/random.hpp"
#include "core/haptic/chain/chain.hpp"

#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
using tactus::Vec3;
using test::approx;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Neither slew limit nor passivity controller.
ChainSettings plain() {
  ChainSettings settings = test::without_passivity();
  settings.slew_n_per_s = 1e9;
  return settings;
}

/// A chain at 1 kHz with a host that is always alive, one force after another along x.
struct Chain {
  ChainSettings settings = plain();
  ChainState state{};
  ChainInput input{};
  int ticks = 0;

  [[nodiscard]] double time_s() const { return ticks * settings.period_s; }
  void ask(double force_n) { command(state, settings, {force_n, 0, 0}, time_s()); }
  Vec3 tick() {
    input.time_s = input.heartbeat_s = time_s();
    ++ticks;
    return step(state, settings, input);
  }
  double tick_x(int count = 1) {
    double force = 0;
    for (; count > 0; --count)
      force = tick().x;
    return force;
  }
};

/// The force at each of the ticks 0..last, with commands on x at the given ones.
std::vector<double> series(const ChainSettings& settings, const std::map<int, double>& commands,
                           int last) {
  Chain chain{settings};
  std::vector<double> forces;
  while (chain.ticks <= last) {
    if (const auto it = commands.find(chain.ticks); it != commands.end())
      chain.ask(it->second);
    forces.push_back(chain.tick_x());
  }
  return forces;
}

} // namespace

TEST_CASE("interpolation, clamp, slew and strict watchdog give the reference series") {
  ChainSettings settings = test::without_passivity();
  settings.force_limit_n = 2.5;
  settings.slew_n_per_s = 200;
  settings.strict = true;
  const auto f = series(settings, {{0, 0}, {20, 1}, {40, 3}, {60, -2}}, 220);
  const struct {
    std::size_t tick;
    double force;
  } reference[] = {{20, 0.05},  {29, 0.5},    {39, 1.0},   {40, 1.1},  {49, 2.0},
                   {59, 2.5},   {60, 2.5},    {69, 0.9},   {79, -1.1}, {100, -2.0},
                   {160, -2.0}, {161, -1.96}, {185, -1.0}, {210, 0.0}};
  for (const auto& row : reference) {
    CAPTURE(row.tick);
    CHECK(std::abs(f[row.tick] - row.force) < 1e-9);
  }
}

TEST_CASE("the clamp keeps the direction") {
  ChainSettings settings = plain();
  settings.force_limit_n = 2;
  ChainState state;
  command(state, settings, {3, -4, 0}, 0);
  const Vec3 force = step(state, settings, {});
  CHECK(norm(force - Vec3{1.2, -1.6, 0}) < 1e-12);
  CHECK(state.counters.clamped == 1);
}

TEST_CASE("a target that is not finite is refused and counted, and the last good one stays") {
  for (const double bad : {kNan, kInf, -kInf}) {
    Chain chain;
    chain.ask(1.5);
    CHECK(chain.tick_x() == 1.5);
    CHECK_FALSE(command(chain.state, chain.settings, {0, bad, 0}, 0.001));
    CHECK(chain.state.counters.refused == 1);
    CHECK(chain.tick_x(101) == 1.5);                       // for the hold time of 100 ms
    CHECK(chain.tick_x(25) == approx(0.75).epsilon(1e-9)); // half way down the ramp
    CHECK(chain.tick_x(25) == 0.0);
    chain.tick_x(9);
    chain.ask(1); // and a good one brings it back
    CHECK(chain.tick_x(55) == approx(1).epsilon(1e-9));
  }
}

TEST_CASE("after a freeze of the host the force returns by itself, or not before the motors are "
          "enabled") {
  for (const bool resume : {true, false}) {
    Chain chain;
    chain.settings.resume = resume;
    chain.ask(1);
    const auto frozen = [&chain](int count) {
      for (; count > 0; --count) {
        chain.input.time_s = chain.time_s();
        ++chain.ticks;
        step(chain.state, chain.settings, chain.input);
      }
      return chain.state.written.x;
    };
    CHECK(chain.tick_x(100) == 1.0);
    CHECK(frozen(100) == 1.0);
    CHECK(frozen(25) == approx(0.5));
    CHECK(chain.tick_x(60) == approx(resume ? 1 : 0)); // 50 ms later
    CHECK(chain.state.frozen != resume);
    CHECK(frozen(200) == 0.0);
    CHECK(chain.tick_x(1000) == approx(resume ? 1 : 0));
    motors(chain.state, true);
    CHECK(chain.tick_x(250) == approx(resume ? 1 : 0.5)); // over half a second
    CHECK(chain.tick_x(250) == approx(1));
  }
}

TEST_CASE("a target is reached in the time since the one before it, in 50 ticks at most") {
  ChainSettings settings = plain();
  settings.force_limit_n = 20;
  const auto f = series(settings, {{0, 0}, {30, 3}, {230, 13}}, 300);
  for (const int tick : {30, 44, 59})
    CHECK(f[static_cast<std::size_t>(tick)] == approx(3 * (tick - 29) / 30.0));
  CHECK(f[229] == 3.0);
  for (const int tick : {230, 254, 279})
    CHECK(f[static_cast<std::size_t>(tick)] == approx(3 + 10 * (tick - 229) / 50.0));
  CHECK(f[280] == 13.0);
  // A second target in the same tick keeps the time.
  Chain chain;
  chain.ask(0);
  chain.tick_x(20);
  chain.ask(9);
  chain.ask(1);
  CHECK(chain.tick_x() == approx(0.05));
  CHECK(chain.tick_x(19) == 1.0);
}

TEST_CASE("fixed interpolation takes the set time, interp off one tick") {
  ChainSettings settings = plain();
  settings.interpolation = ChainSettings::Interpolation::kFixed;
  settings.interpolation_s = 0.004;
  const auto slow = series(settings, {{0, 1}, {10, 3}}, 20);
  CHECK(slow[0] == approx(0.25));
  CHECK(slow[3] == 1.0);
  CHECK(slow[11] == approx(2.0));
  CHECK(slow[13] == 3.0);
  settings.interpolation = ChainSettings::Interpolation::kOff;
  const auto fast = series(settings, {{0, 1}, {10, 3}}, 20);
  CHECK(fast[0] == 1.0);
  CHECK(fast[9] == 1.0);
  CHECK(fast[10] == 3.0);
}

TEST_CASE("an extrapolated slope ends after its time and never exceeds the force limit") {
  // 0, then 4 N after 10 ticks: a slope of 0.4 N a tick, continued for 5 ticks to 6 N.
  ChainSettings settings = plain();
  settings.extrapolation_s = 0.005;
  const std::map<int, double> commands{{0, 0}, {10, 4}, {30, 0}};
  const auto free = series(settings, commands, 30);
  CHECK(free[19] == approx(4));
  CHECK(free[21] == approx(4.8));
  CHECK(free[24] == approx(6));
  CHECK(free[29] == approx(6));
  // With a limit of 5 N the slope stops there, so the interpolation back to 0 begins from 5 N and
  // not from 6: after one of 20 ticks it is 4.75 N.
  settings.force_limit_n = 5;
  const auto limited = series(settings, commands, 30);
  CHECK(limited[29] == approx(5));
  CHECK(limited[30] == approx(5 - 5.0 / 20));
  settings.extrapolation_s = 0;
  CHECK(series(settings, commands, 29)[29] == 4.0);
}

TEST_CASE("the slew bounds the change of the vector from tick to tick") {
  Chain chain;
  chain.settings.slew_n_per_s = 100;
  chain.settings.interpolation = ChainSettings::Interpolation::kOff;
  command(chain.state, chain.settings, {3, 4, 0}, 0);
  Vec3 previous;
  for (int tick = 0; tick < 60; ++tick) {
    const Vec3 force = chain.tick();
    CHECK(norm(force - previous) <= 0.1 * (1 + 1e-12));
    CHECK(force.y * 3 == approx(force.x * 4)); // straight towards the target
    previous = force;
  }
  CHECK(previous.x == approx(3));
}

TEST_CASE("an emergency stop acts at once and stays; motors on ramps the force up over half a "
          "second, and motors off lets it fall at the slew limit") {
  Chain chain;
  chain.settings.slew_n_per_s = 100;
  chain.ask(2);
  CHECK(chain.tick_x(40) == 2.0);
  emergency_stop(chain.state);
  for (int i = 0; i < 1000; ++i)
    CHECK(chain.tick_x() == 0.0);
  chain.ask(2);
  CHECK(chain.tick_x() == 0.0); // a new force does not release it
  motors(chain.state, true);
  CHECK(chain.tick_x(250) == approx(1).epsilon(1e-9));
  CHECK(chain.tick_x(250) == approx(2).epsilon(1e-9));
  motors(chain.state, false);
  CHECK(chain.tick_x(5) == approx(1.5));
  CHECK(chain.tick_x(16) == 0.0);
}

TEST_CASE(
    "before a device is homed there is no force, and the jump of its position then does no work") {
  Chain chain;
  chain.settings.passivity = true;
  chain.ask(1);
  for (int tick = 0; tick < 1000; ++tick) {
    chain.input.homed = tick >= 300;
    chain.input.position = {tick < 300 ? -0.03 : 0.04, 0, 0}; // 70 mm in one tick
    CAPTURE(tick);
    const double force = chain.tick_x();
    if (tick < 300)
      REQUIRE(force == 0);
    else // rises over half a second
      REQUIRE(force == approx(std::min(1.0, (tick - 299) / 500.0)));
  }
  CHECK(chain.state.energy_j == 0);
  CHECK(chain.state.counters.braked == 0);
}

TEST_CASE("damping opposes the velocity and the soft walls push back into the workspace") {
  Chain chain;
  chain.settings.damping_n_s_per_m = 2;
  chain.settings.wall_n_per_m = 100;
  chain.input.velocity = {0.1, 0, -0.2};
  chain.input.position = {0.06, 0, -0.07};
  CHECK(norm(chain.tick() - Vec3{-0.2 - 1.0, 0, 0.4 + 2.0}) < 1e-12);
}

TEST_CASE("the tank bounds the energy that the observer stores of a contact") {
  Chain chain;
  chain.settings.tank_j = 2e-3;
  chain.input.local_force = {-1, 0, 0};
  for (int tick = 0; tick < 50; ++tick) { // the hand pushes 1 mm a tick against 1 N
    chain.input.position.x = tick * 1e-3;
    chain.tick();
    CHECK(chain.state.energy_j == doctest::Approx(std::min(tick * 1e-3, 2e-3)).epsilon(1e-12));
  }
}

TEST_CASE(
    "a constant or slowly growing command arrives from its first tick, however the hand moves") {
  // Nothing is created by holding a force that does not follow the motion: not for a hand that it
  // moves, pushes back or shakes, nor beside a contact.
  for (const double growth_n_per_s : {0.0, 2.0})
    for (const double allowance_w : {0.0, 0.05})
      for (const double swing_hz : {0.3, 3.0, 12.0}) {
        Chain chain;
        chain.settings.passivity = true;
        chain.settings.allowance_w = allowance_w;
        chain.settings.interpolation = ChainSettings::Interpolation::kOff;
        CAPTURE(swing_hz);
        for (int tick = 0; tick < 2000; ++tick) {
          const double phase = 2 * std::numbers::pi * swing_hz * tick * 1e-3;
          const double asked = tick < 100 ? 0 : 1 + growth_n_per_s * (tick - 100) * 1e-3;
          chain.input.position.x = 5e-3 * std::sin(phase);
          chain.input.velocity.x = 5e-3 * 2 * std::numbers::pi * swing_hz * std::cos(phase);
          chain.ask(asked);
          REQUIRE(chain.tick_x() == approx(asked).epsilon(0.01));
        }
      }
}

TEST_CASE("for any input the written force is finite and within the limit") {
  tactus::Random random(2024);
  const double absurd[] = {0,     -0.0,  1,      -1,      1e-310, 1e-3, 8,     1e6,
                           -1e30, 1e308, -1e308, 1.7e308, kNan,   kInf, -kInf, 5e-324};
  const auto any = [&] { return absurd[random.next() % std::size(absurd)]; };
  for (int round = 0; round < 100; ++round) {
    ChainSettings settings;
    settings.force_limit_n = 0.01 + 40 * random.uniform();
    settings.slew_n_per_s = round % 3 ? 1e3 * random.uniform() : 1e9;
    settings.interpolation = static_cast<ChainSettings::Interpolation>(random.next() % 3);
    settings.interpolation_s = random.uniform();
    settings.extrapolation_s = 0.02 * random.uniform();
    settings.strict = random.next() & 1;
    settings.damping_n_s_per_m = 100 * random.uniform();
    settings.wall_n_per_m = 1e5 * random.uniform();
    settings.tank_j = random.uniform();
    ChainState state;
    for (int tick = 0; tick < 500; ++tick) {
      const double now = tick * 1e-3;
      const auto draw = random.next() % 16;
      if (draw < 4)
        command(state, settings, {any(), any(), any()}, now);
      if (draw == 5)
        motors(state, random.next() & 1);
      if (draw == 6 && random.next() % 8 == 0)
        emergency_stop(state);
      ChainInput input;
      input.time_s = draw == 7 ? any() : now;
      if (!std::isfinite(input.time_s))
        input.time_s = now;
      input.heartbeat_s = draw == 8 ? now - 1 : now;
      input.position = {any(), any(), any()};
      input.velocity = {any(), any(), any()};
      input.local_force = {any(), any(), any()};
      const Vec3 force = step(state, settings, input);
      REQUIRE(is_finite(force));
      REQUIRE(norm(force) <= settings.force_limit_n * (1 + 1e-12));
      REQUIRE(std::isfinite(state.energy_j));
    }
  }
}
