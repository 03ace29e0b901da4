#include "net/admission.hpp"

#include <array>
#include <utility>

namespace tactus::net {

std::string_view refusal_text(std::string_view code) noexcept {
  using Row = std::pair<std::string_view, std::string_view>;
  constexpr std::array kRows{Row{"token", "the token is wrong"},
                             Row{"locked", "too many wrong tokens: wait ten seconds"},
                             Row{"version", "expected protocol version 1"},
                             Row{"full", "eight clients are already connected"}};
  for (const auto& [known, text] : kRows)
    if (known == code)
      return text;
  return {};
}

std::string_view refusal_text_of_peer(std::string_view code) noexcept {
  const std::string_view text = refusal_text(code);
  return text.empty() ? "the connection was refused" : text;
}

std::string_view Admission::admit(std::string_view peer, std::string_view token, int protocol,
                                  double now_s) {
  if (lock_out_.locked(peer, now_s))
    return "locked";
  if (needs_token()) {
    if (!equal_in_constant_time(token_, token)) {
      lock_out_.fail(peer, now_s);
      return "token";
    }
    lock_out_.succeed(peer);
  }
  if (protocol < kProtocol)
    return "version";
  if (clients_ >= kMaxClients)
    return "full";
  ++clients_;
  return {};
}

} // namespace tactus::net
