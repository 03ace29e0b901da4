#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/haptic/device/device.hpp"
#include "core/haptic/device/force_timeout.hpp"
#include "devices/haply/protocol.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace tactus::devices::haply {

class Socket;

/// The network address of Haply's service.
struct Address {
  std::string host = "127.0.0.1", port = "10001";
};

/// Host and port from the environment variable TACTUS_HAPLY, "host:port"; without it the service's
/// default.
[[nodiscard]] Address default_address();

struct Settings {
  Address address;
  std::string device; ///< an index or the service's device_id; empty for the first device
  double rate_hz = 1000;
};

/// The newest state of the device.
struct Sample {
  haptic::State state{}; ///< position of the handle in m; origin as centred() reports
  double time_s = -1e9;  ///< time of arrival, on ServoThread's clock
  bool calibrated = false;
};

/// Connection to Haply's service, in its own thread: one message and one answer per millisecond. It
/// exchanges states and forces with the servo's thread through two mailboxes; the servo touches no
/// socket and no JSON. If the service ends, the thread reconnects, at first after 50 ms, later
/// every 2 s.
class Connection {
public:
  ~Connection() { close(); }

  /// Waits for the first state of the requested device. Returns an empty text, or what to do.
  [[nodiscard]] std::string open(const Settings& settings);
  /// From any thread: soon ends an open() that waits.
  void cancel() noexcept { cancelled_ = true; }
  /// Sends zero force and ends the thread.
  void close() noexcept;

  /// For the servo's thread.
  [[nodiscard]] const Sample& newest() noexcept {
    samples_.read();
    return samples_.latest();
  }
  /// For the servo's thread: a force in N, project frame. A force that is not written again ends
  /// (force_timeout.hpp).
  void ask(const Vec3& force_n) noexcept { forces_.write(force_n); }

  /// For any thread that may wait.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] DeviceState device_state() const;
  /// True if the service put the origin of positions into the middle of the workspace, false if the
  /// origin is at the device's base.
  [[nodiscard]] bool centred() const noexcept { return is_centred_; }

private:
  enum class Phase { kSearching, kRunning, kRefused };

  void serve() noexcept;
  void run_connection();
  [[nodiscard]] std::string run_session(Socket& socket);
  [[nodiscard]] std::string set_up(Socket& socket);
  [[nodiscard]] std::string choose(const Message& inventory);
  [[nodiscard]] bool take(const Message& message);
  [[nodiscard]] Vec3 next_force() noexcept;
  void set_trouble(Phase phase, const std::string& trouble);

  Settings settings_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, leaving_{false}, cancelled_{false};
  Mailbox<Sample> samples_;
  haptic::TimedMailbox<Vec3> forces_;

  std::atomic<bool> is_centred_{false};

  // Used by the connection's thread.
  std::string device_id_;
  Sample sample_{};
  Transform workspace_{}, mount_{};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Phase phase_ = Phase::kSearching;
  std::string trouble_;
  DeviceState device_state_;
};

} // namespace tactus::devices::haply
