#include "core/haptic/signal/signal_player.hpp"
#include "tests/approx.hpp"
#include "tests/core/haptic/network/network_rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
using tactus::test::approx;

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// A mass that swings at 440 Hz, heard as displacement and velocity; the servo ticks at 1 kHz.
struct AudioRig {
  test::NetworkRig network;
  std::unique_ptr<SignalLink> link = std::make_unique<SignalLink>();
  std::unique_ptr<SignalPlayer> player = std::make_unique<SignalPlayer>();
  double amplitude = 1e-3, omega = kTwoPi * 440;

  explicit AudioRig(double rate_hz = 48000, double omega_hz = 440) : omega(kTwoPi * omega_hz) {
    const std::size_t a = network.anchor({}), b = network.mass(1e-3, {0, 0, amplitude});
    network.link(a, b, 1e-3 * omega * omega);
    network.network.rate_hz = rate_hz;
    network.network.pickups[0] = {b, 2, NetworkPickup::Quantity::kVelocity};
    network.network.pickups[1] = {a, 2, NetworkPickup::Quantity::kForce};
    network.publish();
    link->set_network(network.model);
  }
  /// The servo ticks with the audio's time, for a player at that rate.
  void play_in_logical_time(SignalPlayer& on, double rate_hz) {
    link->configure(SignalLink::Time::kLogical, 1000,
                    {[](void* self) { static_cast<AudioRig*>(self)->tick(); }, this});
    on.prepare(rate_hz);
    on.attach(link.get());
  }
  void tick() {
    State state;
    state.position = {0, 0.5, 0};
    const double time_s = static_cast<double>(network.ticks) * 1e-3;
    network.tick();
    static_cast<void>(link->force({network.ticks, time_s, 1e-3}, state));
  }
  /// Time-domain residue of a sampled sine: s[n+1] + s[n-1] = 2 cos(w) s[n].
  static double roughness(const std::vector<double>& s, double turn) {
    double worst = 0;
    for (std::size_t n = 1; n + 1 < s.size(); ++n)
      worst = std::max(worst, std::abs(s[n + 1] + s[n - 1] - 2 * std::cos(turn) * s[n]));
    return worst;
  }
};

} // namespace

TEST_CASE("in logical time the network is played step by step, at any sample rate as a pure tone") {
  for (const double rate : {44100.0, 48000.0, 88200.0}) {
    AudioRig rig;
    rig.play_in_logical_time(*rig.player, rate);
    std::vector<double> velocity, force;
    for (int block = 0; block < 200; ++block) {
      rig.player->begin_block(64);
      for (int i = 0; i < 64; ++i) {
        const auto out = rig.player->process({});
        if (block > 20) {
          velocity.push_back(out.network[0]);
          force.push_back(out.network[1]);
        }
      }
      rig.player->end_block(0);
    }
    const double h = 1 / 48000.0;
    const double turn = 2 / h * std::asin(0.5 * rig.omega * h) / rate; // in a sample
    double max_amplitude = 0;
    for (const double v : velocity)
      max_amplitude = std::max(max_amplitude, std::abs(v));
    CHECK(max_amplitude == approx(rig.amplitude * rig.omega).epsilon(2e-3));
    // At 48 kHz each sample is a step: only float's rounding. Else the cubic's error, (w h)^4/30.
    CHECK(AudioRig::roughness(velocity, turn) / max_amplitude < (rate == 48000 ? 4e-7 : 1e-5));
    // The force of the anchor is k z, in quadrature.
    const double scale = 1e-3 * rig.omega * rig.omega * rig.amplitude;
    double energy = 0;
    for (std::size_t n = 0; n < force.size(); ++n)
      energy =
          std::max(energy, std::abs(std::hypot(velocity[n] / max_amplitude, force[n] / scale) - 1));
    CHECK(energy < 0.04); // the velocity is half a step early
  }
}

TEST_CASE("a network stepped faster than it is read is averaged, at its pitch") {
  AudioRig rig(192000);
  rig.tick();
  CHECK(rig.network.model.samples().size() == 48);
  rig.play_in_logical_time(*rig.player, 48000);
  std::vector<double> velocity;
  for (int i = 0; i < 9600; ++i) {
    if (i % 64 == 0)
      rig.player->begin_block(64);
    velocity.push_back(rig.player->process({}).network[0]);
  }
  velocity.erase(velocity.begin(), velocity.begin() + 480);
  const double turn = kTwoPi * 440 / 48000;
  CHECK(AudioRig::roughness(velocity, turn) < 1e-5 * rig.amplitude * rig.omega);
}

TEST_CASE("in wall time the network is played smoothly behind the servo, over bursts of blocks") {
  AudioRig rig(48000, 100);
  rig.link->configure(SignalLink::Time::kWall, 1000, {});
  rig.player->prepare(48000);
  rig.player->attach(rig.link.get());
  double largest_step = 0, last = 0, max_amplitude = 0;
  for (int burst = 0; burst < 800; ++burst) {
    const double wall_s = (burst + 1) * 256 / 48000.0;
    while (static_cast<double>(rig.network.ticks) * 1e-3 <= wall_s)
      rig.tick();
    for (int b = 0; b < 4; ++b) {
      rig.player->begin_block(64);
      for (int i = 0; i < 64; ++i) {
        const double now = rig.player->process({}).network[0];
        if (burst > 300) { // the delay that bursts need is learnt within a second
          largest_step = std::max(largest_step, std::abs(now - last));
          max_amplitude = std::max(max_amplitude, std::abs(now));
        }
        last = now;
      }
      rig.player->end_block(wall_s);
    }
  }
  const double speed = rig.amplitude * rig.omega;
  CHECK(max_amplitude == approx(speed).epsilon(1e-3));
  CHECK(largest_step < 1.05 * speed * rig.omega / 48000); // 2 % faster at most, no clicks
}

TEST_CASE("a second player does not play samples that an earlier one has read") {
  AudioRig rig;
  auto second = std::make_unique<SignalPlayer>();
  for (SignalPlayer* player : {rig.player.get(), second.get()}) {
    rig.play_in_logical_time(*player, 48000);
    player->begin_block(4800);
    double sum = 0;
    for (int i = 0; i < 4800; ++i) {
      const double v = player->process({}).network[0];
      CHECK(std::isfinite(v));
      sum += std::abs(v);
    }
    CHECK(sum > 0.1);
    player->attach(nullptr);
  }
}
