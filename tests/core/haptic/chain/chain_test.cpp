#include "core/dsp/random.hpp"
#include "core/haptic/chain/chain.hpp"

#include "tests/core/haptic/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <map>
#include <vector>

using namespace tactus::haptic;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Neither slew limit nor passivity controller.
ChainSettings plain() {
  ChainSettings settings;
  settings.slew_n_per_s = 1e9;
  settings.passivity = false;
  return settings;
}

/// Runs ticks 0..last at 1 kHz with commands on x at given ticks and a host that is always alive.
std::vector<double> run(const ChainSettings& settings, const std::map<int, double>& commands,
                        int last, ChainState* out = nullptr) {
  ChainState state;
  std::vector<double> forces;
  for (int tick = 0; tick <= last; ++tick) {
    const double now = tick * settings.period_s;
    if (const auto it = commands.find(tick); it != commands.end())
      command(state, settings, {it->second, 0, 0}, now);
    ChainInput input;
    input.time_s = input.heartbeat_s = now;
    forces.push_back(step(state, settings, input).x);
  }
  if (out)
    *out = state;
  return forces;
}

} // namespace

TEST_CASE("interpolation, clamp, slew and strict watchdog give the reference series") {
  ChainSettings settings;
  settings.force_limit_n = 2.5;
  settings.slew_n_per_s = 200;
  settings.strict = true;
  settings.passivity = false;
  const auto f = run(settings, {{0, 0}, {20, 1}, {40, 3}, {60, -2}}, 220);
  const struct {
    std::size_t tick;
    double force;
  } reference[] = {{20, 0.05},  {29, 0.5},    {39, 1.0},   {40, 1.1},  {49, 2.0},
                   {59, 2.5},   {60, 2.5},    {69, 0.9},   {79, -1.1}, {100, -2.0},
                   {160, -2.0}, {161, -1.96}, {185, -1.0}, {210, 0.0}};
  double worst = 0;
  for (const auto& row : reference) {
    CAPTURE(row.tick);
    CHECK(std::abs(f[row.tick] - row.force) < 1e-9);
    worst = std::max(worst, std::abs(f[row.tick] - row.force));
  }
  MESSAGE("largest error of the reference series: " << worst << " N");
  CHECK(worst < 1e-9);
}

TEST_CASE("the clamp keeps the direction") {
  ChainSettings settings = plain();
  settings.force_limit_n = 2;
  ChainState state;
  command(state, settings, {3, -4, 0}, 0);
  const Vec3 force = step(state, settings, {});
  CHECK(force.x == doctest::Approx(1.2).epsilon(1e-12));
  CHECK(force.y == doctest::Approx(-1.6).epsilon(1e-12));
  CHECK(force.z == 0.0);
  CHECK(state.counters.clamped == 1);
}

TEST_CASE("a target that is not finite is refused and counted, and the last good one stays") {
  for (const double bad : {kNan, kInf, -kInf}) {
    ChainSettings settings = plain();
    ChainState state;
    command(state, settings, {0, 1.5, 0}, 0);
    CHECK(step(state, settings, {}).y == 1.5);
    CHECK_FALSE(command(state, settings, {0, bad, 0}, 0.001));
    CHECK(state.counters.refused == 1);
    std::vector<double> forces;
    for (int tick = 1; tick <= 160; ++tick) {
      ChainInput input;
      input.time_s = input.heartbeat_s = tick * 1e-3;
      forces.push_back(step(state, settings, input).y);
    }
    CHECK(forces[0] == 1.5);
    CHECK(forces[100] == 1.5);                                 // held for the hold time of 100 ms
    CHECK(forces[125] == doctest::Approx(0.75).epsilon(1e-9)); // half way down the ramp
    CHECK(forces[150] == 0.0);
    command(state, settings, {0, 1, 0}, 0.161); // and a good one brings it back
    for (int tick = 161; tick <= 215; ++tick) {
      ChainInput input;
      input.time_s = input.heartbeat_s = tick * 1e-3;
      forces.push_back(step(state, settings, input).y);
    }
    CHECK(forces.back() == doctest::Approx(1).epsilon(1e-9));
  }
}

TEST_CASE("fixed interpolation takes the set time, interp off one tick") {
  ChainSettings settings = plain();
  settings.interpolation = ChainSettings::Interpolation::kFixed;
  settings.interpolation_s = 0.004;
  const auto slow = run(settings, {{0, 1}, {10, 3}}, 20);
  CHECK(slow[0] == doctest::Approx(0.25));
  CHECK(slow[3] == 1.0);
  CHECK(slow[11] == doctest::Approx(2.0));
  CHECK(slow[13] == 3.0);
  settings.interpolation = ChainSettings::Interpolation::kOff;
  const auto fast = run(settings, {{0, 1}, {10, 3}}, 20);
  CHECK(fast[0] == 1.0);
  CHECK(fast[9] == 1.0);
  CHECK(fast[10] == 3.0);
}

TEST_CASE("a target is reached in the time since the one before it, in 50 ticks at most") {
  const auto f = run(plain(), {{0, 0}, {30, 3}, {230, 13}}, 300);
  for (const int tick : {30, 44, 59})
    CHECK(f[static_cast<std::size_t>(tick)] == doctest::Approx(3 * (tick - 29) / 30.0));
  CHECK(f[229] == 3.0);
  ChainSettings strong = plain();
  strong.force_limit_n = 20;
  const auto g = run(strong, {{0, 0}, {30, 3}, {230, 13}}, 300);
  for (const int tick : {230, 254, 279})
    CHECK(g[static_cast<std::size_t>(tick)] == doctest::Approx(3 + 10 * (tick - 229) / 50.0));
  CHECK(g[280] == 13.0);
}

TEST_CASE("a second target in the same tick keeps the interpolation time") {
  ChainSettings settings = plain();
  ChainState state;
  std::vector<double> f;
  for (int tick = 0; tick < 40; ++tick) {
    if (tick == 0)
      command(state, settings, {0, 0, 0}, 0);
    if (tick == 20) {
      command(state, settings, {9, 0, 0}, 0.02);
      command(state, settings, {1, 0, 0}, 0.02);
    }
    ChainInput input;
    input.time_s = input.heartbeat_s = tick * 1e-3;
    f.push_back(step(state, settings, input).x);
  }
  CHECK(f[20] == test::approx(0.05));
  CHECK(f[39] == 1.0);
}

TEST_CASE(
    "extrapolation goes on along the slope, stops after its time and never passes the limit") {
  ChainSettings settings = plain();
  settings.extrapolation_s = 0.005;
  const std::map<int, double> commands{{0, 0}, {20, 1}};
  const auto f = run(settings, commands, 60);
  CHECK(f[39] == doctest::Approx(1.0));
  CHECK(f[41] == doctest::Approx(1.1));
  CHECK(f[44] == doctest::Approx(1.25));
  CHECK(f[60] == doctest::Approx(1.25));
  settings.force_limit_n = 1.1;
  CHECK(run(settings, commands, 60)[60] == doctest::Approx(1.1));
  settings.extrapolation_s = 0;
  settings.force_limit_n = 8;
  CHECK(run(settings, commands, 60)[60] == 1.0);
}

TEST_CASE("the slew bounds the change of the vector from tick to tick") {
  ChainSettings settings = plain();
  settings.slew_n_per_s = 100;
  settings.interpolation = ChainSettings::Interpolation::kOff;
  ChainState state;
  command(state, settings, {3, 4, 0}, 0);
  Vec3 previous;
  for (int tick = 0; tick < 60; ++tick) {
    ChainInput input;
    input.time_s = input.heartbeat_s = tick * 1e-3;
    const Vec3 force = step(state, settings, input);
    CHECK(norm(force - previous) <= 0.1 * (1 + 1e-12));
    CHECK(force.y * 3 == doctest::Approx(force.x * 4)); // straight towards the target
    previous = force;
  }
  CHECK(previous.x == doctest::Approx(3));
}

TEST_CASE(
    "an emergency stop acts at once and stays; motors on ramps the force up over half a second") {
  const ChainSettings settings = plain();
  ChainState state;
  command(state, settings, {2, 0, 0}, 0);
  int tick = 0;
  const auto next = [&] {
    ChainInput input;
    input.time_s = input.heartbeat_s = tick++ * 1e-3;
    return step(state, settings, input).x;
  };
  CHECK(next() == 2.0);
  emergency_stop(state);
  for (int i = 0; i < 1000; ++i)
    CHECK(next() == 0.0);
  command(state, settings, {2, 0, 0}, tick * 1e-3);
  CHECK(next() == 0.0); // a new force does not release it
  motors(state, true);
  double force = 0;
  for (int i = 0; i < 250; ++i)
    force = next();
  CHECK(force == doctest::Approx(1).epsilon(1e-9));
  for (int i = 0; i < 250; ++i)
    force = next();
  CHECK(force == doctest::Approx(2).epsilon(1e-9));
}

TEST_CASE(
    "before a device is homed there is no force, and the jump of its position then does no work") {
  ChainSettings settings = plain();
  settings.passivity = true;
  ChainState state;
  command(state, settings, {1, 0, 0}, 0);
  for (int tick = 0; tick < 1000; ++tick) {
    ChainInput input;
    input.time_s = input.heartbeat_s = tick * settings.period_s;
    input.homed = tick >= 300;
    input.position = input.homed ? Vec3{0.04, 0, 0} : Vec3{-0.03, 0, 0}; // 70 mm in one tick
    const double force = step(state, settings, input).x;
    CAPTURE(tick);
    if (tick < 300)
      REQUIRE(force == 0);
    else // rises over half a second
      REQUIRE(force == doctest::Approx(std::min(1.0, (tick - 299) / 500.0)));
  }
  CHECK(state.energy_j == 0);
  CHECK(state.counters.braked == 0);
}

TEST_CASE("motors off lets the force fall at the slew limit") {
  ChainSettings settings = plain();
  settings.slew_n_per_s = 100;
  ChainState state;
  command(state, settings, {1, 0, 0}, 0);
  double force = 0;
  for (int tick = 0; tick < 40; ++tick) {
    if (tick == 20)
      motors(state, false);
    ChainInput input;
    input.time_s = input.heartbeat_s = tick * 1e-3;
    force = step(state, settings, input).x;
    if (tick == 19)
      CHECK(force == 1.0);
    if (tick == 24)
      CHECK(force == doctest::Approx(0.5));
  }
  CHECK(force == 0.0);
}

TEST_CASE("damping opposes the velocity and the soft walls push back into the workspace") {
  ChainSettings settings = plain();
  settings.damping_n_s_per_m = 2;
  settings.wall_n_per_m = 100;
  ChainState state;
  ChainInput input;
  input.velocity = {0.1, 0, -0.2};
  input.position = {0.06, 0, -0.07};
  const Vec3 force = step(state, settings, input);
  CHECK(force.x == doctest::Approx(-0.2 - 1.0));
  CHECK(force.y == doctest::Approx(0));
  CHECK(force.z == doctest::Approx(0.4 + 2.0));
}

TEST_CASE("the observer keeps the exact energy of a force that is held over the tick") {
  ChainSettings settings = plain();
  settings.tank_j = 1e6;
  ChainState state;
  tactus::Random random(5);
  double work = 0;
  Vec3 position, force;
  for (int tick = 0; tick < 1000; ++tick) {
    const Vec3 before = position;
    position += Vec3{random.normal(), random.normal(), random.normal()} * 1e-4;
    if (tick > 0)
      work -= dot(force, position - before);
    command(state, settings, {random.normal(), random.normal(), random.normal()}, tick * 1e-3);
    ChainInput input;
    input.time_s = input.heartbeat_s = tick * 1e-3;
    input.position = position;
    force = step(state, settings, input);
    CHECK(state.energy_j == doctest::Approx(work).epsilon(1e-12));
  }
}

TEST_CASE("the tank bounds the energy that the observer stores") {
  ChainSettings settings = plain();
  settings.tank_j = 2e-3;
  ChainState state;
  command(state, settings, {-1, 0, 0}, 0);
  ChainInput input;
  for (int tick = 0; tick < 50; ++tick) { // the hand pushes 1 mm a tick against 1 N
    input.time_s = input.heartbeat_s = tick * 1e-3;
    input.position.x = tick * 1e-3;
    step(state, settings, input);
    CHECK(state.energy_j == doctest::Approx(std::min(tick * 1e-3, 2e-3)).epsilon(1e-12));
  }
}

TEST_CASE("commands may put their allowance into the hand, local models nothing") {
  for (const bool local : {false, true}) {
    ChainSettings settings = plain();
    settings.allowance_w = 0.01;
    ChainState state;
    if (!local)
      command(state, settings, {1, 0, 0}, 0);
    ChainInput input;
    if (local)
      input.local_force = {1, 0, 0};
    for (int tick = 0; tick <= 100; ++tick) { // 1 N along 40 um a tick: 40 mW for 100 ms
      input.time_s = input.heartbeat_s = tick * 1e-3;
      input.position.x = tick * 4e-5;
      step(state, settings, input);
    }
    CHECK(state.energy_j == test::approx(local ? -4e-3 : -3e-3).epsilon(1e-9));
  }
}

TEST_CASE("the allowance is subtracted again when the hand returns, in every cycle") {
  // 1 N of the patch along 4 mm and back: no work in the mean, no credit and no debt at any time.
  ChainSettings settings = plain();
  settings.allowance_w = 10;
  settings.tank_j = 0.1;
  ChainState state;
  command(state, settings, {1, 0, 0}, 0);
  ChainInput input;
  for (int tick = 0; tick <= 1000; ++tick) {
    input.time_s = input.heartbeat_s = tick * 1e-3;
    input.position.x = 4e-5 * (tick % 200 < 100 ? tick % 200 : 200 - tick % 200);
    step(state, settings, input);
    CHECK(std::abs(state.energy_j) < 1e-15);
    CHECK(state.allowance_j == doctest::Approx(input.position.x).scale(1e-6));
  }
  // Beyond its start the hand does work against the patch, which is stored as credit.
  input.time_s = input.heartbeat_s = 1.001;
  input.position.x = -1e-3;
  step(state, settings, input);
  CHECK(state.energy_j == doctest::Approx(1e-3).epsilon(1e-9));
}

TEST_CASE("the allowance is never more than the work done") {
  // The patch requests 8 N, of which the limit passes 1 N to the hand. An allowance for the work of
  // 8 N would put credit into the tank.
  ChainSettings settings = plain();
  settings.force_limit_n = 1;
  settings.allowance_w = 10;
  ChainState state;
  command(state, settings, {8, 0, 0}, 0);
  ChainInput input;
  for (int tick = 0; tick <= 100; ++tick) {
    input.time_s = input.heartbeat_s = tick * 1e-3;
    input.position.x = tick * 4e-5;
    CHECK(step(state, settings, input).x == doctest::Approx(1));
    CHECK(std::abs(state.energy_j) < 1e-15);
  }
}

TEST_CASE("an extrapolated slope ends after its time and never exceeds the force limit") {
  // 0, then 4 N after 10 ticks: a slope of 0.4 N a tick, continued for 5 ticks to 6 N.
  ChainSettings settings = plain();
  settings.extrapolation_s = 0.005;
  const auto run = [&settings](int then_tick) {
    ChainState state;
    std::vector<double> forces;
    for (int tick = 0; tick < 60; ++tick) {
      const double now = tick * 1e-3;
      if (tick == 0)
        command(state, settings, {}, now);
      if (tick == 10)
        command(state, settings, {4, 0, 0}, now);
      if (tick == then_tick)
        command(state, settings, {}, now);
      ChainInput input;
      input.time_s = input.heartbeat_s = now;
      forces.push_back(step(state, settings, input).x);
    }
    return forces;
  };
  const auto free = run(-1);
  CHECK(free[19] == doctest::Approx(4));
  CHECK(free[24] == doctest::Approx(6));
  CHECK(free[59] == doctest::Approx(6));
  // With a limit of 5 N the slope stops there, so the interpolation back to 0 begins from 5 N and
  // not from 6: after one of 20 ticks it is 4.75 N.
  settings.force_limit_n = 5;
  const auto limited = run(30);
  CHECK(limited[29] == doctest::Approx(5));
  CHECK(limited[30] == doctest::Approx(5 - 5.0 / 20));
}

TEST_CASE("for any input the written force is finite and within the limit") {
  tactus::Random random(2024);
  const double absurd[] = {0,     -0.0,  1,      -1,      1e-310, 1e-3, 8,     1e6,
                           -1e30, 1e308, -1e308, 1.7e308, kNan,   kInf, -kInf, 5e-324};
  const auto any = [&] { return absurd[random.next() % std::size(absurd)]; };
  for (int round = 0; round < 200; ++round) {
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
