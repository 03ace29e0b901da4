#pragma once

#include "net/framing.hpp"
#include "net/limits.hpp"
#include "net/out_queue.hpp"

#include <string>

namespace tactus::net {

/// One connection, from its first byte to its last: the part common to the haptic and the bus
/// protocol.
struct PeerConnection {
  static constexpr double kPackets_hz = 5000, kErrors_hz = 20;

  PeerConnection(std::string peer_address, double now_s,
                 std::size_t stream_limit = OutQueue::kStreamLimit)
      : peer(std::move(peer_address)), out(stream_limit), last_message_s(now_s),
        frame_since_s(now_s), connected_s(now_s) {}

  std::string peer, name = "-";
  bool admitted = false; ///< hello was answered by welcome
  bool closing = false;  ///< the connection ends once the queue is sent

  FrameReader reader{};
  OutQueue out;
  double last_message_s; ///< time of the last valid message
  double frame_since_s;  ///< last time at which no frame was incomplete
  double connected_s;
  RateLimit packets{kPackets_hz}, errors{kErrors_hz};
  BadPackets bad_packets{};
  bool flooding = false; ///< above the rate limit; the error has been sent

  /// The last value of this side's counters before they restart. A peer that may be Pd uses text or
  /// SLIP.
  [[nodiscard]] std::int32_t last_count() const noexcept {
    return reader.framing() == Framing::kLength ? kLongCount : kShortCount;
  }

  /// Has no effect before the first byte has decided the framing.
  void send_event(const Message& message);
  /// Returns false if the sample was dropped.
  bool send_sample(const Message& message);
  /// At most kErrors_hz a second are sent.
  void send_error(std::string_view code, std::string_view text, double now_s);
  void send_bye(std::string_view reason);
  /// Sends the reason why hello is refused, as a code of refusal_text(), and ends the connection.
  void refuse_hello(std::string_view code, double now_s);

  /// Reads the next frame of the received bytes, and updates frame_since_s.
  [[nodiscard]] FrameReader::Outcome next(std::span<const std::uint8_t>& bytes, Message& message,
                                          double now_s) noexcept;
  /// Answers a dropped packet with an error; the 20th within a second ends the connection.
  void count_bad_packet(std::string_view code, std::string_view text, double now_s);
  /// Ends the connection if a frame stays incomplete for 2 s, if the peer is silent for 5 s, or if
  /// the peer is not admitted within 2 s, whatever it sends.
  void check_timeouts(double now_s);

protected:
  /// The framing of the side that sends first; the other side adopts it.
  std::optional<Framing> begins_in{};

private:
  [[nodiscard]] std::span<const std::uint8_t> encoded(const Message& message,
                                                      std::span<std::uint8_t> buffer) noexcept;
};

} // namespace tactus::net
