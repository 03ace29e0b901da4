#include "core/haptic/signal/signal_link.hpp"

namespace tactus::haptic {

void SignalLink::begin() noexcept {
  double unused = 0;
  while (vibrations_.pop(unused)) {
  }
  playing_ = false;
  last_vibration_ = 0;
  tick_sample_.time_s = std::numeric_limits<double>::quiet_NaN(); // another servo, or another clock
}

void SignalLink::count_block(double duration_s) noexcept {
  blocks_.store(blocks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (duration_s > max_block_s_.load(std::memory_order_relaxed))
    max_block_s_.store(duration_s, std::memory_order_relaxed);
}

/// Force of the vibration: along the normal of the touched face, or along z without a contact.
Vec3 SignalLink::vibration(double newton, bool gated) const noexcept {
  const auto touches = scene_ ? scene_->touches() : std::span<const Touch>{};
  if (!std::isfinite(newton) || (touches.empty() && gated))
    return {};
  return (touches.empty() ? Vec3{0, 0, 1} : touches[0].normal) * newton;
}

/// Returns one value for each tick from a queue that the audio fills in bursts. Reading starts when
/// kVibrationDelay values are queued, also after the queue ran empty; a queue that has grown too
/// long is shortened.
double SignalLink::next_vibration() noexcept {
  const std::size_t queued = vibrations_.size();
  if (!playing_ && queued < kVibrationDelay)
    return last_vibration_ *= 0.5; // decays instead of a step to zero
  playing_ = true;
  if (queued > kMaxQueuedVibration)
    for (std::size_t i = kVibrationDelay; i < queued; ++i)
      vibrations_.pop(last_vibration_);
  playing_ = vibrations_.pop(last_vibration_);
  return last_vibration_;
}

/// Dropped samples are not counted, so that both sides have the same count.
void SignalLink::send_network() noexcept {
  if (network_)
    for (const NetworkSample& sample : network_->samples())
      sent_samples_ += network_samples_.push(sample);
  tick_sample_.network_samples = sent_samples_;
}

Vec3 SignalLink::force(const Tick& tick, const State& state) noexcept {
  tick_sample_.time_s = tick.time_s;
  tick_sample_.position = state.position;
  tick_sample_.velocity = state.velocity;
  tick_sample_.touching = scene_ && !scene_->touches().empty();
  switch (time_.load(std::memory_order_acquire)) {
  case Time::kLogical:
    if (!stepping_)
      return {};
    send_network();
    return force_now_ + vibration(vibration_now_, gated_now_);
  case Time::kWall: {
    send_network();
    samples_.push(tick_sample_);
    forces_.read();
    const Force& requested = forces_.latest();
    const bool stale = !(tick.time_s - requested.time_s < kStale_s);
    const Vec3 force = stale || !is_finite(requested.force_n) ? Vec3{} : requested.force_n;
    return force + vibration(next_vibration(), gated_.load(std::memory_order_relaxed));
  }
  case Time::kNone:
    break;
  }
  return {};
}

SignalLink::Sample SignalLink::step(const Vec3& force_n, double vibration_n, bool gated,
                                    double due_s) noexcept {
  due_s_ = due_s;
  force_now_ = is_finite(force_n) ? force_n : Vec3{};
  vibration_now_ = vibration_n;
  gated_now_ = gated;
  stepping_ = true;
  if (stepper_.step)
    stepper_.step(stepper_.context);
  stepping_ = false;
  return tick_sample_;
}

} // namespace tactus::haptic
