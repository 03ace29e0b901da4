#pragma once

#include "net/bus_node.hpp"

#include <functional>

namespace tactus::net {

/// A bus of modules mirrored over TCP, for a patch. The patch's thread sends and receives messages
/// without waiting; a separate thread serves the sockets. Times of the patch are its logical time,
/// s.
class BusLink {
public:
  struct Delivered {
    const Message& topic; ///< the topic's fields; a time field counts from sent_s
    double sent_s;        ///< time of sending, converted to this patch's logical time
    bool late;            ///< more than kTolerance_s after its playout time
  };
  using Receiver = std::function<void(const Delivered&)>;
  /// Longest interval between calls of poll().
  static constexpr double kPoll_s = 1e-3, kTolerance_s = 1.5e-3;

  BusLink() = default;
  ~BusLink() { disconnect(); }
  BusLink(const BusLink&) = delete;
  BusLink& operator=(const BusLink&) = delete;

  /// Waits for callers on a port of 127.0.0.1 and ::1, or of one numeric address, which needs a
  /// token. Errors are reported as notices.
  void listen(int port, const std::string& address);
  /// Connects to that host, and reconnects until disconnect() is called.
  void connect(const std::string& host, int port);
  /// Ends all connections. Returns at once: the peers are informed in the background.
  void disconnect() noexcept;
  [[nodiscard]] bool open() const noexcept { return worker_ != nullptr; }

  /// Applies to connections from the next listen() or connect() on.
  void set_token(std::string token) { token_ = std::move(token); }
  /// Sets the playout delay in s, up to PlayoutDelay::kMax_s; nullopt: automatic.
  void set_playout(std::optional<double> delay_s) noexcept;

  /// Sends a topic to all peers; now_s: logical time of the patch. False if the topic is longer
  /// than a packet allows.
  [[nodiscard]] bool send(const Message& topic, double now_s) noexcept;
  /// Delivers the messages that are due. Returns the logical time of the next call.
  double poll(double now_s, const Receiver& receiver);
  /// Returns the notices since the last call.
  [[nodiscard]] std::vector<BusExchange::Notice> take_notices();

  [[nodiscard]] int peers() const noexcept;
  /// The longest playout delay and the longest transit time among the peers, s.
  [[nodiscard]] double delay_s() const noexcept;
  [[nodiscard]] double transit_s() const noexcept;

private:
  class Worker;

  void start(std::shared_ptr<Worker> worker);
  [[nodiscard]] BusSettings settings() const;
  void observe(double logical_s) noexcept;
  [[nodiscard]] double max_s(std::atomic<double> BusExchange::Incoming::*time) const noexcept;

  std::string token_{};
  double playout_s_ = -1;
  std::shared_ptr<Worker> worker_{};
  /// Clock of the sockets minus logical time. Logical time is never early, so the smallest
  /// difference is the true one, even if the patch's thread is held up.
  MinimumFilter ahead_{};
  SlewedOffset clock_{kClockWarmUp_s};
  static constexpr double kClockWarmUp_s = 2;
};

} // namespace tactus::net
