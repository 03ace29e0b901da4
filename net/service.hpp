#pragma once

#include "net/datagrams.hpp"
#include "net/out_queue.hpp"

#include <optional>
#include <string_view>

namespace tactus::net {

/// What a TcpServer serves: connections by number, bytes in and bytes out. No sockets, threads or
/// clocks of its own; times in s by one clock, never decreasing.
class Service {
public:
  using ClientId = std::size_t; ///< 0 .. kMaxClients - 1

  /// A connection from that address; nothing when there are as many as there may be. udp_port:
  /// where this client can send datagrams, 0 when there are none.
  [[nodiscard]] virtual std::optional<ClientId> connect(std::string_view peer, double now_s,
                                                        int udp_port) = 0;
  virtual void receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) = 0;
  /// The connection is gone, or was closed after closing() and an empty queue.
  virtual void disconnect(ClientId client) = 0;

  /// A datagram from that address. The client whose probe it is, if it is one: what
  /// datagrams(client) holds goes to where it came from.
  [[nodiscard]] virtual std::optional<ClientId>
  receive_datagram(std::string_view, std::span<const std::uint8_t>, double) {
    return {};
  }
  /// What waits to be sent to a client by UDP; null: this service sends no datagrams.
  [[nodiscard]] virtual DatagramSender* datagrams(ClientId) noexcept { return nullptr; }

  /// Every client is told and its connection ends.
  virtual void close(std::string_view reason) = 0;

  [[nodiscard]] virtual OutQueue& out(ClientId client) noexcept = 0;
  /// What waits is sent, then the connection ends.
  [[nodiscard]] virtual bool closing(ClientId client) const noexcept = 0;
  /// Clients must bring a token of kMinToken bytes or more.
  [[nodiscard]] virtual bool guarded() const noexcept = 0;

protected:
  ~Service() = default;
};

} // namespace tactus::net
