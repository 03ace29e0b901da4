#pragma once

#include "net/limits.hpp"
#include "net/service.hpp"

#include <functional>
#include <memory>
#include <string>

namespace tactus::net {

/// The sockets of a Service: TCP on 127.0.0.1 and ::1, or on one other address, which a token must
/// guard; optionally UDP on the same addresses, which carries positions to clients. All of it runs
/// in the thread that calls run() or poll(). The hook on_servo_command passes commands on to the
/// servo's thread, which is not entered otherwise.
class TcpServer {
public:
  struct Settings {
    int port = kPort;     ///< 0: any free port
    std::string listen{}; ///< a numeric address; empty: loopback alone
    bool udp = false;     ///< clients may have positions as datagrams
  };
  /// on_tick: called once a millisecond. on_servo_command: called after each piece of data from a
  /// client, since it may have changed the command for the servo.
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
  /// The first UDP port; 0 without UDP. The same as port(), unless another program uses that.
  [[nodiscard]] int udp_port() const noexcept;
  /// Such as "127.0.0.1:7770 and [::1]:7770".
  [[nodiscard]] std::string addresses() const;

  /// Serves until stop(). Then it sends every client the reason, waits 200 ms at most for that, and
  /// ends the force.
  void run();
  /// Ends run(); any thread and a signal handler may call it.
  void stop() noexcept;
  /// Instead of run(): does pending work without waiting.
  void poll();
  /// After the last poll(): sends every client the reason, without waiting. Clients that do not
  /// read, so that their sockets are full, do not get it.
  void close();

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace tactus::net
