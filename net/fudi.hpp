#pragma once

#include "net/message.hpp"

#include <span>

namespace tactus::net {

/// Pd's text protocol: words parted by blanks, each message ended by a semicolon; a backslash takes
/// the next character literally. A word that reads as a number and has no backslash is one; whole
/// numbers of 32 bits are integers, others floats.
///
/// Decodes the text before a semicolon, in place: escapes are resolved where they stand, and
/// strings of the message are views into the text. Empty, or one sentence when the message is bad.
/// `found` is false when there were only blanks.
[[nodiscard]] std::string_view decode_fudi(std::span<char> text, Message& message,
                                           bool& found) noexcept;

/// Writes a message of a known address with its semicolon and a newline; returns the bytes written,
/// 0 when they do not fit. FUDI has no empty word: an empty string is sent as `-`. Control
/// characters are sent as `?`.
[[nodiscard]] std::size_t encode_fudi(const Message& message, std::span<char> out) noexcept;

} // namespace tactus::net
