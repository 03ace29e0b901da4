#include "net/message.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::net {

std::optional<std::int32_t> Message::integer_at(std::size_t i) const noexcept {
  const std::optional<double> number = number_at(i);
  constexpr double kMin = std::numeric_limits<std::int32_t>::min();
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  if (!number || !(*number >= kMin && *number <= kMax) || *number != std::floor(*number))
    return {};
  return static_cast<std::int32_t>(*number);
}

std::optional<double> Message::number_at(std::size_t i) const noexcept {
  if (i >= size_)
    return {};
  if (const auto* const integer = std::get_if<std::int32_t>(&arguments_[i]))
    return *integer;
  if (const auto* const real = std::get_if<float>(&arguments_[i]))
    return *real;
  return {};
}

std::optional<std::string_view> Message::string_at(std::size_t i) const noexcept {
  const auto* const text = i < size_ ? std::get_if<std::string_view>(&arguments_[i]) : nullptr;
  return text ? std::optional(*text) : std::nullopt;
}

bool operator==(const Message& a, const Message& b) noexcept {
  return a.address_ == b.address_ && a.name() == b.name() && a.size_ == b.size_ &&
         std::equal(a.arguments_.begin(),
                    a.arguments_.begin() + static_cast<std::ptrdiff_t>(a.size_),
                    b.arguments_.begin());
}

} // namespace tactus::net
