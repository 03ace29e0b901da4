#pragma once

#include "net/message.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactus::net {

/// How messages are delimited on a stream. The first byte of a connection selects the framing.
enum class Framing : std::uint8_t {
  kSlip,   ///< first byte 0xC0: OSC packets by RFC 1055 with an END on both sides, as in OSC 1.1;
           ///< also `/` or `#`, since RFC 1055 requires only the END after a packet
  kLength, ///< first byte 0x00: each OSC packet after its length, 4 bytes big-endian, as in OSC 1.0
  kFudi,   ///< any other printable byte: text, each message ended by a semicolon
};

/// Longest OSC packet or text message, bytes.
inline constexpr std::size_t kMaxPacket = 65536;

/// Cuts a stream of bytes into messages. Allocates nothing; takes a bounded time per byte.
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
  /// nullopt before the first byte.
  [[nodiscard]] std::optional<Framing> framing() const noexcept { return framing_; }
  /// True while a frame has begun but is not complete.
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
  bool may_be_text_ = false; ///< kSlip whose first packet contains no END or zero so far
  std::uint32_t length_ = 0; ///< length of the packet, for kLength
  int length_bytes_ = 0;     ///< length bytes received so far
  std::uint32_t discarded_ = 0;
  std::string_view reason_{};
};

/// Longest frame that this side sends, bytes; every message of the protocol fits.
inline constexpr std::size_t kMaxSent = 2048;

/// Writes a message with its framing; returns the bytes written, 0 if they do not fit or if the
/// packet is longer than kMaxSent.
[[nodiscard]] std::size_t encode_frame(Framing framing, const Message& message,
                                       std::span<std::uint8_t> out) noexcept;

} // namespace tactus::net
