#include "net/framing.hpp"

#include "net/fudi.hpp"
#include "net/osc.hpp"

namespace tactus::net {
namespace {

constexpr std::uint8_t kEnd = 0xC0, kEscape = 0xDB, kEscapedEnd = 0xDC, kEscapedEscape = 0xDD;
constexpr std::string_view kTooLong = "a packet is longer than 65536 bytes";

std::optional<Framing> framing_of(std::uint8_t first) noexcept {
  if (first == kEnd || first == '/' || first == '#')
    return Framing::kSlip;
  if (first == 0)
    return Framing::kLength;
  if (first >= 0x20 && first < 0x7f)
    return Framing::kFudi;
  return {};
}

} // namespace

void FrameReader::begin_frame() noexcept {
  size_ = 0;
  in_frame_ = discarding_ = escaping_ = false;
  length_ = 0;
  length_bytes_ = 0;
  discarded_ = 0;
}

FrameReader::Outcome FrameReader::bad(std::string_view reason) noexcept {
  reason_ = reason;
  return Outcome::kBad;
}

FrameReader::Outcome FrameReader::broken(std::string_view reason) noexcept {
  reason_ = reason;
  broken_ = true;
  in_frame_ = false;
  return Outcome::kBroken;
}

/// Returns false if the packet is full.
bool FrameReader::append_byte(std::uint8_t byte) noexcept {
  if (size_ == packet_.size())
    return false;
  packet_[size_++] = byte;
  return true;
}

FrameReader::Outcome FrameReader::decode_packet(Message& message) noexcept {
  const std::string_view reason = check_osc({packet_.data(), size_});
  elements_begin_ = 0;
  elements_end_ = reason.empty() ? size_ : 0;
  begin_frame();
  if (reason.empty())
    return take_element(message) ? Outcome::kMessage : Outcome::kNeedMore;
  reason_ = reason;
  return reason == kOtherType ? Outcome::kRefused : Outcome::kBad;
}

/// The next message of the packet received last.
bool FrameReader::take_element(Message& message) noexcept {
  auto rest = std::span<const std::uint8_t>(packet_).first(elements_end_).subspan(elements_begin_);
  const auto element = next_message(rest);
  elements_begin_ = elements_end_ - rest.size();
  return !element.empty() && decode_osc(element, message).empty();
}

/// Decodes RFC 1055. An END without a packet before it is a separator.
FrameReader::Outcome FrameReader::take_slip(std::uint8_t byte, Message& message) noexcept {
  if (byte == kEnd) {
    const bool complete = size_ > 0 && !discarding_ && !escaping_;
    const bool cut = escaping_ && !discarding_;
    if (complete)
      return decode_packet(message);
    begin_frame();
    return cut ? bad("an escape at the end of a SLIP frame") : Outcome::kNeedMore;
  }
  in_frame_ = true;
  if (discarding_)
    return Outcome::kNeedMore;
  if (escaping_) {
    escaping_ = false;
    if (byte != kEscapedEnd && byte != kEscapedEscape) {
      discarding_ = true;
      return bad("an unknown SLIP escape");
    }
    byte = byte == kEscapedEnd ? kEnd : kEscape;
  } else if (byte == kEscape) {
    escaping_ = true;
    return Outcome::kNeedMore;
  }
  if (append_byte(byte))
    return Outcome::kNeedMore;
  discarding_ = true;
  return bad(kTooLong);
}

FrameReader::Outcome FrameReader::take_length(std::uint8_t byte, Message& message) noexcept {
  if (length_bytes_ < 4) {
    in_frame_ = true;
    length_ = length_ << 8 | byte;
    if (++length_bytes_ < 4)
      return Outcome::kNeedMore;
    if (length_ > 0x7fffffffu)
      return broken("a packet's length is negative");
    if (length_ == 0) {
      begin_frame();
      return bad("a packet is empty");
    }
    discarding_ = length_ > kMaxPacket;
    return discarding_ ? bad(kTooLong) : Outcome::kNeedMore;
  }
  if (discarding_) {
    if (++discarded_ == length_)
      begin_frame();
    return Outcome::kNeedMore;
  }
  static_cast<void>(append_byte(byte)); // it fits: length_ is bounded
  return size_ == length_ ? decode_packet(message) : Outcome::kNeedMore;
}

FrameReader::Outcome FrameReader::take_text(std::uint8_t byte, Message& message) noexcept {
  const bool blank = byte == ' ' || byte == '\t' || byte == '\n' || byte == '\r';
  if (!in_frame_ && blank)
    return Outcome::kNeedMore;
  if (byte == ';' && !escaping_) {
    if (discarding_) {
      begin_frame();
      return Outcome::kNeedMore;
    }
    bool found = false;
    const std::string_view reason =
        decode_fudi({reinterpret_cast<char*>(packet_.data()), size_}, message, found);
    begin_frame();
    if (!reason.empty())
      return bad(reason);
    return found ? Outcome::kMessage : Outcome::kNeedMore;
  }
  in_frame_ = true;
  escaping_ = byte == '\\' && !escaping_;
  if (discarding_ || append_byte(byte))
    return Outcome::kNeedMore;
  discarding_ = true;
  return bad(kTooLong);
}

FrameReader::Outcome FrameReader::next(std::span<const std::uint8_t>& input,
                                       Message& message) noexcept {
  if (broken_)
    return Outcome::kBroken;
  if (take_element(message))
    return Outcome::kMessage;
  while (!input.empty()) {
    const std::uint8_t byte = input.front();
    input = input.subspan(1);
    if (!framing_) {
      framing_ = framing_of(byte);
      if (!framing_)
        return broken("unknown framing: expected the first byte to be 0xC0 (SLIP), 0x00 (a "
                      "length) or text");
      may_be_text_ = framing_ == Framing::kSlip && byte != kEnd;
    }
    // A line of text may also begin with a slash, but an OSC address ends with a zero.
    if (may_be_text_ && byte == ';')
      framing_ = Framing::kFudi;
    may_be_text_ = may_be_text_ && byte != 0 && byte != kEnd && byte != ';';
    Outcome outcome = Outcome::kNeedMore;
    switch (*framing_) {
    case Framing::kSlip:
      outcome = take_slip(byte, message);
      break;
    case Framing::kLength:
      outcome = take_length(byte, message);
      break;
    case Framing::kFudi:
      outcome = take_text(byte, message);
      break;
    }
    if (outcome != Outcome::kNeedMore)
      return outcome;
  }
  return Outcome::kNeedMore;
}

std::size_t encode_frame(Framing framing, const Message& message,
                         std::span<std::uint8_t> out) noexcept {
  if (framing == Framing::kFudi)
    return encode_fudi(message, {reinterpret_cast<char*>(out.data()), out.size()});
  std::array<std::uint8_t, kMaxSent> packet;
  const std::size_t size = encode_osc(message, packet);
  if (size == 0)
    return 0;
  std::size_t written = 0;
  const auto put = [&](std::uint8_t byte) {
    if (written < out.size())
      out[written] = byte;
    ++written;
  };
  if (framing == Framing::kLength)
    for (int shift = 24; shift >= 0; shift -= 8)
      put(static_cast<std::uint8_t>(size >> shift));
  else
    put(kEnd);
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t byte = packet[i];
    if (framing == Framing::kSlip && (byte == kEnd || byte == kEscape)) {
      put(kEscape);
      put(byte == kEnd ? kEscapedEnd : kEscapedEscape);
    } else {
      put(byte);
    }
  }
  if (framing == Framing::kSlip)
    put(kEnd);
  return written <= out.size() ? written : 0;
}

} // namespace tactus::net
