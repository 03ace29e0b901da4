#include "externals/phantom/servo/servo_session.hpp"

#include <chrono>
#include <thread>

namespace tactus::phantom {
namespace {

constexpr double kGraceful_s = 0.2;

} // namespace

void ServoSession::publish(double now_s) noexcept {
  command.heartbeat_s = now_s;
  exchange().commands.write(command);
}

void ServoSession::step(double now_s, double period_s) noexcept {
  publish(now_s);
  stepped_s_ = now_s;
  rig_->servo.step({index_++, now_s, period_s});
}

void ServoSession::attach(haptic::SimulatedDevice& device) noexcept {
  rig_->servo.attach(device, &rig_->local_models, &rig_->patch_models);
}

void ServoSession::attach(const std::shared_ptr<haptic::Backend>& device) noexcept {
  rig_->device = device;
  rig_->servo.attach(*device, &rig_->local_models, &rig_->patch_models);
}

void ServoSession::fade_out() noexcept {
  if (!thread_->running())
    return;
  exchange().motors.pause(true);
  const double give_up_s = devices::ServoThread::now_s() + kGraceful_s;
  while (!exchange().motors.zero_force_confirmed() && devices::ServoThread::now_s() < give_up_s)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  static_cast<void>(thread_->stop()); // can wait, because a simulated step cannot hang
  exchange().motors.pause(false);
}

bool ServoSession::read_report() noexcept {
  const bool is_new = exchange().reports.read();
  has_report_ = has_report_ || is_new;
  return is_new;
}

haptic::ServoStatistics ServoSession::statistics(bool threaded) const noexcept {
  if (!threaded)
    return rig_->servo.statistics();
  exchange().statistics.read();
  return exchange().statistics.latest();
}

void ServoSession::replace() {
  auto next = std::make_shared<ServoRig>();
  haptic::Exchange& from = exchange();
  haptic::Exchange& to = next->servo.exchange();
  to.motors.take_over(from.motors);
  to.tracing = from.tracing.load();
  from.tracing = false;
  from.statistics.read();
  to.reports.write(from.reports.latest());
  to.reports.read();
  to.statistics.write(from.statistics.latest());
  to.statistics.read();
  next->servo.continue_statistics(from.reports.latest(), from.statistics.latest());
  rig_ = std::move(next);
  thread_ = std::make_shared<devices::ServoThread>();
}

} // namespace tactus::phantom
