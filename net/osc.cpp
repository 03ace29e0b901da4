#include "net/osc.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace tactus::net {
namespace {

constexpr std::string_view kPrefix = "/hap/", kBusPrefix = "/bus/";
constexpr std::size_t kBundleHead = 16; ///< #bundle and the time tag
constexpr int kMaxDepth = 8;            ///< maximum depth of bundles within bundles

class OscReader {
public:
  explicit OscReader(std::span<const std::uint8_t> packet) noexcept : packet_(packet) {}

  [[nodiscard]] std::size_t left() const noexcept { return packet_.size() - at_; }
  void skip(std::size_t bytes) noexcept { at_ += bytes; }

  bool string(std::string_view& text) noexcept {
    const auto remaining = packet_.subspan(at_);
    const auto zero = std::find(remaining.begin(), remaining.end(), std::uint8_t{0});
    if (zero == remaining.end())
      return false;
    const auto length = static_cast<std::size_t>(zero - remaining.begin());
    const std::size_t padded = (length / 4 + 1) * 4;
    if (padded > remaining.size() ||
        std::any_of(zero, remaining.begin() + static_cast<std::ptrdiff_t>(padded),
                    [](std::uint8_t byte) { return byte != 0; }))
      return false;
    text = {reinterpret_cast<const char*>(remaining.data()), length};
    at_ += padded;
    return true;
  }

  bool word(std::uint32_t& value) noexcept {
    if (left() < 4)
      return false;
    value = 0;
    for (int i = 0; i < 4; ++i)
      value = value << 8 | packet_[at_++];
    return true;
  }

  bool long_word(std::uint64_t& value) noexcept {
    std::uint32_t high = 0, low = 0;
    if (!word(high) || !word(low))
      return false;
    value = std::uint64_t{high} << 32 | low;
    return true;
  }

private:
  std::span<const std::uint8_t> packet_;
  std::size_t at_ = 0;
};

class OscWriter {
public:
  explicit OscWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}

  void string(std::string_view head, std::string_view tail = {}) noexcept {
    bytes(head);
    bytes(tail);
    do
      byte(0);
    while (size_ % 4 != 0);
  }
  void argument(std::string_view text) noexcept { string(text.substr(0, text.find('\0'))); }
  template <class Number> void argument(Number value) noexcept {
    word(std::bit_cast<std::uint32_t>(value));
  }
  void word(std::uint32_t value) noexcept {
    for (int shift = 24; shift >= 0; shift -= 8)
      byte(static_cast<std::uint8_t>(value >> shift));
  }
  void bytes(std::string_view text) noexcept {
    for (const char c : text)
      byte(static_cast<std::uint8_t>(c));
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_ <= out_.size() ? size_ : 0; }

private:
  void byte(std::uint8_t value) noexcept {
    if (size_ < out_.size())
      out_[size_] = value;
    ++size_;
  }
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
};

bool is_bundle(std::span<const std::uint8_t> packet) noexcept {
  constexpr std::string_view kName("#bundle\0", 8);
  return packet.size() >= kName.size() && std::equal(kName.begin(), kName.end(), packet.begin());
}

/// Rounded to 32 bits.
std::string_view add_real(double value, Message& message) noexcept {
  if (!std::isfinite(static_cast<float>(value)))
    return std::isfinite(value) ? "a number is out of range" : "not a finite number";
  message.real(value);
  return {};
}

std::string_view decode_argument(char tag, OscReader& reader, Message& message) noexcept {
  constexpr std::string_view kMissing = "the packet ends inside its arguments";
  std::uint32_t word = 0;
  std::uint64_t long_word = 0;
  std::string_view text;
  switch (tag) {
  case 'i':
    if (!reader.word(word))
      return kMissing;
    message.integer(std::bit_cast<std::int32_t>(word));
    return {};
  case 'f':
    return reader.word(word) ? add_real(std::bit_cast<float>(word), message) : kMissing;
  case 'd':
    return reader.long_word(long_word) ? add_real(std::bit_cast<double>(long_word), message)
                                       : kMissing;
  case 'h': {
    if (!reader.long_word(long_word))
      return kMissing;
    const auto integer = std::bit_cast<std::int64_t>(long_word);
    if (integer != static_cast<std::int32_t>(integer))
      return add_real(static_cast<double>(integer), message);
    message.integer(static_cast<std::int32_t>(integer));
    return {};
  }
  case 'T':
  case 'F':
    message.integer(tag == 'T' ? 1 : 0);
    return {};
  case 's':
  case 'S':
    if (!reader.string(text))
      return "a string is not terminated";
    message.string(text);
    return {};
  default:
    return kOtherType;
  }
}

std::string_view check_packet(std::span<const std::uint8_t> packet, int depth) noexcept {
  Message message;
  if (!is_bundle(packet))
    return decode_osc(packet, message);
  if (depth == kMaxDepth)
    return "bundles are nested more than 8 deep";
  if (packet.size() < kBundleHead)
    return "a bundle ends inside its time tag";
  OscReader reader(packet.subspan(kBundleHead));
  while (reader.left() > 0) {
    std::uint32_t size = 0;
    if (!reader.word(size) || size > reader.left())
      return "a bundle ends inside a message";
    const auto element = packet.last(reader.left()).first(size);
    if (const std::string_view reason = check_packet(element, depth + 1); !reason.empty())
      return reason;
    reader.skip(size);
  }
  return {};
}

} // namespace

std::string_view check_osc(std::span<const std::uint8_t> packet) noexcept {
  return check_packet(packet, 0);
}

std::span<const std::uint8_t> next_message(std::span<const std::uint8_t>& rest) noexcept {
  while (!rest.empty()) {
    if (is_bundle(rest)) { // its elements follow, each after its size
      rest = rest.subspan(kBundleHead);
      continue;
    }
    std::uint32_t size = static_cast<std::uint32_t>(rest.size());
    if (rest.front() == 0) { // first byte of a size; a message begins with a slash
      static_cast<void>(OscReader(rest).word(size));
      rest = rest.subspan(4);
    }
    if (is_bundle(rest))
      continue;
    const auto message = rest.first(size);
    rest = rest.subspan(size);
    return message;
  }
  return {};
}

std::string_view decode_osc(std::span<const std::uint8_t> packet, Message& message) noexcept {
  message = Message{};
  OscReader reader(packet);
  std::string_view address, tags;
  if (!reader.string(address))
    return "the address is not terminated";
  if (address == "#bundle")
    return "bundles are not supported: send the messages one by one";
  if (!address.starts_with('/'))
    return "the address does not begin with a slash";
  if (!reader.string(tags) || !tags.starts_with(','))
    return "there are no type tags";
  tags.remove_prefix(1);
  if (tags.size() > Message::kMaxArguments)
    return "more than 16 arguments";
  if (address.starts_with(kBusPrefix) && address.size() > kBusPrefix.size()) {
    message = Message(Address::kTopic, address.substr(kBusPrefix.size()));
  } else {
    const bool is_own_prefix = address.starts_with(kPrefix);
    const std::string_view name = is_own_prefix ? address.substr(kPrefix.size()) : address;
    message = Message(is_own_prefix ? find_address(name) : Address::kUnknown, name);
  }
  for (const char tag : tags)
    if (const std::string_view reason = decode_argument(tag, reader, message); !reason.empty())
      return reason;
  return reader.left() == 0 ? std::string_view{} : "bytes are left after the arguments";
}

std::size_t encode_osc(const Message& message, std::span<std::uint8_t> out) noexcept {
  OscWriter writer(out);
  writer.string(message.address() == Address::kTopic ? kBusPrefix : kPrefix, message.name());
  std::array<char, Message::kMaxArguments + 1> tags{','};
  for (std::size_t i = 0; i < message.size(); ++i)
    tags[i + 1] = "ifs"[message[i].index()];
  writer.string({tags.data(), message.size() + 1});
  for (std::size_t i = 0; i < message.size(); ++i)
    std::visit([&](auto value) { writer.argument(value); }, message[i]);
  return writer.size();
}

} // namespace tactus::net
