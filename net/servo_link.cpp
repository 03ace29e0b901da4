#include "net/servo_link.hpp"

namespace tactus::net {

ServoLink::ServoLink(haptic::Servo& servo, RenderModel& model, const haptic::ChainSettings& chain,
                     const haptic::AxisMap& map)
    : exchange_(servo.exchange()), model_(model), settings_{chain, map} {
  settings_.chain.allowance_w = haptic::kAllowance_w;
  settings_.chain.hold_s = kHold_s;
  settings_.chain.ramp_s = kRamp_s;
  settings_.chain.force_limit_n = 0; // zero until the first command arrives
  exchange_.settings.write(settings_);
  exchange_.motors.pause(true);
}

void ServoLink::exchange(Server& server, double now_s) {
  haptic::ServoEvent event;
  while (exchange_.events.pop(event))
    if (const auto* const button = std::get_if<haptic::ButtonEvent>(&event))
      server.set_button(button->number, button->on);
  exchange_.reports.read();
  const haptic::Report& report = exchange_.reports.latest();
  server.advance({report.state, exchange_.motors.request().stopped, report.faults, report.clipping,
                  report.asked_n},
                 now_s);
  send(server.servo_command());
}

void ServoLink::send(const ServoCommand& servo_command) noexcept {
  if (servo_command.force_limit_n != settings_.chain.force_limit_n) {
    settings_.chain.force_limit_n = servo_command.force_limit_n;
    exchange_.settings.write(settings_);
  }
  if (!(servo_command.render == sent_)) {
    sent_ = servo_command.render;
    model_.set(sent_);
  }
  haptic::Command command;
  command.force_n = servo_command.force_n;
  command.number = servo_command.forces;
  command.heartbeat_s = servo_command.alive_s;
  exchange_.commands.write(command);
  // The next start clears a fault of the device, as switching the motors on does.
  if (servo_command.render.starts != starts_ && servo_command.running &&
      exchange_.reports.latest().fault != haptic::Fault::kNone &&
      !exchange_.motors.request().stopped)
    exchange_.motors.enable();
  starts_ = servo_command.render.starts;
  if (servo_command.running != running_) {
    running_ = servo_command.running;
    exchange_.motors.pause(!running_);
  }
}

} // namespace tactus::net
