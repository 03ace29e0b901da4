#include "net/peer_connection.hpp"

#include "net/admission.hpp"

namespace tactus::net {
namespace {

using Buffer = std::array<std::uint8_t, 2 * kMaxSent + 2>;

} // namespace

std::span<const std::uint8_t> PeerConnection::encoded(const Message& message,
                                                      std::span<std::uint8_t> buffer) noexcept {
  const std::optional<Framing> framing = reader.framing() ? reader.framing() : begins_in;
  if (!framing)
    return {};
  return buffer.first(encode_frame(*framing, message, buffer));
}

void PeerConnection::send_event(const Message& message) {
  Buffer buffer;
  if (!closing && !out.add_event(encoded(message, buffer)))
    closing = true; // no error is sent, because the peer does not read
}

bool PeerConnection::send_sample(const Message& message) {
  Buffer buffer;
  return !closing && out.add_sample(encoded(message, buffer));
}

void PeerConnection::send_error(std::string_view code, std::string_view text, double now_s) {
  constexpr std::size_t kMaxText = 256;
  if (errors.allow(now_s))
    send_event(Message(Address::kError).string(code).string(text.substr(0, kMaxText)));
}

void PeerConnection::send_bye(std::string_view reason) {
  send_event(Message(Address::kBye).string(reason));
  closing = true;
}

void PeerConnection::refuse_hello(std::string_view code, double now_s) {
  send_error(code, refusal_text(code), now_s);
  send_bye(code);
}

FrameReader::Outcome PeerConnection::next(std::span<const std::uint8_t>& bytes, Message& message,
                                          double now_s) noexcept {
  if (!reader.in_frame())
    frame_since_s = now_s;
  const FrameReader::Outcome outcome = reader.next(bytes, message);
  if (!reader.in_frame())
    frame_since_s = now_s;
  return outcome;
}

void PeerConnection::count_bad_packet(std::string_view code, std::string_view text, double now_s) {
  send_error(code, text, now_s);
  if (bad_packets.add(now_s))
    send_bye("bad");
}

void PeerConnection::check_timeouts(double now_s) {
  if (closing)
    return;
  if (reader.in_frame() && now_s - frame_since_s >= kFrameTimeout_s)
    send_bye("frame");
  else if (now_s - last_message_s >= kTimeout_s || (!admitted && now_s - connected_s >= kHello_s))
    send_bye("timeout");
}

} // namespace tactus::net
