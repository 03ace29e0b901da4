#include "net/address.hpp"

#include <array>

namespace tactus::net {
namespace {

constexpr std::array<std::string_view, 27> kNames{
    "?",         "hello",    "workspace", "cp/begin", "cp/set",   "cp/end", "cp/clear",
    "gains",     "forcemax", "start",     "stop",     "feedback", "force",  "anchor",
    "subscribe", "ping",     "udp",       "welcome",  "pos",      "vel",    "button",
    "cp/move",   "grab",     "pong",      "status",   "error",    "bye"};
static_assert(kNames.size() == static_cast<std::size_t>(Address::kBye) + 1);

} // namespace

std::string_view name_of(Address address) noexcept {
  return address == Address::kTopic ? kNames[0] : kNames[static_cast<std::size_t>(address)];
}

Address find_address(std::string_view name) noexcept {
  for (std::size_t i = 1; i < kNames.size(); ++i)
    if (kNames[i] == name)
      return static_cast<Address>(i);
  return Address::kUnknown;
}

Address find_address(std::string_view first, std::string_view second) noexcept {
  for (std::size_t i = 1; i < kNames.size(); ++i) {
    const std::string_view name = kNames[i];
    if (name.size() == first.size() + 1 + second.size() && name.starts_with(first) &&
        name[first.size()] == '/' && name.ends_with(second))
      return static_cast<Address>(i);
  }
  return Address::kUnknown;
}

} // namespace tactus::net
