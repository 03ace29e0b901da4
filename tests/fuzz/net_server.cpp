// The haptic server and client, fed with decoded frames: whatever a peer sends, the command for the
// servo stays within the server's limits.
#include "net/client.hpp"
#include "net/server.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>
#include <memory>

using namespace tactus;
using namespace tactus::net;
using tactus::fuzz::check;

namespace {

constexpr double kLimit_n = 2, kStiffness = 400, kDamping = 4;

void check_command(const Server& server) {
  const ServoCommand& servo_command = server.servo_command();
  check(is_finite(servo_command.force_n), "a force that is not finite");
  check(servo_command.force_limit_n >= 0 && servo_command.force_limit_n <= kLimit_n,
        "the force limit was raised");
  const stress::RenderGains& gains = servo_command.render.gains;
  check(gains.stiffness_max_n_per_m <= kStiffness && gains.damping_max_n_s_per_m <= kDamping,
        "a gain was raised");
  check(gains.stiffness_min_n_per_m >= 0 && gains.damping_min_n_s_per_m >= 0, "a negative gain");
  for (int axis = 0; axis < 3; ++axis)
    check(servo_command.render.gamma[axis] >= 0 && servo_command.render.gamma[axis] <= 1,
          "gamma is beyond 0..1");
  check(is_finite(servo_command.render.anchor), "an anchor that is not finite");
  check(!servo_command.running || !server.controller_name().empty(), "motors without a controller");
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  ServerSettings settings;
  settings.force_limit_n = kLimit_n;
  settings.stiffness_limit_n_per_m = kStiffness;
  settings.damping_limit_n_s_per_m = kDamping;
  static std::unique_ptr<Server> server = std::make_unique<Server>(settings);
  static double now_s = 1;
  static DeviceReport report;
  report.state.position = {0.001 * std::sin(now_s), 0, 0};
  const auto id = server->connect("127.0.0.1", now_s);
  // In two pieces, with buttons and time in between.
  const auto first = input.first(input.size() / 2);
  server->receive(id, first, now_s);
  check_command(*server);
  server->set_button(0, true);
  server->advance(report, now_s += 0.3);
  server->receive(id, input.subspan(first.size()), now_s);
  check_command(*server);
  server->set_button(0, false);
  server->advance(report, now_s += 0.3);
  check(server->out(id).size() <= OutQueue::kCapacity, "the queue is longer than it may be");
  server->disconnect(id);
  check(!server->servo_command().running, "the motors outlive their client");
  check(server->servo_command().force_n == Vec3{}, "a force outlives its client");
  server->advance(report, now_s += 0.3);

  static std::unique_ptr<Client> client = std::make_unique<Client>();
  client->connect(now_s);
  static_cast<void>(client->receive(input, now_s));
  check(is_finite(client->position()), "a position that is not finite");
}
