#pragma once

#include "net/message.hpp"

#include <span>

namespace tactus::net {

/// OSC 1.0 (Wright 2002): an address, a comma and type tags, then the arguments, each string
/// terminated and padded with zeros to a multiple of four bytes, numbers big-endian. The protocol
/// uses the tags i, f and s. It also accepts h, d and S as these, T as 1 and F as 0.
///
/// Decodes one message. Returns an empty text, or one sentence if the message is bad: a string
/// without an end, another tag (kOtherType), bytes missing or left over, a number that is not
/// finite, a bundle. Strings of the message are views into the packet.
[[nodiscard]] std::string_view decode_osc(std::span<const std::uint8_t> packet,
                                          Message& message) noexcept;
inline constexpr std::string_view kOtherType =
    "unsupported type tag: expected i, f, s, d, h, T or F";

/// Checks a packet with all messages of its bundle, and of bundles within that, so that a packet
/// with a bad message has no effect at all. Returns an empty text, or one sentence as decode_osc()
/// does.
[[nodiscard]] std::string_view check_osc(std::span<const std::uint8_t> packet) noexcept;
/// Removes the next message from the rest of a packet that check_osc() accepted; empty at the
/// packet's end. Time tags are ignored.
[[nodiscard]] std::span<const std::uint8_t>
next_message(std::span<const std::uint8_t>& rest) noexcept;

/// Writes a message of a known address; returns the bytes written, 0 if they do not fit. A string
/// is cut at a zero byte.
[[nodiscard]] std::size_t encode_osc(const Message& message, std::span<std::uint8_t> out) noexcept;

} // namespace tactus::net
