#include "core/haptic/signal/signal_player.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
using tactus::Vec3;
using tactus::test::approx;

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A link on the wall's time, its servo ticking a handle along x = 10 mm sin(2 pi 2 Hz t).
struct WallRig {
  std::unique_ptr<SignalLink> link = std::make_unique<SignalLink>();
  SignalPlayer player;
  std::uint64_t tick = 0;
  std::vector<Vec3> forces;
  double velocity = 0; ///< last played, m/s

  WallRig() {
    link->set_workspace({{-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}});
    link->configure(SignalLink::Time::kWall, 1000, {});
    player.prepare(48000);
    player.attach(link.get());
  }
  static double x_m(double time_s) { return 0.01 * std::sin(kTwoPi * 2 * time_s); }
  static double v_m_per_s(double time_s) {
    return 0.01 * kTwoPi * 2 * std::cos(kTwoPi * 2 * time_s);
  }
  void tick_until(double time_s) {
    for (; static_cast<double>(tick) * 1e-3 <= time_s; ++tick) {
      State state;
      const double now_s = static_cast<double>(tick) * 1e-3;
      state.position.x = x_m(now_s);
      state.velocity.x = v_m_per_s(now_s);
      forces.push_back(link->force({tick, now_s, 1e-3}, state));
    }
  }
  std::vector<double> block(double wall_s, double force = 0) {
    std::vector<double> x;
    player.begin_block(64);
    for (int i = 0; i < 64; ++i) {
      const auto played = player.process({{force, 0, 0}, 0});
      x.push_back((played.position.x - 0.5) * 0.1);
      velocity = played.velocity.x;
    }
    player.end_block(wall_s);
    return x;
  }
};

} // namespace

TEST_CASE(
    "the decimator is a Butterworth low-pass of the eighth order at 0.4 of the servo's rate") {
  for (const double sample_rate_hz : {44100.0, 48000.0, 96000.0}) {
    Decimator decimator;
    decimator.set(sample_rate_hz, 1000);
    for (const double hz : {20.0, 100.0, 300.0, 400.0, 500.0, 600.0, 800.0}) {
      decimator.reset();
      double sine = 0, cosine = 0;
      const int settle = static_cast<int>(0.2 * sample_rate_hz), count = settle / 2;
      for (int n = 0; n < settle + count; ++n) { // counts whole periods, of 0.1 s
        const double phase = kTwoPi * hz * n / sample_rate_hz;
        const double y = decimator.process(std::sin(phase));
        if (n >= settle) {
          sine += y * std::sin(phase);
          cosine += y * std::cos(phase);
        }
      }
      // The bilinear transform bends the frequency axis: compare at the bent frequency.
      const double bent = std::tan(std::numbers::pi * hz / sample_rate_hz) /
                          std::tan(std::numbers::pi * 400 / sample_rate_hz);
      CHECK(2 * std::hypot(sine, cosine) / count ==
            doctest::Approx(1 / std::sqrt(1 + std::pow(bent, 16))).epsilon(1e-6));
    }
  }
}

TEST_CASE("the decimator stays finite for any input and decays to exact zero") {
  Decimator decimator;
  decimator.set(48000, 1000);
  for (const double bad : {kNone, std::numeric_limits<double>::infinity(), 1e300, -1e12})
    CHECK(decimator.process(bad) == 0);
  static_cast<void>(decimator.process(1e8));
  double y = 1;
  for (int n = 0; n < 200000; ++n)
    y = decimator.process(0);
  CHECK(y == 0);
  // Without a rate, or with the cutoff, 400 Hz, beyond 0.45 of it, the input passes unchanged.
  for (const double rate_hz : {kNone, 880.0, 900.0}) {
    decimator.set(rate_hz, 1000);
    CHECK((decimator.process(3) == 3) == !(rate_hz == 900));
  }
}

TEST_CASE("a steady stream is played the set delay behind the newest reading, in the mean") {
  // Before each block of 64 samples the ticks up to its start have come: the newest is half a tick
  // old in the mean, the block's samples lie half a block after its start.
  WallRig rig;
  double in_phase = 0, quadrature = 0;
  constexpr int kSettle = 750, kBlocks = 1500; // of 4/3 ms: 1 s, then 2 s of the sine of 2 Hz
  for (int b = 0; b < kSettle + kBlocks; ++b) {
    const double wall_s = b * 64 / 48000.0;
    rig.tick_until(wall_s);
    const auto x = rig.block(wall_s);
    for (std::size_t i = 0; i < x.size() && b >= kSettle; ++i) {
      const double phase = kTwoPi * 2 * (wall_s + static_cast<double>(i) / 48000);
      in_phase += x[i] * std::sin(phase);
      quadrature += x[i] * std::cos(phase);
    }
  }
  const double lag_s = -std::atan2(quadrature, in_phase) / (kTwoPi * 2);
  CHECK(std::hypot(in_phase, quadrature) * 2 / (64 * kBlocks) == approx(0.01).epsilon(0.01));
  CHECK(lag_s == approx(3e-3 + 0.5e-3 + 32 / 48000.0).epsilon(0.05));
}

TEST_CASE("in wall time positions and velocities are played smoothly, late by the set delay") {
  WallRig rig;
  // Blocks of 64 in bursts of four, as behind an audio buffer.
  double worst = 0, worst_velocity = 0, largest_step = 0, last = 0;
  for (int burst = 0; burst < 800; ++burst) {
    const double wall_s = (burst + 1) * 256 / 48000.0;
    rig.tick_until(wall_s);
    for (int b = 0; b < 4; ++b) {
      const auto x = rig.block(wall_s);
      for (std::size_t i = 0; i < x.size(); ++i) {
        const double sample_s = wall_s + (b * 64 + static_cast<double>(i)) / 48000.0;
        if (burst > 200) { // 2 % faster or slower at most: the ear-saving speed of catching up
          worst = std::max(worst, std::abs(x[i] - WallRig::x_m(sample_s - 256 / 48000.0 - 3e-3)));
          largest_step = std::max(largest_step, std::abs(x[i] - last));
        }
        last = x[i];
      }
      const double late_s = wall_s + (b * 64 + 63 - 256) / 48000.0 - 3e-3;
      if (burst > 200)
        worst_velocity =
            std::max(worst_velocity, std::abs(rig.velocity - WallRig::v_m_per_s(late_s)));
    }
  }
  // 10 mm at 2 Hz moves at most 0.126 m/s and 1.58 m/s^2; the play head wanders by half a burst
  // of 5.3 ms, and stays the milliseconds more behind that this needs.
  CHECK(worst < 0.126 * 5.4e-3);
  CHECK(worst_velocity < 1.58 * 5.4e-3);
  CHECK(largest_step < 1.05 * 0.126 / 48000);
}

TEST_CASE("playout restarts where the servo's time jumps, forwards or back, and is normalised to "
          "the workspace that was set last") {
  for (const std::uint64_t after : {std::uint64_t{0}, std::uint64_t{9000}}) {
    WallRig rig;
    const auto play = [&rig](std::uint64_t first, int blocks) {
      rig.tick = first;
      double worst = 0;
      for (int b = 0; b < blocks; ++b) {
        const double wall_s = static_cast<double>(first) * 1e-3 + b * 64 / 48000.0;
        rig.tick_until(wall_s);
        const double x = rig.block(wall_s).back();
        if (b > blocks / 2) // at most 0.126 m/s, some 4 ms late
          worst = std::max(worst, std::abs(x - WallRig::x_m(wall_s)));
      }
      return worst;
    };
    CHECK(play(5000, 400) < 0.126 * 6e-3);
    CHECK(play(after, 200) < 0.126 * 6e-3); // right again in an eighth of a second
    rig.link->set_workspace({{-0.03, -0.05, -0.05}, {0.02, 0.05, 0.05}}); // 10 mm are 0.8, not 0.6
    double top = 0;
    for (int b = 0; b < 400; ++b) {
      const double wall_s = static_cast<double>(rig.tick) * 1e-3 + 64 / 48000.0;
      rig.tick_until(wall_s);
      for (const double x : rig.block(wall_s))
        top = std::max(top, x / 0.1 + 0.5);
    }
    CHECK(top == approx(0.8).epsilon(1e-3));
  }
}

TEST_CASE("in wall time the last sample of a block is the force, and a stopped signal gives zero") {
  WallRig rig;
  const auto force_at = [&rig](double time_s) {
    rig.tick_until(time_s);
    return rig.forces.back().x;
  };
  rig.block(0.010, 1.5);
  CHECK(force_at(0.0125) == 1.5);
  rig.block(0.012, kNone);
  CHECK(force_at(0.0135) == 0);
  rig.block(0.013, 0.5);
  CHECK(force_at(0.1105) == 0.5);
  CHECK(force_at(0.120) == 0);
}

TEST_CASE("vibration computed in bursts comes to the servo one value a tick, in order") {
  WallRig rig;
  rig.player.set_gate(false);
  // 100 Hz, 1 N; 10 ms of audio every 10 ms.
  double phase = 0;
  for (int burst = 0; burst < 60; ++burst) {
    const double wall_s = burst * 0.01;
    rig.player.begin_block(480);
    for (int i = 0; i < 480; ++i, phase += kTwoPi * 100 / 48000)
      static_cast<void>(rig.player.process({{}, std::sin(phase)}));
    rig.player.end_block(wall_s);
    rig.tick_until(wall_s + 0.00999);
  }
  double energy = 0;
  for (std::size_t n = 100; n + 1 < rig.forces.size(); ++n) {
    const double z = rig.forces[n].z;
    energy += z * z / static_cast<double>(rig.forces.size() - 101);
    // A sampled sine obeys s[n+1] + s[n-1] = 2 cos(w) s[n].
    CHECK(std::abs(rig.forces[n + 1].z + rig.forces[n - 1].z - 2 * std::cos(kTwoPi * 0.1) * z) <
          1e-6);
  }
  CHECK(std::sqrt(2 * energy) == approx(1).epsilon(0.01));
}

TEST_CASE("vibration that nobody has read for 65 ticks is heard from its newest four on") {
  WallRig rig;
  rig.link->set_gate(false);
  for (int n = 1; n <= 70; ++n)
    REQUIRE(rig.link->push_vibration(n));
  for (int n = 0; n < 4; ++n)
    CHECK(rig.link->force({static_cast<std::uint64_t>(n), n * 1e-3, 1e-3}, {}).z == 67 + n);
}

TEST_CASE("absurd rates leave the player finite and give 64 ticks a sample at most") {
  for (const double rate : {0.0, -1.0, 1e-9, 0.5, 1.0, 1e12, kNone}) {
    auto link = std::make_unique<SignalLink>();
    int steps = 0;
    link->configure(SignalLink::Time::kLogical, 1000,
                    {[](void* count) { ++*static_cast<int*>(count); }, &steps});
    SignalPlayer player;
    player.prepare(rate);
    player.attach(link.get());
    player.begin_block(64);
    for (int n = 0; n < 64; ++n) {
      const int before = steps;
      CHECK(is_finite(player.process({{1, 2, 3}, 4}).position));
      CHECK(steps - before <= 64);
      if (rate == 1) // a thousand ticks a sample; the first lies at the first sample
        CHECK(steps - before == (n == 0 ? 1 : 64));
    }
    player.end_block(0);
  }
}

TEST_CASE(
    "ticks that the audio steps go on from those of the clock, each at the first sample at or "
    "after its time, over a pause and for any origin") {
  struct Servo {
    SignalLink link;
    std::vector<double> times;
    void step(double time_s) {
      times.push_back(time_s);
      static_cast<void>(link.force({times.size(), time_s, 1e-3}, {}));
    }
  } servo;
  constexpr double kRate = 44100, kOrigin_s = 12.34;
  servo.link.configure(SignalLink::Time::kLogical, 1000,
                       {[](void* self) {
                          auto& one = *static_cast<Servo*>(self);
                          one.step(one.link.due_s());
                        },
                        &servo});
  servo.link.set_origin(kOrigin_s);
  servo.step(0);
  servo.step(1e-3);
  SignalPlayer player;
  player.prepare(kRate);
  player.attach(&servo.link);
  std::size_t counted = servo.times.size();
  const auto play = [&](std::int64_t first_sample, int blocks) {
    for (int block = 0; block < blocks; ++block) {
      const auto begin = static_cast<double>(first_sample + block * 64);
      player.begin_block(64, kOrigin_s + begin / kRate);
      for (int i = 0; i < 64; ++i) {
        static_cast<void>(player.process({}));
        for (; counted < servo.times.size(); ++counted) {
          const double late_samples = (begin + i) - servo.times[counted] * kRate;
          CHECK(late_samples > -1e-3);
          CHECK(late_samples < 1);
        }
      }
      player.end_block(0);
    }
  };
  play(0, 100);
  const std::size_t before = servo.times.size();
  play(10000, 100); // after 3600 samples without audio
  CHECK(servo.times.size() == before + 145);
  for (std::size_t n = 0; n < servo.times.size(); ++n) {
    const double ticks = servo.times[n] * 1000;
    CHECK(std::abs(ticks - std::round(ticks)) < 1e-9);
    if (n < before)
      CHECK(ticks == doctest::Approx(static_cast<double>(n)));
  }
}
