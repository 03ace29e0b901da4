#pragma once

#include "net/message.hpp"

#include <span>

namespace tactus::net {

/// OSC 1.0 (Wright 2002): an address, a comma and type tags, then the arguments, each string ended
/// and filled up to four bytes with zeros, numbers big-endian. The protocol uses the tags i f s.
///
/// Decodes one packet. Empty, or one sentence when the packet is bad: a string without an end, an
/// unknown tag, bytes missing or left over, a number that is not finite, a bundle. Strings of the
/// message are views into the packet.
[[nodiscard]] std::string_view decode_osc(std::span<const std::uint8_t> packet,
                                          Message& message) noexcept;

/// Writes a message of a known address; returns the bytes written, 0 when they do not fit. A string
/// is cut at a zero byte.
[[nodiscard]] std::size_t encode_osc(const Message& message, std::span<std::uint8_t> out) noexcept;

} // namespace tactus::net
