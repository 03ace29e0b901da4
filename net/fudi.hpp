#pragma once

#include "net/message.hpp"

#include <span>

namespace tactus::net {

/// Pd's text protocol: words separated by blanks, each message ended by a semicolon; a backslash
/// takes the next character literally. A word without a backslash that reads as a number is a
/// number. Whole numbers of 32 bits are integers, others are floats.
///
/// Decodes the text before a semicolon, in place: escapes are resolved inside the text, and strings
/// of the message are views into it. Returns an empty text, or one sentence if the message is bad.
/// `found` is false if there were only blanks.
[[nodiscard]] std::string_view decode_fudi(std::span<char> text, Message& message,
                                           bool& found) noexcept;

/// Writes a message of a known address with its semicolon and a newline; returns the bytes written,
/// 0 if they do not fit. FUDI has no empty word, so an empty string is sent as `-`. Control
/// characters are sent as `?`.
[[nodiscard]] std::size_t encode_fudi(const Message& message, std::span<char> out) noexcept;

} // namespace tactus::net
