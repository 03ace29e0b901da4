#include "net/tcp_server.hpp"

#include "core/haptic/device/force_timeout.hpp"
#include "net/clock.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/steady_timer.hpp>

#include <atomic>
#include <chrono>
#include <optional>

namespace tactus::net {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Error = boost::system::error_code;
using Clock = std::chrono::steady_clock;

namespace {

constexpr auto kTick = std::chrono::milliseconds(1);
constexpr auto kAcceptPause = std::chrono::milliseconds(100);
constexpr double kCloseFlush_s = 1; ///< time in which a closing connection sends its queue
constexpr auto kCloseTimeout = std::chrono::milliseconds(200);

/// One client's socket. Its handlers keep it alive; `open` is false once the connection has ended.
struct Connection {
  Connection(tcp::socket accepted, std::size_t from_acceptor)
      : socket(std::move(accepted)), acceptor_index(from_acceptor) {}
  tcp::socket socket;
  std::size_t acceptor_index; ///< index of its acceptor and datagram socket
  Service::ClientId client = 0;
  std::optional<udp::endpoint> datagrams_to{}; ///< source of its newest probe
  std::array<std::uint8_t, 1u << 14> received{};
  bool open = true, waiting_to_write = false;
  double closing_since_s = 0;
};
using ConnectionPtr = std::shared_ptr<Connection>;

std::string text_of(const tcp::endpoint& endpoint) {
  const std::string address = endpoint.address().to_string();
  return (endpoint.address().is_v6() ? "[" + address + "]" : address) + ":" +
         std::to_string(endpoint.port());
}

} // namespace

struct TcpServer::Parts {
  Parts(Service& served, Hooks given) : service(served), hooks(std::move(given)) {}

  Service& service;
  Hooks hooks;
  asio::io_context context{1};
  std::vector<tcp::acceptor> acceptors{};
  std::vector<udp::socket> datagram_sockets{}; ///< none, or one for each acceptor
  std::array<std::uint8_t, kMaxDatagram + 1> datagram{};
  std::array<ConnectionPtr, kMaxConnections> connections{};
  asio::steady_timer timer{context};
  std::atomic<bool> stopping{false};

  Error listen(const tcp::endpoint& endpoint) {
    tcp::acceptor acceptor(context);
    Error error;
    acceptor.open(endpoint.protocol(), error);
    if (!error && endpoint.address().is_v6())
      acceptor.set_option(asio::ip::v6_only(true), error);
    if (!error)
      acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
      acceptor.bind(endpoint, error);
    if (!error)
      acceptor.listen(16, error);
    if (!error)
      acceptor.non_blocking(true, error);
    if (!error)
      acceptors.push_back(std::move(acceptor));
    return error;
  }

  /// Uses the acceptor's port or, if another program has that port, any free one.
  std::string listen_for_datagrams(const tcp::endpoint& beside) {
    Error error;
    for (const std::uint16_t port : {beside.port(), std::uint16_t{0}}) {
      udp::socket socket(context);
      const udp::endpoint endpoint(beside.address(), port);
      socket.open(endpoint.protocol(), error);
      if (!error && beside.address().is_v6())
        socket.set_option(asio::ip::v6_only(true), error);
      if (!error)
        socket.bind(endpoint, error);
      if (!error)
        socket.non_blocking(true, error);
      if (error)
        continue;
      datagram_sockets.push_back(std::move(socket));
      return {};
    }
    return error.message();
  }

  [[nodiscard]] int datagram_port(std::size_t acceptor_index) const noexcept {
    Error error;
    return acceptor_index < datagram_sockets.size()
               ? datagram_sockets[acceptor_index].local_endpoint(error).port()
               : 0;
  }

  /// Receives a bounded number, so that a flood of datagrams delays nothing else.
  void receive_datagrams() {
    for (udp::socket& socket : datagram_sockets)
      for (int i = 0; i < kMaxDatagramsPerTick; ++i) {
        Error error;
        udp::endpoint from;
        const std::size_t size = socket.receive_from(asio::buffer(datagram), from, 0, error);
        if (error == asio::error::would_block || error == asio::error::try_again)
          break;
        if (error)
          continue; // for example, an earlier datagram was refused
        const auto client =
            service.receive_datagram(from.address().to_string(), {datagram.data(), size}, now_s());
        if (client && connections[*client])
          connections[*client]->datagrams_to = from;
      }
  }

  /// A datagram that the socket does not accept is lost, as any datagram may be.
  void send_datagrams(Connection& connection) {
    DatagramSender* const sender = service.datagrams(connection.client);
    while (const auto next = sender ? sender->take() : std::nullopt) {
      Error ignored;
      if (connection.datagrams_to)
        datagram_sockets[connection.acceptor_index].send_to(
            asio::buffer(next->bytes.data(), next->size), *connection.datagrams_to, 0, ignored);
    }
  }

  void accept(std::size_t which) {
    acceptors[which].async_accept([this, which](Error error, tcp::socket socket) {
      if (error == asio::error::operation_aborted)
        return;
      if (!error) {
        take(std::move(socket), which);
        return accept(which);
      }
      // For example, too many files are open. Retries after a pause, without spinning.
      const auto pause = std::make_shared<asio::steady_timer>(context, kAcceptPause);
      pause->async_wait([this, which, pause](Error aborted) {
        if (!aborted && which < acceptors.size())
          accept(which);
      });
    });
  }

  void take(tcp::socket socket, std::size_t acceptor_index) {
    Error error;
    const auto peer = socket.remote_endpoint(error);
    if (!error)
      socket.non_blocking(true, error);
    if (!error)
      socket.set_option(tcp::no_delay(true), error);
    if (error)
      return;
    const Service::ClientId client =
        service.connect(peer.address().to_string(), now_s(), datagram_port(acceptor_index));
    if (connections[client])
      close(*connections[client]);
    auto connection = std::make_shared<Connection>(std::move(socket), acceptor_index);
    connection->client = client;
    connections[client] = connection;
    receive(connection);
  }

  void receive(const ConnectionPtr& connection) {
    connection->socket.async_read_some(
        asio::buffer(connection->received), [this, connection](Error error, std::size_t count) {
          if (!connection->open)
            return;
          if (error)
            return drop(*connection);
          service.receive(connection->client, {connection->received.data(), count}, now_s());
          if (hooks.on_servo_command)
            hooks.on_servo_command();
          send_all();
          if (connection->open)
            receive(connection);
        });
  }

  /// Sends as much as the socket accepts now, and the rest when it accepts more.
  void send(const ConnectionPtr& connection) {
    if (connection->waiting_to_write)
      return;
    OutQueue& out = service.out(connection->client);
    while (out.size() > 0) {
      Error error;
      const std::span<const std::uint8_t> bytes = out.front();
      const std::size_t sent =
          connection->socket.write_some(asio::buffer(bytes.data(), bytes.size()), error);
      if (error == asio::error::would_block || error == asio::error::try_again) {
        connection->waiting_to_write = true;
        connection->socket.async_wait(tcp::socket::wait_write, [this, connection](Error failed) {
          connection->waiting_to_write = false;
          if (!connection->open)
            return;
          if (failed)
            return drop(*connection);
          send(connection);
        });
        return;
      }
      if (error)
        return drop(*connection);
      out.consume(sent);
    }
  }

  void send_all() {
    for (const ConnectionPtr& connection : std::array(connections))
      if (connection) {
        send(connection);
        end_if_done(*connection);
      }
  }

  /// Closes a connection that the service has ended, once its queue has been sent or after a
  /// second.
  void end_if_done(Connection& connection) {
    if (!connection.open || !service.closing(connection.client))
      return;
    const double now = now_s();
    if (connection.closing_since_s == 0)
      connection.closing_since_s = now;
    if (service.out(connection.client).size() == 0 ||
        now - connection.closing_since_s > kCloseFlush_s)
      drop(connection);
  }

  static void close(Connection& connection) {
    connection.open = false;
    Error ignored;
    connection.socket.shutdown(tcp::socket::shutdown_both, ignored);
    connection.socket.close(ignored);
  }

  void drop(Connection& connection) {
    if (!connection.open)
      return;
    close(connection);
    service.disconnect(connection.client);
    connections[connection.client].reset();
    if (hooks.on_servo_command)
      hooks.on_servo_command();
  }

  void tick() {
    receive_datagrams();
    if (hooks.on_tick)
      hooks.on_tick(now_s());
    for (const ConnectionPtr& connection : connections)
      if (connection)
        send_datagrams(*connection);
    send_all();
  }

  void schedule_tick() {
    timer.async_wait([this](Error aborted) {
      if (aborted || stopping)
        return context.stop();
      tick();
      timer.expires_at(std::max(timer.expiry() + kTick, Clock::now()));
      schedule_tick();
    });
  }

  /// Sends every client the reason and waits up to `patience` for sockets that are full.
  void send_bye(Clock::duration patience) {
    acceptors.clear();
    service.close("closing");
    tick();
    context.restart();
    const auto until = Clock::now() + patience;
    const auto busy = [this] {
      return std::any_of(connections.begin(), connections.end(),
                         [](const ConnectionPtr& one) { return one != nullptr; });
    };
    while (busy() && Clock::now() < until) {
      context.run_one_for(kTick);
      send_all();
    }
    for (const ConnectionPtr& connection : std::array(connections))
      if (connection)
        drop(*connection);
  }
};

TcpServer::TcpServer(Service& service, Hooks hooks)
    : parts_(std::make_unique<Parts>(service, std::move(hooks))) {}
TcpServer::~TcpServer() = default;

std::string TcpServer::open(const Settings& settings) {
  Parts& p = *parts_;
  auto port = static_cast<std::uint16_t>(settings.port);
  const auto refused = [&](const std::string& address, const Error& error) {
    return "cannot listen on " + address + " port " + std::to_string(settings.port) + " (" +
           error.message() + "): " +
           (error == boost::system::errc::address_not_available
                ? "expected an address of this computer, or 0.0.0.0 for all of them"
            : error == boost::system::errc::permission_denied
                ? "expected a port of 1024 or above"
                : "choose another port, or close the program that uses it");
  };
  p.acceptors.clear();
  p.datagram_sockets.clear();
  if (!settings.listen.empty()) {
    Error error;
    const auto address = asio::ip::make_address(settings.listen, error);
    if (error)
      return settings.listen + ": expected a numeric address, such as 192.168.1.5";
    if (!address.is_loopback() && !p.service.guarded())
      return "listening on " + settings.listen + " needs a token file of 16 bytes or more";
    if (const Error failed = p.listen({address, port}))
      return refused(settings.listen, failed);
  } else {
    if (const Error failed = p.listen({asio::ip::address_v4::loopback(), port}))
      return refused("127.0.0.1", failed);
    port = p.acceptors.front().local_endpoint().port();
    // A machine without IPv6 has no ::1, which is not an error.
    static_cast<void>(p.listen({asio::ip::address_v6::loopback(), port}));
  }
  if (settings.udp)
    for (const tcp::acceptor& acceptor : p.acceptors) {
      Error error;
      const tcp::endpoint beside = acceptor.local_endpoint(error);
      if (const std::string reason = p.listen_for_datagrams(beside); !reason.empty())
        return "cannot open a UDP socket on " + beside.address().to_string() + " (" + reason +
               "): start it without udp";
    }
  for (std::size_t i = 0; i < p.acceptors.size(); ++i)
    p.accept(i);
  return {};
}

int TcpServer::port() const noexcept {
  Error error;
  return parts_->acceptors.empty() ? 0 : parts_->acceptors.front().local_endpoint(error).port();
}

int TcpServer::udp_port() const noexcept { return parts_->datagram_port(0); }

std::string TcpServer::addresses() const {
  std::string text;
  for (const tcp::acceptor& acceptor : parts_->acceptors) {
    Error error;
    text += (text.empty() ? "" : " and ") + text_of(acceptor.local_endpoint(error));
  }
  return text;
}

void TcpServer::run() {
  Parts& p = *parts_;
  p.timer.expires_after(kTick);
  p.schedule_tick();
  p.context.run();
  p.send_bye(kCloseTimeout);
}

void TcpServer::stop() noexcept { parts_->stopping = true; }

void TcpServer::poll() {
  constexpr int kMaxHandlers = 256; // bounded, so that a flood does not delay the patch
  parts_->context.restart();
  for (int i = 0; i < kMaxHandlers && parts_->context.poll_one() > 0; ++i) {
  }
  parts_->tick();
}

void TcpServer::close() { parts_->send_bye({}); }

} // namespace tactus::net
