#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "net/servo_link.hpp"
#include "tests/net/bytes.hpp"

#include <doctest/doctest.h>

/// A server with a servo and a simulated device, in a time of its own.
namespace tactus::net {

struct Rig {
  explicit Rig(ServerSettings settings = {}) : server(std::move(settings)) {
    haptic::SimulatedDevice::Settings held;
    held.hand.hold = haptic::HandSettings::Hold::kRigid;
    device.set(held);
    hold({});
    servo.attach(device, &model);
  }

  /// The hand holds the handle there. m
  void hold(const haptic::Vec3& position) {
    device.set_path(haptic::LinePath{position, position, 1});
  }

  /// One millisecond of everything.
  void tick() {
    now_s = 100 + static_cast<double>(++ticks) * 1e-3;
    link.exchange(server, now_s);
    if (servo_runs)
      servo.step({ticks, now_s, 1e-3});
    force_n = servo.chain().written;
    max_force_n = std::max(max_force_n, norm(force_n));
  }
  void run(double seconds) {
    for (int left = static_cast<int>(seconds * 1e3 + 0.5); left > 0; --left)
      tick();
  }

  Server server;
  haptic::SimulatedDevice device{};
  RenderModel model{};
  haptic::Servo servo{};
  ServoLink link{servo, model, {}};
  std::uint64_t ticks = 0;
  double now_s = 100;
  haptic::Vec3 force_n{};
  double max_force_n = 0;
  bool servo_runs = true;
};

/// One connection to it, in any framing.
class TestClient {
public:
  explicit TestClient(Rig& rig, Framing framing = Framing::kLength,
                      std::string_view peer = "127.0.0.1")
      : rig_(rig), framing_(framing) {
    const auto id = rig.server.connect(peer, rig.now_s);
    REQUIRE(id.has_value());
    id_ = *id;
  }

  void send(const Message& message) { send_bytes(frame(framing_, message)); }
  void send_bytes(const Bytes& bytes) { rig_.server.receive(id_, bytes, rig_.now_s); }
  /// A line of FUDI, whatever the framing.
  void send_text(const std::string& line) {
    FrameReader reader;
    const Bytes bytes = bytes_of(line + ";");
    std::span<const std::uint8_t> rest(bytes);
    Message message;
    REQUIRE(reader.next(rest, message) == FrameReader::Outcome::kMessage);
    send(message);
  }
  void hello(std::string_view role = "control", std::string_view token = "") {
    send(Message(Address::kHello).integer(1).string("test").string(role).string(token));
  }
  /// What the server has said since the last call, a line a message.
  std::vector<std::string> received() {
    std::vector<std::string> lines;
    OutQueue& queue = rig_.server.out(id_);
    while (queue.size() > 0) {
      std::span<const std::uint8_t> bytes = queue.front();
      const std::size_t size = bytes.size();
      Message message;
      while (reader_->next(bytes, message) == FrameReader::Outcome::kMessage)
        lines.push_back(to_text(message));
      queue.consume(size);
    }
    return lines;
  }
  bool has_received(const std::string& beginning) {
    for (const std::string& line : received())
      if (line.starts_with(beginning))
        return true;
    return false;
  }
  [[nodiscard]] bool closing() const { return rig_.server.closing(id_); }
  [[nodiscard]] OutQueue& out() const { return rig_.server.out(id_); }
  void disconnect() { rig_.server.disconnect(id_); }
  [[nodiscard]] Server::ClientId id() const { return id_; }

private:
  Rig& rig_;
  Framing framing_;
  Server::ClientId id_ = 0;
  std::unique_ptr<FrameReader> reader_ = std::make_unique<FrameReader>();
};

/// The settings of a device that may push with 3 N.
inline ServerSettings usual() {
  ServerSettings settings;
  settings.force_limit_n = 3;
  return settings;
}

} // namespace tactus::net
