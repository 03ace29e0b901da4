#include "core/haptic/signal/signal_player.hpp"

namespace tactus::haptic {
namespace {
constexpr double kLost_s = 0.1;     // farther from its place, the playing begins anew
constexpr double kPull_per_s = 2.0; // of the playing speed, per second beside its place
constexpr double kMostPull = 0.02;  // so that a moving position is not heard to change pitch
constexpr double kSpare_s = 1.5e-3; // a servo period and its jitter
constexpr double kLongestBurst_s = 0.05;
constexpr double kAtTick = 1e-9; // samples; rounding of the tick's place
} // namespace

void SignalPlayer::prepare(double sample_rate_hz) noexcept {
  const double before_hz = sample_rate_hz_;
  sample_rate_hz_ = sample_rate_hz > 0 && sample_rate_hz < 1e9 ? sample_rate_hz : 48000;
  if (sample_rate_hz_ != before_hz)
    rate_hz_ = 0; // restarts at the next block; else the grid of ticks goes on
}

void SignalPlayer::attach(SignalLink* link) noexcept {
  link_ = link;
  rate_hz_ = 0;
}

void SignalPlayer::restart(SignalLink::Time time, double rate_hz) noexcept {
  time_ = time;
  rate_hz_ = rate_hz;
  sample_ = tick_ = 0;
  stepped_ = playing_ = false;
  written_ = 0;
  unfed_s_ = longest_unfed_s_ = 0;
  decimator_.reset();
  decimator_.set(sample_rate_hz_, rate_hz_);
}

void SignalPlayer::begin_block(std::size_t frames) noexcept {
  if (!link_)
    return;
  const auto time = link_->time();
  const double rate_hz = link_->rate_hz();
  if (time != time_ || rate_hz != rate_hz_)
    restart(time, rate_hz);
  workspace_ = link_->workspace();
  link_->count_block(static_cast<double>(frames) / sample_rate_hz_);
  if (time_ == SignalLink::Time::kWall)
    collect();
}

void SignalPlayer::end_block(double wall_s) noexcept {
  if (link_ && time_ == SignalLink::Time::kWall) {
    link_->set_gate(gated_);
    link_->hear({heard_.force_n, wall_s});
  }
}

SignalPlayer::Outputs SignalPlayer::between(const Sample& a, const Sample& b,
                                            double share) const noexcept {
  const auto mix = [share](const Vec3& from, const Vec3& to) { return from + (to - from) * share; };
  const auto from = static_cast<double>(a.network_samples);
  const auto to = static_cast<double>(b.network_samples);
  return {workspace_.normalised(mix(a.position, b.position)), mix(a.velocity, b.velocity),
          network_at(from + (to - from) * share - 1)};
}

void SignalPlayer::take_network(std::uint64_t until) noexcept {
  NetworkSample sample;
  while (link_->taken_samples() < until && link_->next(sample))
    network_[link_->taken_samples() % kNetworkHistory] = sample;
}

/// Samples are numbered from 1; before the first and after the last the nearest counts.
NetworkSample SignalPlayer::network_sample(double number) const noexcept {
  const auto last = static_cast<double>(link_->taken_samples());
  if (last < 1)
    return {};
  return network_[static_cast<std::uint64_t>(std::clamp(number, 1.0, last)) % kNetworkHistory];
}

/// Lagrange's cubic through the four samples around that number.
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
  const double samples_a_tick = sample_rate_hz_ / rate_hz_;
  const auto place = [&](std::uint64_t tick) { return static_cast<double>(tick) * samples_a_tick; };
  const auto here = static_cast<double>(sample_);
  for (int steps = 0; place(tick_) <= here + kAtTick; ++steps) {
    if (steps == kMostTicksASample) { // an absurd sample rate: this many ticks must do
      sample_ = tick_ = 0;
      break;
    }
    before_ = now_;
    now_ = link_->step(inputs.force_n, vibration_n, gated_);
    take_network(now_.network_samples);
    if (!stepped_)
      before_ = now_;
    stepped_ = true;
    ++tick_;
  }
  const double since = static_cast<double>(sample_) - place(tick_ > 0 ? tick_ - 1 : 0);
  last_ = between(before_, now_, std::clamp(since / samples_a_tick, 0.0, 1.0));
}

void SignalPlayer::collect() noexcept {
  Sample sample;
  for (std::size_t taken = 0; taken < kHistory && link_->next(sample); ++taken)
    take_network((history_[written_++ % kHistory] = sample).network_samples);
  if (written_ == 0)
    return;
  if (newest(0).time_s != fed_s_) {
    fed_s_ = newest(0).time_s;
    unfed_s_ = 0;
  }
  if (!playing_ || !(std::abs(aim_s() - played_s_) < kLost_s + delay_s_))
    played_s_ = aim_s();
  playing_ = true;
}

/// Where the playing should be: the set delay behind the newest, or more while the audio is
/// computed in bursts, over which it runs ahead by half their length.
double SignalPlayer::aim_s() const noexcept {
  const double needed_s = std::min(0.5 * longest_unfed_s_ + kSpare_s, kLongestBurst_s);
  return newest(0).time_s - std::max(delay_s_, needed_s);
}

void SignalPlayer::play(double vibration_n) noexcept {
  const double samples_a_tick = sample_rate_hz_ / rate_hz_;
  if (static_cast<double>(tick_) * samples_a_tick <= static_cast<double>(sample_) + kAtTick) {
    link_->vibrate(vibration_n);
    tick_ = static_cast<std::uint64_t>(static_cast<double>(sample_) / samples_a_tick) + 1;
  }
  if (!playing_)
    return;
  unfed_s_ += 1.0 / sample_rate_hz_;
  longest_unfed_s_ = std::max(longest_unfed_s_, unfed_s_);
  const double error_s = aim_s() - played_s_;
  const double pull = std::clamp(kPull_per_s * error_s, -kMostPull, kMostPull);
  played_s_ += (1.0 + pull) / sample_rate_hz_;
  // The pair of ticks around this time; before the oldest or after the newest it stands still.
  const std::size_t kept = written_ < kHistory ? written_ : kHistory;
  std::size_t age = 0;
  while (age + 2 < kept && newest(age + 1).time_s > played_s_)
    ++age;
  const Sample &b = newest(age), &a = newest(kept > 1 ? age + 1 : age);
  const double span_s = b.time_s - a.time_s;
  last_ = between(a, b, span_s > 0 ? std::clamp((played_s_ - a.time_s) / span_s, 0.0, 1.0) : 1.0);
}

SignalPlayer::Outputs SignalPlayer::process(const Inputs& inputs) noexcept {
  if (!link_ || time_ == SignalLink::Time::kNone)
    return last_;
  heard_ = inputs;
  const double vibration_n = decimator_.process(inputs.vibration_n);
  if (time_ == SignalLink::Time::kLogical)
    step_due(inputs, vibration_n);
  else
    play(vibration_n);
  ++sample_;
  return last_;
}

} // namespace tactus::haptic
