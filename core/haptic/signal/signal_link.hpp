#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/dsp/ring.hpp"
#include "core/haptic/network/network_model.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/servo.hpp"

#include <atomic>
#include <limits>

/// Connects audio and the servo: signals become forces, positions become signals.
/// docs/phantom_signal.md.
namespace tactus::haptic {

/// The data that a device's servo shares with an object that processes audio. Three sides use it:
/// the host, which owns the servo; the servo, as a LocalModel; and the audio object.
///
/// Logical time: the audio steps the servo at the sample where a tick is due, all in one thread.
/// Wall time: the servo's thread and the audio thread exchange values through mailboxes and rings.
class SignalLink final : public LocalModel {
public:
  /// The force that the signals request at one instant.
  struct Force {
    Vec3 force_n{};
    double time_s = 0; ///< wall time only: time at which the audio wrote the force
  };
  /// The servo's report to the audio in one tick.
  struct Sample {
    double time_s = 0;
    Vec3 position{}; ///< m
    Vec3 velocity{}; ///< m/s
    bool touching = false;
    std::uint64_t network_samples = 0; ///< number of network samples sent up to this tick
  };
  /// Callback to the owner of the servo, for audio that steps it.
  struct Stepper {
    void (*step)(void* context) = nullptr;
    void* context = nullptr;
  };
  enum class Time : int { kNone, kLogical, kWall };

  // the host's side
  /// Time 0 of the servo's ticks on the clock that the audio object shares.
  void set_origin(double origin_s) noexcept {
    origin_s_.store(origin_s, std::memory_order_relaxed);
  }
  void configure(Time time, double rate_hz, Stepper stepper) noexcept {
    stepper_ = stepper;
    rate_hz_.store(rate_hz, std::memory_order_relaxed);
    time_.store(time, std::memory_order_release);
  }
  void set_workspace(const Workspace& workspace) noexcept { workspaces_.write(workspace); }
  /// The scene whose contact gates the vibration and gives its direction.
  void set_scene(const SceneModel& scene) noexcept { scene_ = &scene; }
  /// The network whose pickups are played. Its force() must be called before force() of this link.
  void set_network(const NetworkModel& network) noexcept { network_ = &network; }
  /// Number of audio blocks (which shows whether audio runs), and duration of the longest.
  [[nodiscard]] std::uint64_t blocks() const noexcept {
    return blocks_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] double max_block_s() const noexcept {
    return max_block_s_.load(std::memory_order_relaxed);
  }

  /// While the audio steps the servo: when that tick is due.
  [[nodiscard]] double due_s() const noexcept { return due_s_; }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;

  // the audio's side
  [[nodiscard]] Time time() const noexcept { return time_.load(std::memory_order_acquire); }
  [[nodiscard]] double rate_hz() const noexcept { return rate_hz_.load(std::memory_order_relaxed); }
  [[nodiscard]] double origin_s() const noexcept {
    return origin_s_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] const Workspace& workspace() noexcept {
    workspaces_.read();
    return workspaces_.latest();
  }
  /// For one audio object at a time; false when another object has the link.
  [[nodiscard]] bool acquire() noexcept { return !taken_.exchange(true); }
  void release() noexcept { taken_.store(false); }
  void count_block(double duration_s) noexcept;
  /// Logical time: runs the tick that is due at due_s with these signals and returns its result.
  /// due_s NaN: one period after the last tick.
  Sample step(const Vec3& force_n, double vibration_n, bool gated, double due_s) noexcept;
  /// Logical time: the last tick, run by any object; its time is NaN before the first.
  [[nodiscard]] const Sample& last_tick() const noexcept { return tick_sample_; }
  /// Wall time: the newest force counts.
  void write_force(const Force& force) noexcept { forces_.write(force); }
  /// Wall time: one value for each tick, in order; false when the servo does not read them.
  bool push_vibration(double newton) noexcept { return vibrations_.push(newton); }
  void set_gate(bool gated) noexcept { gated_.store(gated, std::memory_order_relaxed); }
  [[nodiscard]] bool next(Sample& sample) noexcept { return samples_.pop(sample); }
  /// The network's pickups in order; taken_samples() counts them since the link was made.
  [[nodiscard]] bool next(NetworkSample& sample) noexcept {
    const bool found = network_samples_.pop(sample);
    taken_samples_ += found;
    return found;
  }
  [[nodiscard]] std::uint64_t taken_samples() const noexcept { return taken_samples_; }

private:
  static constexpr double kStale_s = 0.1; ///< a force older than this counts as zero
  static constexpr std::size_t kVibrationDelay = 4, kMaxQueuedVibration = 64; // ticks

  [[nodiscard]] Vec3 vibration(double newton, bool gated) const noexcept;
  [[nodiscard]] double next_vibration() noexcept;
  void send_network() noexcept;

  std::atomic<Time> time_{Time::kNone};
  std::atomic<double> rate_hz_{1000}, max_block_s_{0}, origin_s_{0};
  std::atomic<std::uint64_t> blocks_{0};
  std::atomic<bool> taken_{false}, gated_{true};
  Stepper stepper_{};
  const SceneModel* scene_ = nullptr;
  const NetworkModel* network_ = nullptr;
  Mailbox<Workspace> workspaces_;
  Mailbox<Force> forces_;
  Ring<double, 1024> vibrations_;
  Ring<Sample, 1024> samples_;
  Ring<NetworkSample, 32768> network_samples_;
  std::uint64_t sent_samples_ = 0, taken_samples_ = 0; // the servo's and the audio's count

  // logical time: for the current tick
  Vec3 force_now_{};
  double vibration_now_ = 0, due_s_ = 0;
  bool gated_now_ = true, stepping_ = false;
  Sample tick_sample_{std::numeric_limits<double>::quiet_NaN()};
  // wall time
  bool playing_ = false;
  double last_vibration_ = 0;
};

} // namespace tactus::haptic
