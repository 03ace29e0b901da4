#include "net/servo_link.hpp"

namespace tactus::net {

ServoLink::ServoLink(haptic::Servo& servo, RenderModel& model, const haptic::ChainSettings& chain,
                     const haptic::AxisMap& map)
    : exchange_(servo.exchange()), model_(model), settings_{chain, map} {
  settings_.chain.hold_s = kHold_s;
  settings_.chain.ramp_s = kRamp_s;
  settings_.chain.force_limit_n = 0; // until there are orders
  exchange_.settings.write(settings_);
  exchange_.motors.pause(true);
}

void ServoLink::exchange(Server& server, double now_s) {
  haptic::Event event;
  while (exchange_.events.pop(event))
    if (event.kind == haptic::Event::Kind::kButton)
      server.press(event.number, event.on);
  exchange_.reports.read();
  const haptic::Report& report = exchange_.reports.latest();
  server.advance({report.state, exchange_.motors.request().stopped, report.faults}, now_s);
  give(server.orders());
}

void ServoLink::give(const ServoOrders& orders) noexcept {
  if (orders.force_limit_n != settings_.chain.force_limit_n) {
    settings_.chain.force_limit_n = orders.force_limit_n;
    exchange_.settings.write(settings_);
  }
  if (!(orders.render == sent_)) {
    sent_ = orders.render;
    model_.set(sent_);
  }
  haptic::Command command;
  command.force_n = orders.force_n;
  command.number = orders.forces;
  command.heartbeat_s = orders.alive_s;
  exchange_.commands.write(command);
  // A failure of the device ends with the next start, as with the motors' switch beside it.
  if (orders.render.starts != starts_ && orders.running &&
      exchange_.reports.latest().fault != haptic::Fault::kNone &&
      !exchange_.motors.request().stopped)
    exchange_.motors.enable();
  starts_ = orders.render.starts;
  if (orders.running != running_) {
    running_ = orders.running;
    exchange_.motors.pause(!running_);
  }
}

} // namespace tactus::net
