#pragma once

#include "net/message.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactus::net {

/// How messages are delimited on a stream; the first byte of a connection chooses.
enum class Framing : std::uint8_t {
  kSlip,   ///< 0xC0: OSC packets by RFC 1055, an END on both sides, as OSC 1.1 has it; `/` and `#`
           ///< too, as RFC 1055 asks for the END behind a packet alone
  kLength, ///< 0x00: OSC packets behind their length in 4 bytes, big-endian, as OSC 1.0 has it
  kFudi,   ///< another printable byte: text, messages ended by a semicolon
};

/// Longest OSC packet or text message, bytes.
inline constexpr std::size_t kMaxPacket = 65536;

/// Cuts a stream of bytes into messages. Allocates nothing; costs a bounded time a byte.
class FrameReader {
public:
  enum class Outcome {
    kNeedMore, ///< the input is used up
    kMessage,
    kRefused, ///< a valid packet that is not supported here: reason()
    kBad,     ///< a dropped packet: reason(); the next one is read as usual
    kBroken,  ///< the framing is lost: reason(); nothing more is read
  };

  /// Consumes input up to the end of the next frame. The message's strings are valid until the next
  /// call.
  [[nodiscard]] Outcome next(std::span<const std::uint8_t>& input, Message& message) noexcept;
  /// One sentence after kRefused, kBad and kBroken.
  [[nodiscard]] std::string_view reason() const noexcept { return reason_; }
  /// Nothing before the first byte.
  [[nodiscard]] std::optional<Framing> framing() const noexcept { return framing_; }
  /// A frame has begun and is not complete.
  [[nodiscard]] bool in_frame() const noexcept { return in_frame_; }

private:
  [[nodiscard]] Outcome take_slip(std::uint8_t byte, Message& message) noexcept;
  [[nodiscard]] Outcome take_length(std::uint8_t byte, Message& message) noexcept;
  [[nodiscard]] Outcome take_text(std::uint8_t byte, Message& message) noexcept;
  [[nodiscard]] Outcome decode_packet(Message& message) noexcept;
  [[nodiscard]] bool take_element(Message& message) noexcept;
  [[nodiscard]] Outcome bad(std::string_view reason) noexcept;
  [[nodiscard]] Outcome broken(std::string_view reason) noexcept;
  [[nodiscard]] bool append_byte(std::uint8_t byte) noexcept;
  void begin_frame() noexcept;

  std::optional<Framing> framing_{};
  std::array<std::uint8_t, kMaxPacket> packet_{};
  std::size_t size_ = 0;
  std::size_t elements_begin_ = 0, elements_end_ = 0; ///< the rest of a bundle in packet_
  bool in_frame_ = false, discarding_ = false, escaping_ = false, broken_ = false;
  bool may_be_text_ = false; ///< kSlip whose first packet had neither an END nor a zero yet
  std::uint32_t length_ = 0; ///< of the packet, kLength
  int length_bytes_ = 0;     ///< length bytes received so far
  std::uint32_t discarded_ = 0;
  std::string_view reason_{};
};

/// Longest frame that this side sends, bytes; every message of the protocol fits.
inline constexpr std::size_t kMaxSent = 2048;

/// Writes a message with its framing; returns the bytes written, 0 when they do not fit or the
/// packet is longer than kMaxSent.
[[nodiscard]] std::size_t encode_frame(Framing framing, const Message& message,
                                       std::span<std::uint8_t> out) noexcept;

} // namespace tactus::net
