#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/tags.hpp"

/// [phantom]'s torque on the handle and force of the gripper, for devices with motors for them. Off
/// until `torques 1`.
namespace tactus {

using namespace phantom;

void Phantom::on_torques(Words words, Host& host) {
  if (words[0].is_word || (words[0].number != 0 && words[0].number != 1))
    return host.error(expected("torques", words[0], "0 or 1"));
  wrist_.on = words[0].number != 0;
  if (!wrist_.on)
    wrist_.command = {};
  exchange().wrist.write(wrist_);
  const haptic::Caps caps = device().caps();
  if (wrist_.on && open() && !(caps.peak_torque_n_m > 0) && !(caps.peak_grip_n > 0))
    host.error("torques: this device has no motors for torque or for a gripper");
}

void Phantom::on_torque(Words words, Host& host) {
  constexpr Range ranges[] = {
      {"tx", "N m", -10, 10}, {"ty", "N m", -10, 10}, {"tz", "N m", -10, 10}};
  double torque[3];
  if (const std::string refusal = read_numbers(words, ranges, torque); !refusal.empty())
    return host.error("torque: " + refusal);
  set_wrist({{torque[0], torque[1], torque[2]}, wrist_.command.grip_n}, "torque", host);
}

void Phantom::on_grip(Words words, Host& host) {
  constexpr Range ranges[] = {{"grip", "N", -40, 40}};
  double grip_n = 0;
  if (const std::string refusal = read_numbers(words, ranges, &grip_n); !refusal.empty())
    return host.error("grip: " + refusal);
  set_wrist({wrist_.command.torque_n_m, grip_n}, "grip", host);
}

void Phantom::set_wrist(const haptic::WristCommand& command, std::string_view message, Host& host) {
  if (!wrist_.on)
    return host.error(std::string(message) + ": torque and grip are off: send torques 1 first");
  wrist_.command = command;
  exchange().wrist.write(wrist_);
}

void Phantom::send_wrist(Host& host, bool all) {
  const haptic::Report& report = exchange().reports.latest();
  const Vec3& torque = report.wrist.torque_n_m;
  if (reported_[kTorqueTag] || (all && wrist_.on))
    host.info({"torque", torque.x, torque.y, torque.z});
  if (reported_[kGripTag] || (all && device().caps().has_gripper))
    host.info({"grip", report.state.gripper_m * 1e3, report.wrist.grip_n});
}

} // namespace tactus
