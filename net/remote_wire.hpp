#pragma once

#include "net/out_queue.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>

#include <array>
#include <atomic>
#include <functional>
#include <string>

namespace tactus::net {

class Client;

/// The TCP connection and the UDP socket of a client; all functions are called in one thread.
struct Wire {
  /// Receives bytes; returning false ends the connection.
  using Receiver = std::function<bool(std::span<const std::uint8_t>)>;

  explicit Wire(const std::atomic<bool>& stop_flag) : stop(stop_flag) {}

  /// Returns an empty text, or the reason of the failure. Ends within the timeout, or soon after
  /// `stop` becomes true.
  [[nodiscard]] std::string connect(const std::string& host, int port, double timeout_s);
  /// Starts to pass received bytes to the receiver.
  void receive(Receiver receiver);
  void send(OutQueue& out);
  /// Reads a bounded number of received datagrams, and sends the client's probes. Opens the socket
  /// once the server has sent a port. After a failure, positions arrive over TCP.
  void exchange_datagrams(Client& client);
  /// Runs pending handlers for at most a millisecond.
  void run();

  void read_on();

  const std::atomic<bool>& stop;
  boost::asio::io_context context{1};
  boost::asio::ip::tcp::socket socket{context};
  boost::asio::ip::udp::socket datagrams{context};
  boost::asio::steady_timer timer{context};
  Receiver receiver{};
  std::array<std::uint8_t, 1u << 14> received{};
  bool open = true, refused = false; ///< refused: the receiver returned false
  std::string failure{};
};

} // namespace tactus::net
