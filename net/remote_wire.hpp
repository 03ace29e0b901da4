#pragma once

#include "net/client.hpp"
#include "net/remote_device.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace tactus::net {

/// One TCP connection of a client and its UDP socket, in whose thread everything happens.
struct RemoteDevice::Wire {
  explicit Wire(const std::atomic<bool>& stop_flag) : stop(stop_flag) {}

  /// Empty, else why not. Ends within the time, or soon after `stop`.
  [[nodiscard]] std::string connect(const std::string& host, int port, double timeout_s);
  /// Begins to hand what comes to the client.
  void receive(Client& client);
  void send(OutQueue& out);
  /// What has come by UDP, bounded; and the client's probes. Opens the socket when the server has
  /// given a port. A failure leaves the positions to TCP.
  void exchange_datagrams(Client& client);
  /// Runs what is due for a millisecond at most.
  void run();

  const std::atomic<bool>& stop;
  boost::asio::io_context context{1};
  boost::asio::ip::tcp::socket socket{context};
  boost::asio::ip::udp::socket datagrams{context};
  boost::asio::steady_timer timer{context};
  std::array<std::uint8_t, 1u << 14> received{};
  bool open = true, refused = false; ///< refused: the client wants no more of it
  std::string failure{};
};

} // namespace tactus::net
