#include "externals/phantom/wrist.hpp"

#include "externals/phantom/numbers.hpp"

namespace tactus::phantom {

std::string Wrist::enable(Words words, bool open, const haptic::Caps& caps,
                          haptic::Exchange& exchange) {
  if (words[0].is_word || (words[0].number != 0 && words[0].number != 1))
    return expected("torques", words[0], "0 or 1");
  request_.on = words[0].number != 0;
  if (!request_.on)
    request_.command = {};
  publish(exchange);
  return request_.on && open && !(caps.peak_torque_n_m > 0) && !(caps.peak_grip_n > 0)
             ? "torques: this device has no motors for torque or for a gripper"
             : "";
}

std::string Wrist::set_torque(Words words, haptic::Exchange& exchange) {
  constexpr Range ranges[] = {
      {"tx", "N m", -10, 10}, {"ty", "N m", -10, 10}, {"tz", "N m", -10, 10}};
  double torque[3];
  if (const std::string refusal = read_numbers(words, ranges, torque); !refusal.empty())
    return "torque: " + refusal;
  return set({{torque[0], torque[1], torque[2]}, request_.command.grip_n}, "torque", exchange);
}

std::string Wrist::set_grip(Words words, haptic::Exchange& exchange) {
  constexpr Range ranges[] = {{"grip", "N", -40, 40}};
  double grip_n = 0;
  if (const std::string refusal = read_numbers(words, ranges, &grip_n); !refusal.empty())
    return "grip: " + refusal;
  return set({request_.command.torque_n_m, grip_n}, "grip", exchange);
}

std::string Wrist::set(const haptic::WristCommand& command, std::string_view message,
                       haptic::Exchange& exchange) {
  if (!request_.on)
    return std::string(message) + ": torque and grip are off: send torques 1 first";
  request_.command = command;
  publish(exchange);
  return {};
}

void Wrist::send(const haptic::Report& report, bool all, bool has_gripper, const Reports& reports,
                 Host& host) const {
  const Vec3& torque = report.wrist.torque_n_m;
  if (reports.on(kTorque) || (all && request_.on))
    host.info({"torque", torque.x, torque.y, torque.z});
  if (reports.on(kGrip) || (all && has_gripper))
    host.info({"grip", report.state.gripper_m * 1e3, report.wrist.grip_n});
}

} // namespace tactus::phantom
