#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

/// Rate and time limits for one client, and the counters that enforce them. Times are in s, all by
/// the same clock.
namespace tactus::net {

/// Positions are in metres in the program and in millimetres in messages.
inline constexpr double kM_per_mm = 1e-3;
inline constexpr double kMm_per_m = 1e3;

inline constexpr int kProtocol = 1;
inline constexpr int kPort = 7770;
/// Maximum numbers of simultaneous clients and pending connections. A connection is pending until
/// it has sent hello, with the token if one is required.
inline constexpr std::size_t kMaxClients = 8, kMaxPending = 4;
inline constexpr std::size_t kMaxConnections = kMaxClients + kMaxPending;
inline constexpr std::size_t kMaxControlPoints = 4096;
inline constexpr std::size_t kMaxName = 64;

/// Force ends when its client has been silent for this long; it begins to fall after kHold_s.
inline constexpr double kSilence_s = 0.5;
inline constexpr double kRamp_s = 0.05;
inline constexpr double kHold_s = kSilence_s - kRamp_s;
inline constexpr double kPingInterval_s = 0.25;
/// A client that sends the server's time back counts as alive while that time is not older than
/// this. The limit leaves room for the interval of its pings (250 ms) and the round trip.
inline constexpr double kMaxAge_s = 1;
/// A client that was silent for this long is disconnected.
inline constexpr double kTimeout_s = 5;
/// A pending connection ends after this time, whatever it sends.
inline constexpr double kHello_s = 2;
/// A frame that has not been completed for this long ends its connection.
inline constexpr double kFrameTimeout_s = 2;
/// A sequence number that goes back by at most this much is old; a larger step back is an error.
inline constexpr int kSequenceWindow = 1000;
/// The last value of a counter before it restarts. kShortCount is for a peer that may be Pd, whose
/// text has six digits; kLongCount is for peers with exact integers.
inline constexpr std::int32_t kLongCount = 0x7fffffff, kShortCount = 0x7ffff;

/// Limits events to a number per second, all of which may come at once (a token bucket).
class RateLimit {
public:
  explicit RateLimit(double per_second) noexcept : per_second_(per_second), tokens_(per_second) {}
  [[nodiscard]] bool allow(double now_s) noexcept {
    tokens_ = std::min(per_second_, tokens_ + std::max(0.0, now_s - last_s_) * per_second_);
    last_s_ = std::max(last_s_, now_s);
    if (tokens_ < 1)
      return false;
    tokens_ -= 1;
    return true;
  }

private:
  double per_second_, tokens_, last_s_ = 0;
};

/// True at the 20th event within a second.
class BadPackets {
public:
  static constexpr std::size_t kMax = 20;
  [[nodiscard]] bool add(double now_s) noexcept {
    times_s_[next_++ % kMax] = now_s;
    return next_ >= kMax && now_s - times_s_[next_ % kMax] < 1;
  }

private:
  std::array<double, kMax> times_s_{};
  std::size_t next_ = 0;
};

/// The time at which the controlling client last counted as alive. After a silence a single burst
/// does not count, since a network may deliver delayed messages long after their sender has ended.
/// The client counts as alive again once messages have arrived for kReturn_s.
class Liveness {
public:
  static constexpr double kReturn_s = 0.1;

  void start(double now_s) noexcept {
    last_message_s_ = alive_s_ = now_s;
    lost_ = false;
  }
  void on_message(double now_s) noexcept {
    if (now_s - last_message_s_ > kHold_s) {
      lost_ = true;
      resumed_s_ = now_s;
    }
    last_message_s_ = now_s;
    if (lost_ && now_s - resumed_s_ >= kReturn_s)
      lost_ = false;
    if (!lost_)
      alive_s_ = now_s;
  }
  /// Sent to the servo as its heartbeat.
  [[nodiscard]] double alive_s() const noexcept { return alive_s_; }

private:
  double last_message_s_ = 0, alive_s_ = 0, resumed_s_ = 0;
  bool lost_ = false;
};

} // namespace tactus::net
