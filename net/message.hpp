#pragma once

#include "net/address.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace tactus::net {

/// One argument of a message.
using Argument = std::variant<std::int32_t, float, std::string_view>;

/// A counter received as a float of a million or more may be rounded: Pd's text has six digits, so
/// the value may stand for several neighbouring integers.
[[nodiscard]] constexpr bool may_be_rounded(const Argument& count) noexcept {
  const float* const number = std::get_if<float>(&count);
  return number && (*number >= 1e6F || *number <= -1e6F);
}

/// One message of the protocol, whatever its framing. Strings are views into the bytes that it was
/// decoded from, or into data of its creator. Has a fixed capacity and allocates nothing.
class Message {
public:
  static constexpr std::size_t kMaxArguments = 16;

  Message() = default;
  explicit Message(Address address) noexcept : address_(address) {}

  /// own_name is the received name for kUnknown, needed for the answer, and the topic for kTopic.
  Message(Address address, std::string_view own_name) noexcept
      : address_(address), own_name_(own_name) {}

  [[nodiscard]] Address address() const noexcept { return address_; }
  /// A name such as "cp/begin", or the received unknown name, or the topic.
  [[nodiscard]] std::string_view name() const noexcept {
    return address_ == Address::kUnknown || address_ == Address::kTopic ? own_name_
                                                                        : name_of(address_);
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Argument& operator[](std::size_t i) const noexcept { return arguments_[i]; }

  /// Drops an argument that does not fit and then returns false.
  bool add(const Argument& argument) noexcept {
    if (size_ == kMaxArguments)
      return false;
    arguments_[size_++] = argument;
    return true;
  }
  Message& integer(std::int32_t value) noexcept {
    add(value);
    return *this;
  }
  /// Rounded to the wire's 32 bits.
  Message& real(double value) noexcept {
    add(static_cast<float>(value));
    return *this;
  }
  Message& string(std::string_view text) noexcept {
    add(text);
    return *this;
  }

  /// Reads an argument by its position. Pd sends every number as a float, so a float that is a
  /// whole number of 32 bits is also an integer, and an integer is also a number. Returns nullopt
  /// if there is no such argument or if it has another type.
  [[nodiscard]] std::optional<std::int32_t> integer_at(std::size_t i) const noexcept;
  [[nodiscard]] std::optional<double> number_at(std::size_t i) const noexcept;
  [[nodiscard]] std::optional<std::string_view> string_at(std::size_t i) const noexcept;

  friend bool operator==(const Message& a, const Message& b) noexcept;

private:
  Address address_ = Address::kUnknown;
  std::string_view own_name_{};
  std::array<Argument, kMaxArguments> arguments_{};
  std::size_t size_ = 0;
};

} // namespace tactus::net
