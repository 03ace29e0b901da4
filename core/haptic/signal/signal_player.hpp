#pragma once

#include "core/haptic/signal/decimator.hpp"
#include "core/haptic/signal/signal_link.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::haptic {

/// The audio's side of a SignalLink: samples in become forces of the servo, its positions become
/// samples out.
///
/// Logical time: tick k lies at sample k fs/rate, counted from the first; it reads the sample at
/// which it falls due, and between ticks the output goes straight from the last position to the
/// present one, so it is one servo period late. Nothing depends on how the stream is cut.
///
/// Wall time: the last sample of a block is the force. Positions are played from a buffer,
/// `delay_s` behind the newest, at a speed that follows the two clocks' difference. Where the host
/// computes longer bursts of blocks than that delay covers, it grows by what they need.
///
/// The network's pickups are played beside the positions, one of their own samples later, by cubic
/// interpolation between the steps at which they were read.
class SignalPlayer {
public:
  struct Inputs {
    Vec3 force_n;
    double vibration_n = 0;
  };
  struct Outputs {
    Vec3 position;                                   ///< 0..1 over the workspace
    Vec3 velocity;                                   ///< m/s
    std::array<double, Network::kPickups> network{}; ///< of the phantom's mass-spring network
  };

  void prepare(double sample_rate_hz) noexcept;
  void set_delay(double delay_s) noexcept { delay_s_ = delay_s; }
  /// The vibration acts only while the handle touches a body of the scene.
  void set_gate(bool gated) noexcept { gated_ = gated; }
  /// In the thread of process(), or while it does not run. Null: the outputs stay.
  void attach(SignalLink* link) noexcept;

  /// Before a block, and after it; wall_s is the wall's time now.
  void begin_block(std::size_t frames) noexcept;
  void end_block(double wall_s) noexcept;
  [[nodiscard]] Outputs process(const Inputs& inputs) noexcept;

private:
  using Sample = SignalLink::Sample;
  static constexpr std::size_t kHistory = 1024;
  static constexpr int kMaxTicksPerSample = 64;
  static constexpr std::size_t kNetworkHistory = 32768;

  void restart(SignalLink::Time time, double rate_hz) noexcept;
  void step_due(const Inputs& inputs, double vibration_n) noexcept;
  void play(double vibration_n) noexcept;
  void collect() noexcept;
  void take_network(std::uint64_t until) noexcept;
  [[nodiscard]] NetworkSample network_sample(double number) const noexcept;
  [[nodiscard]] std::array<double, Network::kPickups> network_at(double number) const noexcept;
  [[nodiscard]] double target_time_s() const noexcept;
  [[nodiscard]] Outputs interpolated_output(const Sample& a, const Sample& b,
                                            double fraction) const noexcept;
  [[nodiscard]] const Sample& newest(std::size_t age) const noexcept {
    return history_[(written_ - 1 - age) % kHistory];
  }

  SignalLink* link_ = nullptr;
  Workspace workspace_{};
  Decimator decimator_{};
  double sample_rate_hz_ = 48000, rate_hz_ = 0, delay_s_ = 3e-3;
  bool gated_ = true;
  SignalLink::Time time_ = SignalLink::Time::kNone;

  std::uint64_t sample_ = 0, tick_ = 0; // since the last restart
  Sample previous_{}, current_{};
  bool stepped_ = false;
  Inputs inputs_{};
  Outputs last_{{0.5, 0.5, 0.5}, {}};

  std::array<Sample, kHistory> history_{};
  std::uint64_t written_ = 0;
  std::array<NetworkSample, kNetworkHistory> network_{}; // number n at n % kNetworkHistory
  double played_s_ = 0;
  double newest_s_ = 0, since_newest_s_ = 0,
         max_since_newest_s_ = 0; // newest time; played since it came
  bool playing_ = false;
};

} // namespace tactus::haptic
