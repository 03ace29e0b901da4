#include "devices/falcon/packet.hpp"

namespace tactus::devices::falcon {
namespace {

constexpr std::uint8_t kBegin = '<', kEnd = '>', kZeroNibble = 'A';
constexpr std::size_t kFlagsAt = 13, kEndAt = 15;
constexpr std::uint8_t kMaxFlags = 0x7f;

Packet encode_packet(const Values& values, std::uint8_t flags) noexcept {
  Packet packet{};
  packet.front() = kBegin;
  std::size_t at = 1;
  for (const std::int16_t value : values)
    for (unsigned shift = 0; shift < 16; shift += 4) {
      const unsigned nibble = static_cast<std::uint16_t>(value) >> shift & 0xfu;
      packet[at++] = static_cast<std::uint8_t>(kZeroNibble + nibble);
    }
  packet[kFlagsAt] = static_cast<std::uint8_t>(kZeroNibble + (flags & kMaxFlags));
  packet[kFlagsAt + 1] = kZeroNibble;
  packet[kEndAt] = kEnd;
  return packet;
}

} // namespace

Packet encode(const Command& command) noexcept {
  return encode_packet(command.motors, command.flags);
}
Packet encode(const Response& response) noexcept {
  return encode_packet(response.encoders, response.flags);
}

void ResponseParser::refuse() noexcept {
  if (!between_)
    ++errors_;
  between_ = true;
  filled_ = 0;
}

bool ResponseParser::process(std::uint8_t byte) noexcept {
  if (byte == kBegin) {
    if (filled_ > 0)
      ++errors_;
    packet_[0] = byte;
    filled_ = 1;
    between_ = false;
    return false;
  }
  const unsigned digit = static_cast<unsigned>(byte) - kZeroNibble; // wraps below 'A'
  const bool fits = filled_ == 0          ? false
                    : filled_ < kFlagsAt  ? digit <= 0xf
                    : filled_ == kFlagsAt ? digit <= kMaxFlags
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
      bits |= static_cast<unsigned>(packet_[1 + 4 * value + nibble] - kZeroNibble) << 4 * nibble;
    response_.encoders[value] = static_cast<std::int16_t>(static_cast<std::uint16_t>(bits));
  }
  response_.flags = static_cast<std::uint8_t>(packet_[kFlagsAt] - kZeroNibble);
  return true;
}

} // namespace tactus::devices::falcon
