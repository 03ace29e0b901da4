#pragma once

#include "core/haptic/device/device.hpp"
#include "core/haptic/device/workspace.hpp"
#include "net/datagrams.hpp"
#include "net/framing.hpp"
#include "net/limits.hpp"
#include "net/out_queue.hpp"
#include "net/render_model.hpp"

#include <optional>
#include <string>
#include <vector>

namespace tactus::net {

/// A client's settings, in m and N, sent at the start of every connection.
struct ClientSetup {
  std::optional<haptic::Workspace> workspace{};
  std::vector<Vec3> points{};
  std::optional<stress::RenderGains> gains{};
  std::optional<Vec3> anchor{};
  std::optional<double> force_limit_n{};
};

/// The server's description of its device.
struct Welcome {
  std::string device, model;
  int axes = 3;
  double force_limit_n = 0, rate_hz = 1000;
  haptic::Workspace workspace{}; ///< m
  double stiffness_limit_n_per_m = 0, damping_limit_n_s_per_m = 0;
};

struct ClientSettings {
  std::string name = "tactus", token{};
  double position_hz = 1000;
  bool udp = false; ///< positions as datagrams, if the server supports them
};

/// The protocol's client; like Server, it has no sockets, threads or clocks. After each new
/// connection the motors stay off until start() is called again.
class Client {
public:
  static constexpr double kWelcome_s = 2; ///< longest wait for the welcome
  static constexpr double kSilence_s = 2; ///< the connection ends after this silence of the server

  explicit Client(ClientSettings settings = {}) : settings_(std::move(settings)) {}

  /// Begins a connection: queues hello and the setup.
  void connect(double now_s);
  void disconnect() noexcept;
  /// Handles received bytes. Returns false if the connection must end; trouble() then gives the
  /// reason.
  [[nodiscard]] bool receive(std::span<const std::uint8_t> bytes, double now_s);
  /// Reads a datagram from the server's address. Any datagram except a position with this client's
  /// key is counted and ignored.
  void receive_datagram(std::span<const std::uint8_t> bytes, double now_s);
  /// The client's side of the datagrams; its port() is the server's, 0 without datagrams.
  [[nodiscard]] DatagramReceiver& datagrams() noexcept { return datagrams_; }
  /// True if the server refused datagrams: positions then arrive over TCP.
  [[nodiscard]] bool udp_refused() const noexcept { return udp_refused_; }
  /// Call it about once a millisecond; sends pings. Returns false as receive() does.
  [[nodiscard]] bool advance(double now_s);

  void set(ClientSetup setup);
  void start(RenderMode mode);
  void stop();
  void send_force(const Vec3& force_n);
  void send_feedback(const Vec3& gamma);

  [[nodiscard]] OutQueue& out() noexcept { return out_; }
  /// True once the welcome and the first position have arrived.
  [[nodiscard]] bool ready() const noexcept { return ready_; }
  /// True if start() has been called and the server has not ended control.
  [[nodiscard]] bool in_control() const noexcept { return in_control_; }
  [[nodiscard]] const Welcome& welcome() const noexcept { return welcome_; }
  [[nodiscard]] const Vec3& position() const noexcept { return position_; } ///< m
  [[nodiscard]] double position_s() const noexcept {
    return position_s_;
  } ///< arrival time of the position
  /// The velocity that the server's servo has estimated, m/s. Differences of received positions
  /// would contain the network's jitter: two positions in one tick, none in the next.
  [[nodiscard]] const Vec3& velocity() const noexcept { return velocity_; }
  [[nodiscard]] std::uint32_t buttons() const noexcept { return buttons_; }
  /// Counts how often the server refused or ended this client's control.
  [[nodiscard]] std::uint32_t refusals() const noexcept { return refusals_; }
  /// The shortest measured round trip, s; nullopt before the first pong.
  [[nodiscard]] std::optional<double> round_trip_s() const noexcept { return round_trip_s_; }
  /// The last error, one sentence; empty if there is none.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }

private:
  void send(const Message& message);
  void send_setup();
  void take(const Message& message, double now_s);
  void take_welcome(const Message& message);
  void take_status(const Message& message);
  void take_error(const Message& message);
  void lose_control();

  ClientSettings settings_;
  ClientSetup setup_{};
  FrameReader reader_{};
  OutQueue out_{};
  Welcome welcome_{};
  bool welcomed_ = false, ready_ = false, in_control_ = false, ended_ = false;
  double last_message_s_ = 0, pinged_s_ = 0, connected_s_ = 0;
  std::optional<std::int32_t> server_ms_{}; ///< the server's time in its last message
  std::int32_t ping_ = 0, force_ = 0, feedback_ = 0;
  DatagramReceiver datagrams_{};
  bool udp_refused_ = false;
  std::optional<std::int32_t> position_sequence_{}, velocity_sequence_{};
  Vec3 position_{}, velocity_{};
  double position_s_ = -1e9;
  std::uint32_t buttons_ = 0, refusals_ = 0;
  std::optional<double> round_trip_s_{};
  std::string trouble_{};
};

} // namespace tactus::net
