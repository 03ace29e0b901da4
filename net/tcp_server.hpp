#pragma once

#include "net/limits.hpp"
#include "net/service.hpp"

#include <functional>
#include <memory>
#include <string>

namespace tactus::net {

/// The sockets of a Service: TCP on 127.0.0.1 and ::1, or on one other address, which a token must
/// guard. UDP on the same addresses is optional and carries positions to clients. Everything runs
/// in the thread that calls run() or poll(). Only the hook on_servo_command passes data, the
/// commands, on to the servo's thread.
class TcpServer {
public:
  struct Settings {
    int port = kPort;     ///< 0 for any free port
    std::string listen{}; ///< a numeric address; if empty, only loopback
    bool udp = false;     ///< clients may receive positions as datagrams
  };
  /// on_tick: called once a millisecond. on_servo_command: called after each piece of data from a
  /// client, since the data may have changed the command for the servo.
  struct Hooks {
    std::function<void(double now_s)> on_tick;
    std::function<void()> on_servo_command;
  };

  TcpServer(Service& service, Hooks hooks);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  /// Starts listening. Returns "" or one sentence with the problem and the remedy.
  [[nodiscard]] std::string open(const Settings& settings);
  [[nodiscard]] int port() const noexcept;
  /// The first UDP port; 0 without UDP. It equals port(), unless another program uses that port.
  [[nodiscard]] int udp_port() const noexcept;
  /// The addresses as a text, such as "127.0.0.1:7770 and [::1]:7770".
  [[nodiscard]] std::string addresses() const;

  /// Serves until stop(). Then it sends every client the reason, waits at most 200 ms until that is
  /// sent, and ends the force.
  void run();
  /// Ends run(); any thread and a signal handler may call it.
  void stop() noexcept;
  /// Instead of run(): does pending work without waiting.
  void poll();
  /// After the last poll(): sends every client the reason, without waiting. A client whose socket
  /// is full, because it does not read, does not receive the reason.
  void close();

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace tactus::net
