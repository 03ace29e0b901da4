#include "net/session.hpp"

namespace tactus::net {
namespace {

using Buffer = std::array<std::uint8_t, 2 * kMaxSent + 2>;

std::span<const std::uint8_t> encoded(const Session& session, const Message& message,
                                      Buffer& buffer) noexcept {
  if (!session.reader.framing())
    return {};
  return {buffer.data(), encode_frame(*session.reader.framing(), message, buffer)};
}

} // namespace

void Session::send_event(const Message& message) {
  Buffer buffer;
  if (!closing && !out.add_event(encoded(*this, message, buffer)))
    closing = true; // it does not read, so there is nobody to tell
}

void Session::send_sample(const Message& message) {
  Buffer buffer;
  if (!closing)
    out.add_sample(encoded(*this, message, buffer));
}

void Session::send_error(std::string_view code, std::string_view text, double now_s) {
  constexpr std::size_t kMaxText = 256;
  if (errors.allow(now_s))
    send_event(Message(Address::kError).string(code).string(text.substr(0, kMaxText)));
}

void Session::say_goodbye(std::string_view reason) {
  send_event(Message(Address::kBye).string(reason));
  closing = true;
}

} // namespace tactus::net
