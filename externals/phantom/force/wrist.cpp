#include "externals/phantom/force/wrist.hpp"

#include <string>

namespace tactus::phantom {

void Wrist::enable(const Atom& on, Host& host) {
  if (on.is_word || (on.number != 0 && on.number != 1))
    return host.error(expected("torques", on, "0 or 1"));
  request_.on = on.number != 0;
  if (!request_.on)
    request_.command = {};
  publish();
  const haptic::Caps caps = link_.device().caps();
  if (request_.on && link_.is_open() && !(caps.peak_torque_n_m > 0) && !(caps.peak_grip_n > 0))
    host.error("torques: this device has no motors for torque or for a gripper");
}

void Wrist::set_torque(Words words, Host& host) {
  constexpr Range ranges[] = {
      {"tx", "N m", -10, 10}, {"ty", "N m", -10, 10}, {"tz", "N m", -10, 10}};
  double torque[3];
  if (const std::string refusal = read_numbers(words, ranges, torque); !refusal.empty())
    return host.error("torque: " + refusal);
  set({{torque[0], torque[1], torque[2]}, request_.command.grip_n}, "torque", host);
}

void Wrist::set_grip(Words words, Host& host) {
  constexpr Range ranges[] = {{"grip", "N", -40, 40}};
  double grip_n = 0;
  if (const std::string refusal = read_numbers(words, ranges, &grip_n); !refusal.empty())
    return host.error("grip: " + refusal);
  set({request_.command.torque_n_m, grip_n}, "grip", host);
}

void Wrist::set(const haptic::WristCommand& command, std::string_view message, Host& host) {
  if (!request_.on)
    return host.error(std::string(message) + ": torque and grip are off: send torques 1 first");
  request_.command = command;
  publish();
}

void Wrist::send(const haptic::Report& report, bool all, Host& host) const {
  const Vec3& torque = report.wrist.torque_n_m;
  if (reports_.on(kTorque) || (all && request_.on))
    host.info({"torque", torque.x, torque.y, torque.z});
  if (reports_.on(kGrip) || (all && link_.device().caps().has_gripper))
    host.info({"grip", report.state.gripper_m * 1e3, report.wrist.grip_n});
}

} // namespace tactus::phantom
