#include "devices/haply/socket.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>
#include <thread>

namespace tactus::devices::haply {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Error = beast::error_code;
using Clock = std::chrono::steady_clock;
using asio::ip::tcp;

namespace {

/// Looks up a host's name. A look-up cannot be interrupted, so it runs in a separate thread, which
/// keeps this object alive and may outlive the caller.
struct Lookup {
  std::atomic<bool> done{false};
  Error error;
  tcp::resolver::results_type addresses;
};

std::string look_up(const std::string& host, const std::string& port, double timeout_s,
                    const std::atomic<bool>& stop, tcp::resolver::results_type& addresses) {
  const auto lookup = std::make_shared<Lookup>();
  try {
    std::thread([lookup, host, port] {
      asio::io_context context{1};
      tcp::resolver resolver{context};
      lookup->addresses = resolver.resolve(host, port, lookup->error);
      lookup->done = true;
    }).detach();
  } catch (const std::system_error&) {
    return "cannot start a thread to look up " + host;
  }
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(timeout_s));
  while (!lookup->done) {
    if (stop)
      return "stopped";
    if (Clock::now() > deadline)
      return "looking up the name " + host + " timed out";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  addresses = lookup->addresses;
  return lookup->error ? lookup->error.message() : std::string();
}

} // namespace

struct Socket::Parts {
  explicit Parts(const std::atomic<bool>& stop_flag) : stop(stop_flag) {}

  /// Starts an operation and runs it until it completes, its time is over or `stop` is set.
  template <class Start> std::string finish(double timeout_s, Start start) {
    constexpr auto kPollInterval = std::chrono::milliseconds(20);
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(timeout_s));
    std::optional<Error> outcome;
    start([&outcome](Error error, auto&&...) { outcome = error; });
    context.restart();
    while (!outcome && !stop && Clock::now() < deadline)
      context.run_one_until(std::min(deadline, Clock::now() + kPollInterval));
    if (outcome)
      return *outcome ? outcome->message() : std::string();
    Error ignored;
    if (stream)
      beast::get_lowest_layer(*stream).close(ignored);
    context.restart();
    while (!outcome && context.run_one() > 0) {
    }
    return stop ? "stopped" : "timed out";
  }

  const std::atomic<bool>& stop;
  asio::io_context context{1};
  std::optional<beast::websocket::stream<tcp::socket>> stream;
  beast::flat_buffer buffer;
  tcp::resolver::results_type addresses;
};

Socket::Socket(const std::atomic<bool>& stop) : parts_(std::make_unique<Parts>(stop)) {}
Socket::~Socket() = default;

std::string Socket::connect(const std::string& host, const std::string& port, double timeout_s) {
  Parts& p = *parts_;
  p.stream.emplace(p.context);
  p.buffer.clear();
  std::string failure = look_up(host, port, timeout_s, p.stop, p.addresses);
  if (failure.empty())
    failure = p.finish(timeout_s, [&](auto done) {
      asio::async_connect(beast::get_lowest_layer(*p.stream), p.addresses, done);
    });
  if (!failure.empty())
    return failure;
  Error ignored;
  beast::get_lowest_layer(*p.stream).set_option(tcp::no_delay(true), ignored);
  p.stream->read_message_max(1u << 16);
  p.stream->text(true);
  return p.finish(timeout_s,
                  [&](auto done) { p.stream->async_handshake(host + ":" + port, "/", done); });
}

std::string Socket::receive(std::string& message, double timeout_s) {
  Parts& p = *parts_;
  p.buffer.clear();
  std::string failure =
      p.finish(timeout_s, [&](auto done) { p.stream->async_read(p.buffer, done); });
  if (failure.empty())
    message = beast::buffers_to_string(p.buffer.data());
  return failure;
}

std::string Socket::send(const std::string& message, double timeout_s) {
  Parts& p = *parts_;
  return p.finish(timeout_s,
                  [&](auto done) { p.stream->async_write(asio::buffer(message), done); });
}

void Socket::close() noexcept {
  Parts& p = *parts_;
  if (!p.stream)
    return;
  try {
    Error ignored;
    auto& wire = beast::get_lowest_layer(*p.stream);
    wire.shutdown(tcp::socket::shutdown_both, ignored);
    wire.close(ignored);
    p.stream.reset();
  } catch (...) { // no memory: the system closes the socket when the program ends
  }
}

} // namespace tactus::devices::haply
