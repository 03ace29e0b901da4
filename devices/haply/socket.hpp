#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace tactus::devices::haply {

/// A WebSocket client (RFC 6455) for text messages. Each call returns within its timeout, or soon
/// after `stop` becomes true. For use by one thread.
class Socket {
public:
  explicit Socket(const std::atomic<bool>& stop);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// Connects to ws://host:port/. Returns an empty text, or the reason of a failure.
  [[nodiscard]] std::string connect(const std::string& host, const std::string& port,
                                    double timeout_s);
  /// Receives one text message of at most 64 kB. Returns an empty text, or the reason of a failure.
  [[nodiscard]] std::string receive(std::string& message, double timeout_s);
  [[nodiscard]] std::string send(const std::string& message, double timeout_s);
  /// Sends a close frame; takes at most a tenth of a second.
  void close() noexcept;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace tactus::devices::haply
