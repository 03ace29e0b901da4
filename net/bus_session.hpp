#pragma once

#include "net/admission.hpp"
#include "net/peer_connection.hpp"
#include "net/playout_clock.hpp"
#include "net/playout_delay.hpp"

#include <functional>
#include <utility>

namespace tactus::net {

/// Settings of one end of a bus link.
struct BusSettings {
  std::string name = "tactus";
  std::string token{}; ///< sent by the caller, required by the listener; empty: no token
};

/// One connection between two buses of modules (docs/formats/haptic_protocol.md, "Buses"). The
/// caller sends hello and the listener answers welcome; after that both sides are equal. No
/// sockets, threads or clocks; times in s by one clock, never decreasing.
class BusSession : public PeerConnection {
public:
  enum class Side { kListener, kCaller };
  /// Receives a topic's fields, without its head. sent_s: time of sending on this side's clock.
  /// late: the message arrived after its playout time. Returns false if there is no room for the
  /// message.
  using Receiver = std::function<bool(const Message& message, double sent_s, bool late)>;

  /// Maximum number of queued bytes of streams: 0.75 s at 1000 positions a second, so that a
  /// connection that stalls for a shorter time loses no contact.
  static constexpr std::size_t kStreamLimit = 1u << 16;
  /// Exchanges of clock readings before messages are sent, and their interval.
  static constexpr int kFirstPings = 8;
  static constexpr double kFirstPing_s = 0.01;
  /// Maximum number of topics a second: kPackets_hz minus pings and pongs.
  static constexpr double kTopics_hz = 4800;

  BusSession(Side side, const BusSettings& settings, Admission& admission, std::string peer,
             double now_s);

  void receive(std::span<const std::uint8_t> bytes, double now_s, const Receiver& receiver);
  void advance(double now_s);
  /// Sends a topic with its fields. sent: reading of this side's clock. A sample of a stream may be
  /// dropped.
  void send(const Message& topic, std::uint32_t sent, double now_s);

  /// True once both sides have been admitted and know each other's clock, so that messages can be
  /// exchanged.
  [[nodiscard]] bool ready() const noexcept { return ready_ && !closing; }
  /// True if nothing has been received for 500 ms.
  [[nodiscard]] bool late(double now_s) const noexcept {
    return now_s - last_message_s >= kSilence_s;
  }
  [[nodiscard]] PlayoutDelay& playout() noexcept { return playout_; }
  [[nodiscard]] const PlayoutClock& clock() const noexcept { return clock_; }
  /// The reason for which the connection ended: one sentence or a word of the protocol.
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }
  /// The error that the other side has reported since the last call; empty if there is none.
  [[nodiscard]] std::string take_warning() { return std::exchange(warning_, {}); }
  /// Number of events that the other side sent but this side did not receive; 0 while both follow
  /// the protocol.
  [[nodiscard]] std::uint64_t lost_events() const noexcept { return lost_events_; }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

private:
  struct Refusal {
    std::string_view code{}, text{};
  };

  void take(FrameReader::Outcome outcome, const Message& message, double now_s,
            const Receiver& receiver);
  [[nodiscard]] Refusal handle(const Message& message, double now_s, const Receiver& receiver);
  [[nodiscard]] Refusal on_hello(const Message& message, double now_s);
  [[nodiscard]] Refusal on_welcome(const Message& message, double now_s);
  [[nodiscard]] Refusal on_clock(const Message& message, double now_s);
  [[nodiscard]] Refusal on_topic(const Message& message, double now_s, const Receiver& receiver);
  void count_event(const Message& message, double now_s);
  void welcome(double now_s);
  void ping(double now_s);
  void send_clock(Address address, std::int32_t sequence, double now_s);
  void end(std::string_view why);

  Side side_;
  const BusSettings& settings_;
  Admission& admission_;
  PlayoutClock clock_{};
  PlayoutDelay playout_{};
  RateLimit sending_{kTopics_hz};
  double pinged_s_ = -1e18;
  bool ready_ = false;
  std::int32_t pings_ = 0, clocks_ = 0; ///< pings sent; clock readings of the other side accepted
  std::uint32_t events_sent_ = 0, events_taken_ = 0;
  std::uint64_t lost_events_ = 0, dropped_ = 0;
  std::string reason_{}, warning_{};
};

} // namespace tactus::net
