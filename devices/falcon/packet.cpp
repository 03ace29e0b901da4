#include "devices/falcon/packet.hpp"

namespace tactus::devices::falcon {
namespace {

constexpr std::uint8_t kBegin = '<', kEnd = '>', kNought = 'A';
constexpr std::size_t kFlagsAt = 13, kEndAt = 15;
constexpr std::uint8_t kMostFlags = 0x7f;

Packet encode_packet(const Values& values, std::uint8_t flags) noexcept {
  Packet packet{};
  packet.front() = kBegin;
  std::size_t at = 1;
  for (const std::int16_t value : values)
    for (unsigned shift = 0; shift < 16; shift += 4) {
      const unsigned nibble = static_cast<std::uint16_t>(value) >> shift & 0xfu;
      packet[at++] = static_cast<std::uint8_t>(kNought + nibble);
    }
  packet[kFlagsAt] = static_cast<std::uint8_t>(kNought + (flags & kMostFlags));
  packet[kFlagsAt + 1] = kNought;
  packet[kEndAt] = kEnd;
  return packet;
}

} // namespace

Packet encode(const Order& order) noexcept { return encode_packet(order.motors, order.flags); }
Packet encode(const Answer& answer) noexcept {
  return encode_packet(answer.encoders, answer.flags);
}

void AnswerStream::refuse() noexcept {
  if (!between_)
    ++errors_;
  between_ = true;
  filled_ = 0;
}

bool AnswerStream::take(std::uint8_t byte) noexcept {
  if (byte == kBegin) {
    if (filled_ > 0)
      ++errors_;
    packet_[0] = byte;
    filled_ = 1;
    between_ = false;
    return false;
  }
  const unsigned digit = static_cast<unsigned>(byte) - kNought; // wraps below 'A'
  const bool fits = filled_ == 0          ? false
                    : filled_ < kFlagsAt  ? digit <= 0xf
                    : filled_ == kFlagsAt ? digit <= kMostFlags
                    : filled_ == kEndAt   ? byte == kEnd
                                          : true;
  if (!fits) {
    refuse();
    return false;
  }
  packet_[filled_++] = byte;
  if (filled_ < kPacketBytes)
    return false;
  filled_ = 0;
  for (std::size_t value = 0; value < 3; ++value) {
    unsigned bits = 0;
    for (std::size_t nibble = 0; nibble < 4; ++nibble)
      bits |= static_cast<unsigned>(packet_[1 + 4 * value + nibble] - kNought) << 4 * nibble;
    answer_.encoders[value] = static_cast<std::int16_t>(static_cast<std::uint16_t>(bits));
  }
  answer_.flags = static_cast<std::uint8_t>(packet_[kFlagsAt] - kNought);
  return true;
}

} // namespace tactus::devices::falcon
