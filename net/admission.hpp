#pragma once

#include "net/limits.hpp"
#include "net/token.hpp"

#include <string>

/// Access control of both protocols: checks a connection before its hello is answered, and reports
/// connections that were not admitted.
namespace tactus::net {

/// The local sentence for a code of refusal; empty for any other code.
[[nodiscard]] std::string_view refusal_text(std::string_view code) noexcept;

/// The text to show for an `error` or `bye` from a peer that has not been admitted. It is the local
/// sentence for the protocol's code, never the peer's own text.
[[nodiscard]] std::string_view refusal_text_of_peer(std::string_view code) noexcept;

/// Admits the clients of one server or link by their token, up to a maximum number.
class Admission {
public:
  explicit Admission(std::string token = {}) : token_(std::move(token)) {}

  /// Admits a client and returns "", or returns the code of the refusal.
  [[nodiscard]] std::string_view admit(std::string_view peer, std::string_view token, int protocol,
                                       double now_s);
  void leave() noexcept { --clients_; }
  [[nodiscard]] bool guarded() const noexcept { return token_.size() >= kMinToken; }
  [[nodiscard]] bool needs_token() const noexcept { return !token_.empty(); }

private:
  std::string token_;
  LockOut lock_out_{};
  std::size_t clients_ = 0;
};

/// The index for a new connection in `sessions`, which holds pointers to PeerConnections: a free
/// index, or that of a pending connection, which the new connection replaces. The function finds
/// the address with the most pending connections, counting the new one, and replaces the oldest of
/// them. So no address can keep others out, and silent connections cannot keep out a connection
/// that sends hello.
template <class Sessions>
[[nodiscard]] std::size_t slot_for(const Sessions& sessions, std::string_view peer) {
  static_assert(std::tuple_size_v<Sessions> == kMaxConnections);
  const auto pending_of = [&](std::string_view address) {
    std::size_t count = address == peer ? 1 : 0;
    for (const auto& session : sessions)
      count += session && !session->admitted && session->peer == address ? 1 : 0;
    return count;
  };
  std::size_t pending = 0, free = kMaxConnections, oldest = kMaxConnections, most = 0;
  for (std::size_t i = 0; i < kMaxConnections; ++i) {
    if (!sessions[i]) {
      free = std::min(free, i);
      continue;
    }
    if (sessions[i]->admitted)
      continue;
    ++pending;
    const std::size_t crowd = pending_of(sessions[i]->peer);
    if (crowd > most ||
        (crowd == most && sessions[i]->connected_s < sessions[oldest]->connected_s)) {
      oldest = i;
      most = crowd;
    }
  }
  return pending < kMaxPending ? free : oldest;
}

} // namespace tactus::net
