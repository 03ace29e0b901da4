#pragma once

#include "core/haptic/servo/mailbox.hpp"

#include <algorithm>
#include <chrono>

namespace tactus::haptic {

/// What every driver does that keeps a force by itself - in a thread of its own, or in a device
/// that holds its last command: a servo that has not written for 50 ms gets no force, however the
/// last command read. When it writes again the force returns over 0.1 s, since the force chain
/// knows nothing of the pause and begins at full force.
class ForceTimeout {
public:
  static constexpr double kTimeout_s = 0.05, kReturn_s = 0.1;

  /// Share of the newest command that may be sent now, 0 to 1. For the thread that sends; times by
  /// one clock, non-decreasing. Before the first write there is none.
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
  /// The last gain() found no servo.
  [[nodiscard]] bool expired() const noexcept { return expired_; }

  /// The clock of all drivers' threads, s.
  [[nodiscard]] static double now_s() noexcept {
    using Steady = std::chrono::steady_clock;
    return std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
  }

private:
  bool expired_ = true;
  double resumed_s_ = 0;
};

/// The newest command of a servo for the thread that sends it, with the rule above.
template <class Command> class TimedMailbox {
public:
  /// For the servo.
  void write(const Command& command) noexcept { box_.write({command, ForceTimeout::now_s()}); }
  /// Forgets what was written; while nobody reads.
  void reset() noexcept {
    box_.write({});
    timeout_ = {};
  }
  /// For the thread that sends: takes the newest command; gain() is then its share.
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
