#pragma once

#include "core/haptic/device/force_timeout.hpp"
#include "net/client.hpp"

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>

namespace tactus::net {

struct Wire;

/// A haptic device on another computer, as a haptic::Backend: a client of the haptic protocol. The
/// sockets have their own thread, which exchanges data with the servo through two mailboxes.
/// Positions older than 100 ms switch the force off until new ones arrive. A lost connection, 500
/// ms without a position or a server that stops the motors counts as a failure of the device, so
/// the motors stay off until the user switches them on. A lost connection is re-established
/// automatically.
class RemoteDevice final : public haptic::Backend {
public:
  RemoteDevice();
  ~RemoteDevice() override;

  [[nodiscard]] std::string open() override;
  void cancel() noexcept override { cancelled_ = true; }
  void close() noexcept override;
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  /// "HOST PORT", "device HOST" or "device HOST:PORT", "host HOST PORT", "token FILE", "rate HZ",
  /// "udp 0" or "udp 1"; "udp 0|1" may also follow HOST PORT.
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

private:
  /// The newest state of the device.
  struct Sample {
    haptic::State state{};
    double time_s = -1e9; ///< arrival time
    bool connected = false;
    bool failed = false; ///< the server has ended this client's control
    std::uint32_t failures = 0;
  };
  struct Settings {
    std::string host = "127.0.0.1";
    int port = kPort;
    std::string token{};
    double rate_hz = 1000;
    bool udp = false; ///< positions arrive as datagrams
  };

  [[nodiscard]] std::string configure_locked(std::span<const std::string> words);
  void serve() noexcept;
  void run_connection();
  /// Runs until the connection is lost. Returns the reason.
  [[nodiscard]] std::string run_session(Wire& wire);
  void exchange(Client& client, double now_s);
  void set_trouble(const std::string& trouble);
  void update_caps(const Welcome& welcome, double round_trip_s, double rate_hz) noexcept;

  Mailbox<Sample> samples_;
  haptic::TimedMailbox<Vec3> forces_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, cancelled_{false};

  // Used by the connection's thread.
  unsigned name_ = std::random_device{}() % 100000; ///< distinguishes clients
  Sample sample_{};
  double down_until_s_ = 0, failed_until_s_ = 0, sent_s_ = 0;
  Vec3 sent_force_{};
  bool may_start_ = false; ///< zero force has been written since the connection or a refusal
  std::uint32_t refusals_ = 0, failures_ = 0;
  std::string notice_{}; ///< information to show while there is no failure
  /// Number of failures that the servo has read: a late servo must not miss one.
  std::atomic<std::uint32_t> failures_seen_{0};

  // Used by the servo's thread.
  Vec3 last_position_{};
  haptic::Caps caps_{};
  haptic::Identity identity_{};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Settings settings_{}, active_settings_{};
  std::string trouble_{};
  std::optional<Welcome> welcome_{};
  double round_trip_s_ = 0;
};

} // namespace tactus::net
