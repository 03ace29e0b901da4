#include "net/remote_wire.hpp"

#include "core/haptic/device/force_timeout.hpp"
#include "net/client.hpp"
#include "net/clock.hpp"

#include <boost/asio/connect.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace tactus::net {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Error = boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Endpoints = std::vector<tcp::endpoint>;

namespace {

constexpr auto kWirePollInterval = std::chrono::milliseconds(20);
constexpr auto kWireTick = std::chrono::milliseconds(1);

Clock::time_point after(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Looks up a host's name. A look-up cannot be interrupted, so it runs in a thread that may outlive
/// the caller.
std::string look_up(const std::string& host, int port, Clock::time_point until,
                    const std::atomic<bool>& stop, Endpoints& endpoints) {
  struct Lookup {
    std::atomic<bool> done{false};
    Error error;
    Endpoints found;
  };
  const auto lookup = std::make_shared<Lookup>();
  try {
    std::thread([lookup, host, port] {
      asio::io_context context{1};
      tcp::resolver resolver{context};
      for (const auto& one : resolver.resolve(host, std::to_string(port), lookup->error))
        lookup->found.push_back(one.endpoint());
      lookup->done = true;
    }).detach();
  } catch (const std::system_error&) {
    return "cannot start a thread to look up " + host;
  }
  while (!lookup->done) {
    if (stop)
      return "stopped";
    if (Clock::now() > until)
      return "looking up the name " + host + " timed out";
    std::this_thread::sleep_for(kWireTick);
  }
  endpoints = lookup->found;
  return lookup->error ? lookup->error.message() : std::string();
}

} // namespace

std::string Wire::connect(const std::string& host, int port, double timeout_s) {
  const auto until = after(timeout_s);
  Endpoints endpoints;
  Error error;
  const auto numeric = asio::ip::make_address(host, error);
  if (!error)
    endpoints.emplace_back(numeric, static_cast<std::uint16_t>(port));
  else if (std::string reason = look_up(host, port, until, stop, endpoints); !reason.empty())
    return reason;
  std::optional<Error> outcome;
  asio::async_connect(socket, endpoints,
                      [&outcome](Error failed, const tcp::endpoint&) { outcome = failed; });
  while (!outcome && !stop && Clock::now() < until)
    context.run_one_until(std::min(until, Clock::now() + kWirePollInterval));
  if (!outcome) {
    socket.close(error);
    while (!outcome && context.run_one() > 0) {
    }
    return stop ? "stopped" : "timed out";
  }
  context.restart();
  if (*outcome)
    return outcome->message();
  socket.non_blocking(true, error);
  socket.set_option(tcp::no_delay(true), error);
  return {};
}

void Wire::receive(Receiver takes) {
  receiver = std::move(takes);
  read_on();
}

void Wire::read_on() {
  socket.async_read_some(asio::buffer(received), [this](Error error, std::size_t count) {
    if (error) {
      open = false;
      failure = error == asio::error::eof ? "the server closed the connection" : error.message();
      return;
    }
    if (!receiver({received.data(), count})) {
      refused = true;
      return;
    }
    read_on();
  });
}

/// Bytes that the socket does not accept now are sent in the next millisecond.
void Wire::send(OutQueue& out) {
  while (open && out.size() > 0) {
    Error error;
    const std::size_t sent =
        socket.write_some(asio::buffer(out.front().data(), out.front().size()), error);
    if (error == asio::error::would_block || error == asio::error::try_again)
      return;
    if (error) {
      open = false;
      failure = error.message();
      return;
    }
    out.consume(sent);
  }
}

void Wire::exchange_datagrams(Client& client) {
  const int port = client.datagrams().port();
  if (port == 0)
    return;
  Error error;
  if (!datagrams.is_open()) {
    // Connects the socket, so that the system discards datagrams from other addresses.
    const udp::endpoint server(socket.remote_endpoint(error).address(),
                               static_cast<std::uint16_t>(port));
    datagrams.open(server.protocol(), error);
    if (!error)
      datagrams.connect(server, error);
    if (!error)
      datagrams.non_blocking(true, error);
    if (error)
      return;
  }
  std::array<std::uint8_t, kMaxDatagram + 1> bytes;
  for (int i = 0; i < kMaxDatagramsPerTick; ++i) {
    const std::size_t size = datagrams.receive(asio::buffer(bytes), 0, error);
    if (error == asio::error::would_block || error == asio::error::try_again)
      break;
    if (!error)
      client.receive_datagram({bytes.data(), size}, now_s());
  }
  if (const auto probe = client.datagrams().probe(now_s()))
    datagrams.send(asio::buffer(probe->bytes.data(), probe->size), 0, error);
}

void Wire::run() {
  bool due = false;
  timer.expires_after(kWireTick);
  timer.async_wait([&due](Error) { due = true; });
  while (!due && context.run_one() > 0) {
  }
}

} // namespace tactus::net
