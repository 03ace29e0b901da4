#pragma once

#include "core/haptic/signal/decimator.hpp"
#include "core/haptic/signal/signal_link.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <span>

namespace tactus::haptic {

/// The audio side of a SignalLink: input samples become forces of the servo, the servo's positions
/// become output samples.
///
/// Logical time: a tick is due one period after the last tick, whichever object has run the last
/// one. The tick runs at the first sample at or after this time and reads that sample. Between
/// ticks the output is interpolated linearly from the last position to the present one, so it is
/// one servo period late. The result does not depend on the block size.
///
/// Wall time: the last sample of a block is the force. Positions are read from a buffer, delay_s
/// behind the newest, at a rate that follows the drift between the two clocks. If the host computes
/// blocks in bursts longer than the delay, the delay grows as needed.
///
/// The network's pickups are interpolated between their steps by a cubic and played with the
/// positions, later by one sample period of the pickups.
class SignalPlayer {
public:
  struct Inputs {
    Vec3 force_n;
    double vibration_n = 0;
  };
  struct Outputs {
    Vec3 position;                                   ///< 0..1 over the workspace
    Vec3 velocity;                                   ///< m/s
    std::array<double, Network::kPickups> network{}; ///< pickups of the phantom's mass-spring
                                                     ///< network
  };

  void prepare(double sample_rate_hz) noexcept;
  void set_delay(double delay_s) noexcept { delay_s_ = delay_s; }
  /// true: the vibration acts only while the handle touches a body of the scene.
  void set_gate(bool gated) noexcept { gated_ = gated; }
  /// To be called in the thread of process(), or while process() does not run. Null: the outputs
  /// hold their value.
  void attach(SignalLink* link) noexcept;

  /// To be called before and after a block. start_s: logical time of its first sample on the clock
  /// of the link's origin; without start_s the first tick is at the first sample, and the other
  /// ticks follow one period apart. wall_s is the present wall-clock time.
  void begin_block(std::size_t frames,
                   double start_s = std::numeric_limits<double>::quiet_NaN()) noexcept;
  void end_block(double wall_s) noexcept;
  [[nodiscard]] Outputs process(const Inputs& inputs) noexcept;

private:
  using Sample = SignalLink::Sample;
  static constexpr std::size_t kHistory = 1024;
  static constexpr int kMaxTicksPerSample = 64;
  static constexpr std::size_t kNetworkHistory = 32768;

  void restart(SignalLink::Time time, double rate_hz) noexcept;
  void find_next_tick(double start_s) noexcept;
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

  std::uint64_t sample_ = 0, tick_ = 0; // counts since the last restart, or find_next_tick()
  // Logical time, of sample 0 and tick 0; not finite: unknown.
  double start_s_ = std::numeric_limits<double>::quiet_NaN(), due_s_ = start_s_;
  Sample previous_{}, current_{};
  bool stepped_ = false;
  Inputs inputs_{};
  Outputs last_{{0.5, 0.5, 0.5}, {}};

  std::array<Sample, kHistory> history_{};
  std::uint64_t written_ = 0;
  std::array<NetworkSample, kNetworkHistory> network_{}; // number n at n % kNetworkHistory
  double played_s_ = 0;
  double newest_s_ = 0;                                // time of the newest sample
  double since_newest_s_ = 0, max_since_newest_s_ = 0; // time played since the newest sample
                                                       // arrived
  bool playing_ = false;
};

} // namespace tactus::haptic
