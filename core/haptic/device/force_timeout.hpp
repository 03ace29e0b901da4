#pragma once

#include "core/dsp/mailbox.hpp"

#include <algorithm>
#include <chrono>

namespace tactus::haptic {

/// Timeout of the force in a driver that holds the last command, in its own thread or in the
/// device: the force is zero when the servo has not written for 50 ms. When the servo writes again,
/// the force returns by a linear ramp of 0.1 s, because the force chain is not informed of the
/// pause.
class ForceTimeout {
public:
  static constexpr double kTimeout_s = 0.05, kReturn_s = 0.1;

  /// Factor on the newest command, 0 to 1. For the sending thread. Both times are of one clock, s,
  /// and do not decrease. written_s far in the past, as before the first write, gives 0.
  [[nodiscard]] double gain(double written_s, double now_s) noexcept {
    if (!(now_s - written_s < kTimeout_s)) {
      expired_ = true;
      return 0;
    }
    if (expired_)
      resumed_s_ = now_s;
    expired_ = false;
    return std::clamp((now_s - resumed_s_) / kReturn_s, 0.0, 1.0);
  }
  /// Whether the last gain() was 0 because of the timeout.
  [[nodiscard]] bool expired() const noexcept { return expired_; }

  /// Time of the clock that all drivers' threads use, s.
  [[nodiscard]] static double now_s() noexcept {
    using Steady = std::chrono::steady_clock;
    return std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
  }

private:
  bool expired_ = true;
  double resumed_s_ = 0;
};

/// The newest command of the servo for the thread that sends it, with a ForceTimeout.
template <class Command> class TimedMailbox {
public:
  /// For the servo.
  void write(const Command& command) noexcept { box_.write({command, ForceTimeout::now_s()}); }
  /// Removes the command. Not to be called while another thread reads or writes.
  void reset() noexcept {
    box_.write({});
    timeout_ = {};
  }
  /// For the sending thread: the newest command. gain() is then the factor to apply to it.
  const Command& read() noexcept {
    box_.read();
    gain_ = timeout_.gain(box_.latest().written_s, ForceTimeout::now_s());
    return box_.latest().command;
  }
  [[nodiscard]] double gain() const noexcept { return gain_; }

private:
  struct Timed {
    Command command{};
    double written_s = -1e9;
  };
  Mailbox<Timed> box_;
  ForceTimeout timeout_{};
  double gain_ = 0;
};

} // namespace tactus::haptic
