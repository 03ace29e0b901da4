#pragma once

#include "net/framing.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// Bytes on the wire, written and read by tests.
namespace tactus::net {

using Bytes = std::vector<std::uint8_t>;

inline Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()),
          reinterpret_cast<const std::uint8_t*>(text.data()) + text.size()};
}

inline Bytes frame(Framing framing, const Message& message) {
  Bytes bytes(2 * kMaxSent);
  bytes.resize(encode_frame(framing, message, bytes));
  return bytes;
}

/// `/hap/force 1 -2 0.5` byte by byte, as the OSC 1.0 specification lays it out.
inline Bytes force_packet() {
  Bytes packet = bytes_of(std::string_view("/hap/force\0\0,fff\0\0\0\0", 20));
  for (const int byte : {0x3F, 0x80, 0, 0, 0xC0, 0, 0, 0, 0x3F, 0, 0, 0})
    packet.push_back(static_cast<std::uint8_t>(byte));
  return packet;
}

inline Bytes with_length(const Bytes& packet) {
  Bytes bytes;
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(packet.size() >> shift));
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

inline Bytes bundle(const std::vector<Bytes>& elements) {
  Bytes bytes = bytes_of(std::string_view("#bundle\0\0\0\0\0\0\0\0\1", 16));
  for (const Bytes& element : elements) {
    const Bytes sized = with_length(element);
    bytes.insert(bytes.end(), sized.begin(), sized.end());
  }
  return bytes;
}

/// What a message looks like, kept after its bytes are gone.
inline std::string to_text(const Message& message) {
  std::string text(message.name());
  for (std::size_t i = 0; i < message.size(); ++i)
    text += message.string_at(i) ? " '" + std::string(*message.string_at(i)) + "'"
                                 : " " + std::to_string(*message.number_at(i));
  return text;
}

/// Everything that a reader finds, one line an outcome; the stream is cut into pieces of `piece`.
inline std::vector<std::string> read_all(const Bytes& bytes, std::size_t piece = 1u << 20) {
  auto reader = std::make_unique<FrameReader>();
  std::vector<std::string> found;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    std::span<const std::uint8_t> rest(bytes.data() + at, std::min(piece, bytes.size() - at));
    Message message;
    for (;;) {
      const auto outcome = reader->next(rest, message);
      if (outcome == FrameReader::Outcome::kNeedMore)
        break;
      if (outcome == FrameReader::Outcome::kMessage)
        found.push_back(to_text(message));
      else
        found.push_back((outcome == FrameReader::Outcome::kBad       ? "bad: "
                         : outcome == FrameReader::Outcome::kRefused ? "refused: "
                                                                     : "broken: ") +
                        std::string(reader->reason()));
      if (outcome == FrameReader::Outcome::kBroken)
        return found;
    }
  }
  return found;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

} // namespace tactus::net
