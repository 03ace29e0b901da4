#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "net/client.hpp"
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
  void hold(const Vec3& position) { device.set_path(haptic::LinePath{position, position, 1}); }

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
  Vec3 force_n{};
  double max_force_n = 0;
  bool servo_runs = true;
};

/// One connection to it, in any framing.
class TestClient {
public:
  explicit TestClient(Rig& rig, Framing framing = Framing::kLength,
                      std::string_view peer = "127.0.0.1")
      : rig_(rig), framing_(framing) {
    id_ = rig.server.connect(peer, rig.now_s);
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
  /// Says this line for so long, each tenth of a second.
  void repeat(const std::string& line, double seconds) {
    for (int left = static_cast<int>(seconds * 10 + 0.5); left > 0; --left) {
      send_text(line);
      rig_.run(0.1);
    }
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

/// A server and a client that has said hello.
struct Served {
  Served() { client.hello(); }
  Rig rig{usual()};
  TestClient client{rig};
};

/// A server and a client of net/client.hpp, with a line for both transports between them that can
/// be cut.
struct Line {
  explicit Line(ServerSettings settings = usual(), ClientSettings own = {}, int udp_port = 0)
      : rig(std::move(settings)), client(std::move(own)), port(udp_port) {}

  void connect() {
    id = rig.server.connect("127.0.0.1", rig.now_s, port);
    client.connect(rig.now_s);
  }
  void cut() {
    rig.server.disconnect(*id);
    client.disconnect();
    id.reset();
  }
  static Bytes taken(OutQueue& queue) {
    Bytes bytes;
    while (queue.size() > 0) {
      bytes.insert(bytes.end(), queue.front().begin(), queue.front().end());
      queue.consume(queue.front().size());
    }
    return bytes;
  }
  void tick() {
    rig.tick();
    if (!id)
      return;
    wanted = wanted && client.advance(rig.now_s);
    if (!passes)
      return;
    rig.server.receive(*id, taken(client.out()), rig.now_s);
    const Bytes answer = taken(rig.server.out(*id));
    tcp_bytes += answer.size();
    wanted = wanted && client.receive(answer, rig.now_s);
    if (const auto probe = client.datagrams().probe(rig.now_s); probe && probes_pass)
      CHECK(rig.server.receive_datagram("127.0.0.1", probe->span(), rig.now_s) == id);
    while (const auto datagram = rig.server.datagrams(*id)->take()) {
      ++datagrams;
      if (datagrams_pass)
        client.receive_datagram(datagram->span(), rig.now_s);
    }
    oldest_s = std::max(oldest_s, rig.now_s - client.position_s());
  }
  void run(double seconds) {
    oldest_s = 0;
    tcp_bytes = datagrams = 0;
    for (int left = static_cast<int>(seconds * 1e3 + 0.5); left > 0; --left)
      tick();
  }

  Rig rig;
  Client client;
  int port;
  std::optional<Server::ClientId> id{};
  bool passes = true; ///< bytes of TCP, both ways
  bool probes_pass = true, datagrams_pass = true;
  bool wanted = true; ///< the client keeps the connection
  std::size_t tcp_bytes = 0, datagrams = 0;
  double oldest_s = 0; ///< age of the newest position, at its largest
};

} // namespace tactus::net
