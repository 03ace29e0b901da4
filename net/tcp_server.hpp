#pragma once

#include "net/limits.hpp"
#include "net/service.hpp"

#include <functional>
#include <memory>
#include <string>

namespace tactus::net {

/// The sockets of a server: TCP on 127.0.0.1 and ::1, or on one other address, which a token must
/// guard; and, where asked for, UDP on the same addresses, which carries positions to clients.
/// Everything happens in the thread that calls run() or poll(); the servo's thread is met in the
/// orders alone.
class TcpServer {
public:
  struct Settings {
    int port = kPort;     ///< 0: any that is free
    std::string listen{}; ///< a numeric address; empty: loopback alone
    bool udp = false;     ///< clients may have positions as datagrams
  };
  /// on_tick: once a millisecond. on_servo_command: after each piece that was received.
  struct Hooks {
    std::function<void(double now_s)> on_tick;
    std::function<void()> on_servo_command;
  };

  TcpServer(Service& service, Hooks hooks);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  /// Empty when it listens, else one sentence that says what to do.
  [[nodiscard]] std::string open(const Settings& settings);
  [[nodiscard]] int port() const noexcept;
  /// The first UDP port; 0 without. The same as port(), unless another program has that.
  [[nodiscard]] int udp_port() const noexcept;
  /// Such as "127.0.0.1:7770 and [::1]:7770".
  [[nodiscard]] std::string addresses() const;

  /// Serves until stop(), which any thread and the handler of a signal may call; then every client
  /// is told, for which it waits 200 ms at most, and the force ends.
  void run();
  void stop() noexcept;
  /// Instead of run(): what is due now, without waiting.
  void poll();
  /// After the last poll(), without waiting: every client is told, but for those whose sockets are
  /// full, since they do not read.
  void close();

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace tactus::net
