#include "net/osc.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace tactus::net {
namespace {

constexpr std::string_view kPrefix = "/hap/", kBusPrefix = "/bus/";

class OscReader {
public:
  explicit OscReader(std::span<const std::uint8_t> packet) noexcept : packet_(packet) {}

  [[nodiscard]] std::size_t left() const noexcept { return packet_.size() - at_; }

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

std::string_view decode_argument(char tag, OscReader& reader, Message& message) noexcept {
  constexpr std::string_view kMissing = "the packet ends inside its arguments";
  std::uint32_t word = 0;
  std::string_view text;
  switch (tag) {
  case 'i':
    if (!reader.word(word))
      return kMissing;
    message.integer(std::bit_cast<std::int32_t>(word));
    return {};
  case 'f': {
    if (!reader.word(word))
      return kMissing;
    const auto number = static_cast<double>(std::bit_cast<float>(word));
    if (!std::isfinite(number))
      return "a number is not finite";
    message.real(number);
    return {};
  }
  case 's':
    if (!reader.string(text))
      return "a string is not terminated";
    message.string(text);
    return {};
  default:
    return "unknown type tag: expected i, f or s";
  }
}

} // namespace

std::string_view decode_osc(std::span<const std::uint8_t> packet, Message& message) noexcept {
  message = Message{};
  OscReader reader(packet);
  std::string_view address, tags;
  if (!reader.string(address))
    return "the address is not terminated";
  if (address == "#bundle")
    return "bundles are not taken: send the messages one by one";
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
    tags[i + 1] = static_cast<char>(message[i].type);
  writer.string({tags.data(), message.size() + 1});
  for (std::size_t i = 0; i < message.size(); ++i) {
    const Argument& argument = message[i];
    switch (argument.type) {
    case Argument::Type::kInteger:
      writer.word(std::bit_cast<std::uint32_t>(static_cast<std::int32_t>(argument.number)));
      break;
    case Argument::Type::kFloat:
      writer.word(std::bit_cast<std::uint32_t>(static_cast<float>(argument.number)));
      break;
    case Argument::Type::kString:
      writer.string(argument.text.substr(0, argument.text.find('\0')));
      break;
    }
  }
  return writer.size();
}

} // namespace tactus::net
