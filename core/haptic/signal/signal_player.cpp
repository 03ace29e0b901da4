#include "core/haptic/signal/signal_player.hpp"

namespace tactus::haptic {
namespace {
/// Playout restarts when its error exceeds this plus the delay.
constexpr double kMaxPlayoutError_s = 0.1;
constexpr double kRateGain_per_s = 2.0; // rate correction per second of playout error
// Small enough for the pitch change of a sound controlled by the position to be inaudible.
constexpr double kMaxRateCorrection = 0.02;
constexpr double kJitterMargin_s = 1.5e-3; // a servo period and its jitter
constexpr double kMaxBurst_s = 0.05;
constexpr double kTickTolerance = 1e-6; // samples; rounding of a tick's sample
constexpr double kSameTime = 0.1;       // samples; rounding of a block's time
} // namespace

void SignalPlayer::prepare(double sample_rate_hz) noexcept {
  const double before_hz = sample_rate_hz_;
  sample_rate_hz_ = sample_rate_hz > 0 && sample_rate_hz < 1e9 ? sample_rate_hz : 48000;
  if (sample_rate_hz_ != before_hz)
    rate_hz_ = 0; // makes the ticks restart at the next block; else their grid would continue
}

void SignalPlayer::attach(SignalLink* link) noexcept {
  link_ = link;
  rate_hz_ = 0;
}

void SignalPlayer::restart(SignalLink::Time time, double rate_hz) noexcept {
  time_ = time;
  rate_hz_ = rate_hz;
  sample_ = tick_ = 0;
  start_s_ = due_s_ = std::numeric_limits<double>::quiet_NaN();
  stepped_ = playing_ = false;
  written_ = 0;
  since_newest_s_ = max_since_newest_s_ = 0;
  decimator_.reset();
  decimator_.set(sample_rate_hz_, rate_hz_);
}

/// For a block that does not follow the last one: the first block, or a block after other objects
/// have stepped the servo.
void SignalPlayer::find_next_tick(double start_s) noexcept {
  sample_ = tick_ = 0;
  start_s_ = due_s_ = start_s;
  const Sample& last = link_->last_tick();
  if (!std::isfinite(last.time_s))
    return;
  due_s_ = last.time_s + 1.0 / rate_hz_;
  const double missed = (start_s - due_s_) * rate_hz_; // periods
  if (missed > kTickTolerance)
    due_s_ += std::ceil(missed - kTickTolerance) / rate_hz_;
  previous_ = current_ = last;
  take_network(current_.network_samples);
  stepped_ = true;
}

void SignalPlayer::begin_block(std::size_t frames, double start_s) noexcept {
  if (!link_)
    return;
  const auto time = link_->time();
  const double rate_hz = link_->rate_hz();
  if (time != time_ || rate_hz != rate_hz_)
    restart(time, rate_hz);
  workspace_ = link_->workspace();
  link_->count_block(static_cast<double>(frames) / sample_rate_hz_);
  start_s -= link_->origin_s();
  if (time_ == SignalLink::Time::kLogical && std::isfinite(start_s) &&
      !(std::abs((start_s - start_s_) * sample_rate_hz_ - static_cast<double>(sample_)) <
        kSameTime))
    find_next_tick(start_s);
  if (time_ == SignalLink::Time::kWall)
    collect();
}

void SignalPlayer::end_block(double wall_s) noexcept {
  if (link_ && time_ == SignalLink::Time::kWall) {
    link_->set_gate(gated_);
    link_->write_force({inputs_.force_n, wall_s});
  }
}

SignalPlayer::Outputs SignalPlayer::interpolated_output(const Sample& a, const Sample& b,
                                                        double fraction) const noexcept {
  const auto lerp = [fraction](const Vec3& from, const Vec3& to) {
    return from + (to - from) * fraction;
  };
  const auto from = static_cast<double>(a.network_samples);
  const auto to = static_cast<double>(b.network_samples);
  return {workspace_.normalised(lerp(a.position, b.position)), lerp(a.velocity, b.velocity),
          network_at(from + (to - from) * fraction - 1)};
}

void SignalPlayer::take_network(std::uint64_t until) noexcept {
  NetworkSample sample;
  while (link_->taken_samples() < until && link_->next(sample))
    network_[link_->taken_samples() % kNetworkHistory] = sample;
}

/// Samples are numbered from 1; outside of the stored range the nearest one is returned.
NetworkSample SignalPlayer::network_sample(double number) const noexcept {
  const auto last = static_cast<double>(link_->taken_samples());
  if (last < 1)
    return {};
  return network_[static_cast<std::uint64_t>(std::clamp(number, 1.0, last)) % kNetworkHistory];
}

/// Cubic Lagrange interpolation of the four samples around that number.
std::array<double, Network::kPickups> SignalPlayer::network_at(double number) const noexcept {
  const double before = std::floor(number), t = number - before;
  const double weights[] = {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2,
                            -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6};
  std::array<double, Network::kPickups> sum{};
  for (int k = 0; k < 4; ++k) {
    const NetworkSample sample = network_sample(before + k - 1);
    for (std::size_t p = 0; p < sum.size(); ++p)
      sum[p] += weights[k] * static_cast<double>(sample[p]);
  }
  return sum;
}

void SignalPlayer::step_due(const Inputs& inputs, double vibration_n) noexcept {
  const double samples_per_tick = sample_rate_hz_ / rate_hz_;
  const bool timed = std::isfinite(start_s_);
  const double first_sample = timed ? (due_s_ - start_s_) * sample_rate_hz_ : 0.0; // of tick 0
  const auto sample_of_tick = [&](std::uint64_t tick) {
    return first_sample + static_cast<double>(tick) * samples_per_tick;
  };
  const auto current_sample = static_cast<double>(sample_);
  for (int steps = 0; sample_of_tick(tick_) <= current_sample + kTickTolerance; ++steps) {
    if (steps == kMaxTicksPerSample) { // the sample rate is far too low: no more ticks for it
      sample_ = tick_ = 0;
      start_s_ = due_s_ = std::numeric_limits<double>::quiet_NaN();
      break;
    }
    previous_ = current_;
    const double due_s = due_s_ + static_cast<double>(tick_) / rate_hz_;
    current_ = link_->step(inputs.force_n, vibration_n, gated_, due_s);
    take_network(current_.network_samples);
    if (!stepped_)
      previous_ = current_;
    stepped_ = true;
    ++tick_;
  }
  const double since = static_cast<double>(sample_) - sample_of_tick(tick_) + samples_per_tick;
  last_ = interpolated_output(previous_, current_, std::clamp(since / samples_per_tick, 0.0, 1.0));
}

void SignalPlayer::collect() noexcept {
  Sample sample;
  for (std::size_t taken = 0; taken < kHistory && link_->next(sample); ++taken)
    take_network((history_[written_++ % kHistory] = sample).network_samples);
  if (written_ == 0)
    return;
  if (newest(0).time_s != newest_s_) {
    newest_s_ = newest(0).time_s;
    since_newest_s_ = 0;
  }
  if (!playing_ || !(std::abs(target_time_s() - played_s_) < kMaxPlayoutError_s + delay_s_))
    played_s_ = target_time_s();
  playing_ = true;
}

/// The time to play now: behind the newest sample by the set delay, or by more while audio is
/// computed in bursts. During a burst playout runs ahead by half of its length on average.
double SignalPlayer::target_time_s() const noexcept {
  const double min_delay_s = std::min(0.5 * max_since_newest_s_ + kJitterMargin_s, kMaxBurst_s);
  return newest(0).time_s - std::max(delay_s_, min_delay_s);
}

void SignalPlayer::play(double vibration_n) noexcept {
  const double samples_per_tick = sample_rate_hz_ / rate_hz_;
  if (static_cast<double>(tick_) * samples_per_tick <=
      static_cast<double>(sample_) + kTickTolerance) {
    link_->push_vibration(vibration_n);
    tick_ = static_cast<std::uint64_t>(static_cast<double>(sample_) / samples_per_tick) + 1;
  }
  if (!playing_)
    return;
  since_newest_s_ += 1.0 / sample_rate_hz_;
  max_since_newest_s_ = std::max(max_since_newest_s_, since_newest_s_);
  const double error_s = target_time_s() - played_s_;
  const double rate_correction =
      std::clamp(kRateGain_per_s * error_s, -kMaxRateCorrection, kMaxRateCorrection);
  played_s_ += (1.0 + rate_correction) / sample_rate_hz_;
  // The pair of ticks around this time; outside of the stored range the position is held.
  const std::size_t stored = static_cast<std::size_t>(std::min<std::uint64_t>(written_, kHistory));
  std::size_t age = 0;
  while (age + 2 < stored && newest(age + 1).time_s > played_s_)
    ++age;
  const Sample &b = newest(age), &a = newest(stored > 1 ? age + 1 : age);
  const double span_s = b.time_s - a.time_s;
  last_ = interpolated_output(
      a, b, span_s > 0 ? std::clamp((played_s_ - a.time_s) / span_s, 0.0, 1.0) : 1.0);
}

SignalPlayer::Outputs SignalPlayer::process(const Inputs& inputs) noexcept {
  if (!link_ || time_ == SignalLink::Time::kNone)
    return last_;
  inputs_ = inputs;
  const double vibration_n = decimator_.process(inputs.vibration_n);
  if (time_ == SignalLink::Time::kLogical)
    step_due(inputs, vibration_n);
  else
    play(vibration_n);
  ++sample_;
  return last_;
}

} // namespace tactus::haptic
