#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace tactus::devices::haply {

/// A WebSocket client (RFC 6455) for text messages. Each call returns within its timeout, or soon
/// after `stop` becomes true. For one thread.
class Socket {
public:
  explicit Socket(const std::atomic<bool>& stop);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// Empty, else why not. ws://host:port/
  [[nodiscard]] std::string connect(const std::string& host, const std::string& port,
                                    double timeout_s);
  /// Empty, else why not. One text message, 64 kB at most.
  [[nodiscard]] std::string receive(std::string& message, double timeout_s);
  [[nodiscard]] std::string send(const std::string& message, double timeout_s);
  /// Takes leave, for a tenth of a second at most.
  void close() noexcept;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace tactus::devices::haply
