#pragma once

#include "core/haptic/device/device.hpp"
#include "net/admission.hpp"
#include "net/render_model.hpp"
#include "net/service.hpp"
#include "net/session.hpp"

#include <array>
#include <memory>
#include <optional>
#include <utility>

namespace tactus::net {

/// The server's description of its device, and limits that no client can raise.
struct ServerSettings {
  std::string device = "simulated", model = "-";
  int axes = 3;
  double rate_hz = 1000;
  double force_limit_n = 1;
  double stiffness_limit_n_per_m = 500, damping_limit_n_s_per_m = 5;
  haptic::Workspace workspace{}; ///< workspace of the device, m
  std::string token{};           ///< required in hello; empty: no token
  double grab_radius_m = 0.01;
};

/// The device's state as last reported by the servo.
struct DeviceReport {
  haptic::State state{};
  bool emergency_stopped = false; ///< somebody at the device has pressed the emergency stop
  std::uint32_t faults = 0;       ///< counts reported faults and losses of the device
  bool clipping = false;          ///< the force limit removes a noticeable part of the force
  double asked_n = 0;             ///< the force before its limit
};

/// A message that clipping of the force has begun or ended.
struct Clipping {
  bool on = false;
  double asked_n = 0, limit_n = 0;
};

/// The command for the servo.
struct ServoCommand {
  bool running = false; ///< true if a client has sent start; if false, the motors are off
  RenderRequest render{};
  Vec3 force_n{};           ///< the force in force mode
  std::uint64_t forces = 0; ///< counts the received forces
  double alive_s = -1e9;    ///< time at which the controlling client last counted as alive
  double force_limit_n = 0; ///< the server's limit, or a lower one set by the client
};

/// The protocol's server without sockets, threads and clocks: it receives bytes and times, and
/// produces bytes and commands for the servo (docs/haptic_network.md). One client is in control. A
/// client's force never outlasts the client: stop, a lost connection or 500 ms of silence ends the
/// force. For use by one thread. Times are in s by the clock of the servo's heartbeat and never
/// decrease.
class Server final : public Service {
public:
  explicit Server(ServerSettings settings)
      : settings_(std::move(settings)), admission_(settings_.token) {}

  /// udp_port: the port to which this client can send datagrams, 0 without datagrams.
  [[nodiscard]] ClientId connect(std::string_view peer, double now_s, int udp_port = 0) override;
  void receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) override;
  /// Any datagram except a client's probe is counted and ignored. No datagram is a sign of life.
  [[nodiscard]] std::optional<ClientId> receive_datagram(std::string_view peer,
                                                         std::span<const std::uint8_t> bytes,
                                                         double now_s) override;
  void disconnect(ClientId client) override;

  /// Call once per servo period: handles timeouts and sends streams.
  void advance(const DeviceReport& report, double now_s);
  /// Reports a button of the device.
  void set_button(int number, bool on);
  void close(std::string_view reason) override;

  [[nodiscard]] bool connected(ClientId client) const noexcept {
    return sessions_[client] != nullptr;
  }
  [[nodiscard]] OutQueue& out(ClientId client) noexcept override { return sessions_[client]->out; }
  [[nodiscard]] bool closing(ClientId client) const noexcept override {
    return sessions_[client]->closing;
  }
  [[nodiscard]] bool guarded() const noexcept override { return admission_.guarded(); }

  /// The datagrams that are queued for a client.
  [[nodiscard]] DatagramSender* datagrams(ClientId client) noexcept override {
    return &sessions_[client]->datagrams;
  }
  [[nodiscard]] std::uint64_t ignored_datagrams() const noexcept { return ignored_datagrams_; }

  [[nodiscard]] const ServoCommand& servo_command() const noexcept { return servo_command_; }
  [[nodiscard]] const ServerSettings& settings() const noexcept { return settings_; }
  /// Number of clients that have sent hello.
  [[nodiscard]] std::size_t clients() const noexcept;
  /// Number of connections so far.
  [[nodiscard]] std::uint64_t connections_made() const noexcept { return connections_made_; }
  /// Events since the last call for the log of the server, one line each. If it is not called for
  /// long, the oldest events are dropped.
  [[nodiscard]] std::vector<std::string> take_notices() { return std::exchange(notices_, {}); }
  /// The newest change of clipping since the last call; the server has sent it to every client.
  [[nodiscard]] std::optional<Clipping> take_clipping() noexcept {
    return std::exchange(clipping_, std::nullopt);
  }
  /// Name of the client in control; empty if there is none.
  [[nodiscard]] std::string_view controller_name() const noexcept {
    return controller_ ? std::string_view(controller_->name) : std::string_view{};
  }

private:
  using Words = const Message&;
  /// The error in a message: a code and a sentence; both empty if the message was accepted.
  struct Refusal {
    std::string_view code{}, text{};
    bool bad = false; ///< counts as a bad packet and not as a sign of life
  };

  // Defined in server.cpp: connections and time
  void take(Session& session, FrameReader::Outcome outcome, const Message& message, double now_s);
  void send_clipping(const Clipping& clipping);
  [[nodiscard]] static bool is_recent(const Session& session, double now_s) noexcept;
  void release_control(std::string_view why);
  void broadcast(const Message& message);
  void log_event(const Session& session, std::string_view what);
  void add_notice(std::string line);

  // Defined in server_messages.cpp: clients' messages
  [[nodiscard]] Refusal handle(Session& session, Words message, double now_s);
  [[nodiscard]] Refusal on_hello(Session& session, Words message, double now_s);
  [[nodiscard]] Refusal on_start(Session& session, Words message, double now_s);
  [[nodiscard]] Refusal on_force(Session& session, Words message);
  [[nodiscard]] Refusal on_feedback(Session& session, Words message);
  [[nodiscard]] Refusal on_ping(Session& session, Words message, double now_s);
  void welcome(Session& session);
  [[nodiscard]] std::int32_t milliseconds(const Session& session, double now_s) noexcept;

  // Defined in server_setup.cpp: clients' settings
  [[nodiscard]] Refusal on_workspace(Session& session, Words message);
  [[nodiscard]] Refusal on_points(Session& session, Words message);
  [[nodiscard]] Refusal on_gains(Session& session, Words message);
  [[nodiscard]] Refusal on_force_max(Session& session, Words message);
  [[nodiscard]] Refusal on_anchor(Session& session, Words message);
  [[nodiscard]] Refusal on_subscribe(Session& session, Words message);
  [[nodiscard]] static Refusal on_udp(Session& session, Words message);
  void apply_setup() noexcept;

  // Defined in server_streams.cpp: positions, velocities and buttons of the device
  void send_streams(Session& session, double now_s);
  void drag() noexcept;
  void release_point();
  [[nodiscard]] Message move_message() const noexcept;

  static constexpr double kRefusalNotices_hz = 4;

  ServerSettings settings_;
  std::array<std::unique_ptr<Session>, kMaxConnections> sessions_{};
  Admission admission_;
  RateLimit refusal_notices_{kRefusalNotices_hz}; ///< limits these notices, so that they do not
                                                  ///< fill the log
  Session* controller_ = nullptr;
  Liveness liveness_{};
  ServoCommand servo_command_{};
  DeviceReport report_{};
  std::optional<double> origin_s_{}; ///< origin of milliseconds()

  std::optional<std::size_t> grabbed_{}; ///< the controlling client's control point
  Vec3 grab_offset_{};
  std::uint32_t faults_ = 0; ///< the device's fault count at the start
  std::vector<std::string> notices_{};
  std::optional<Clipping> clipping_{};
  std::uint64_t connections_made_ = 0, ignored_datagrams_ = 0;
};

} // namespace tactus::net
