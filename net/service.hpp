#pragma once

#include "net/datagrams.hpp"
#include "net/out_queue.hpp"

#include <optional>
#include <string_view>

namespace tactus::net {

/// The interface between a TcpServer and the protocol that it serves. The service receives bytes
/// from numbered connections and queues bytes for them. It has no sockets, threads or clocks; times
/// are in s by one clock and never decrease.
class Service {
public:
  using ClientId = std::size_t; ///< 0 .. kMaxConnections - 1

  /// A new connection from that address. It may take over the number of another connection, which
  /// has then ended for the service (slot_for()). udp_port: the port for the datagrams of this
  /// client, 0 without datagrams.
  [[nodiscard]] virtual ClientId connect(std::string_view peer, double now_s, int udp_port) = 0;
  virtual void receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) = 0;
  /// Called when the connection has ended, by the peer or because closing() was true and the queue
  /// was empty.
  virtual void disconnect(ClientId client) = 0;

  /// Handles a datagram (bytes, from an address, at a time). If it is a client's probe, returns
  /// that client: the content of datagrams(client) is then sent to the endpoint from which the
  /// probe came.
  [[nodiscard]] virtual std::optional<ClientId>
  receive_datagram(std::string_view, std::span<const std::uint8_t>, double) {
    return {};
  }
  /// The queue of datagrams for a client; null if this service sends none.
  [[nodiscard]] virtual DatagramSender* datagrams(ClientId) noexcept { return nullptr; }

  /// Sends every client the reason and ends its connection.
  virtual void close(std::string_view reason) = 0;

  [[nodiscard]] virtual OutQueue& out(ClientId client) noexcept = 0;
  /// True if the connection must end once its queue is sent.
  [[nodiscard]] virtual bool closing(ClientId client) const noexcept = 0;
  /// True if clients must present a token of kMinToken bytes or more.
  [[nodiscard]] virtual bool guarded() const noexcept = 0;

protected:
  ~Service() = default;
};

} // namespace tactus::net
