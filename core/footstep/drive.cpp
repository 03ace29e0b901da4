#include "core/footstep/drive.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

using std::numbers::pi;
constexpr double kLowEdgeHz = 50, kHighEdgeHz = 500;
constexpr double kRingOutTime = 2; // s; band and equaliser decay by 60 dB in a tenth of this time
constexpr double kDcCutoffHz = 2;  // the elliptic band-pass alone passes a hundredth of a constant
                                   // signal
constexpr double kSilenceThreshold = 1e-30;

/// A pair of poles and a pair of zeros of the analogue low-pass, normalised to a -3 dB point at 1.
struct Pair {
  double zero, pole_squared, pole_over_q;
};
constexpr Pair kSixth[] = {{1.4894312106482, 0.96546939876, 0.155186248211},
                           {1.9262703869911, 0.689835926456, 0.525613874264},
                           {4.9655791861224, 0.308269742009, 0.904587973613}};
constexpr Pair kFourth[] = {{1.7623797270747, 0.939222969904, 0.36237114833},
                            {4.0303539170657, 0.543396254387, 1.1481767612}};

/// A biquad section, transposed direct form II.
template <class Section, class State, class Signal>
Signal filtered(const Section& c, State& state, Signal x) noexcept {
  const Signal y = c.b0 * x + state.s1;
  state.s1 = c.b1 * x - c.a1 * y + state.s2;
  state.s2 = c.b2 * x - c.a2 * y;
  return y;
}

} // namespace

void HapticBand::prepare(double sample_rate) noexcept {
  const auto bilinear = [sample_rate](double edge_hz, double n2, double n0, double d2, double d1,
                                      double d0) {
    const double k = math::tan(pi * std::min(edge_hz / sample_rate, 0.45)), k2 = k * k;
    const double norm = 1 / (d2 + d1 * k + d0 * k2);
    return Section{(n2 + n0 * k2) * norm, 2 * (n0 * k2 - n2) * norm, (n2 + n0 * k2) * norm,
                   2 * (d0 * k2 - d2) * norm, (d2 - d1 * k + d0 * k2) * norm};
  };
  dc_coefficient_ = 1 - math::exp(-2 * pi * kDcCutoffHz / sample_rate);
  std::size_t i = 0;
  for (const Pair& p : kFourth) // low-pass to high-pass: s becomes 1/s
    section_[i++] = bilinear(kLowEdgeHz, p.pole_squared, p.pole_squared / (p.zero * p.zero),
                             p.pole_squared, p.pole_over_q, 1);
  for (const Pair& p : kSixth)
    section_[i++] = bilinear(kHighEdgeHz, p.pole_squared / (p.zero * p.zero), p.pole_squared, 1,
                             p.pole_over_q, p.pole_squared);
}

HeelBall HapticBand::next(HeelBall x) noexcept {
  dc_ += dc_coefficient_ * (x - dc_);
  x -= dc_;
  for (std::size_t i = 0; i < kSections; ++i)
    x = filtered(section_[i], state_[i], x);
  // Sets decayed states to 0 before they become denormal.
  for (std::size_t side = 0; side < 2; ++side)
    if (std::abs(x[side]) < kSilenceThreshold && std::abs(state_[0].s1[side]) < kSilenceThreshold &&
        std::abs(dc_[side]) < kSilenceThreshold) {
      dc_[side] = 0;
      for (State& state : state_)
        state.s1[side] = state.s2[side] = 0;
    }
  return x;
}

void ActuatorEqualiser::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  compute_coefficients();
}

bool ActuatorEqualiser::set(std::span<const double> table) noexcept {
  const std::size_t count = table.size() / 2;
  if (table.size() % 2 || count > kMaxFilters)
    return false;
  for (std::size_t i = 0; i < count; ++i) {
    const double f = table[2 * i], g = table[2 * i + 1];
    if (!(f >= 20 && f <= 2000 && std::abs(g) <= 24) || (i > 0 && !(f > table[2 * i - 2])))
      return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    frequency_hz_[i] = table[2 * i];
    target_db_[i] = table[2 * i + 1];
  }
  count_ = count;
  compute_coefficients();
  return true;
}

void ActuatorEqualiser::compute_coefficients() noexcept {
  constexpr double kQuality = 1.4;
  constexpr int kRounds = 40;
  std::array<double, kMaxFilters> gain_db = target_db_;
  const auto peaking = [&](std::size_t i) { // Bristow-Johnson's peaking filter
    const double w = 2 * pi * std::min(frequency_hz_[i] / sample_rate_, 0.45);
    const double a = math::exp10(gain_db[i] / 40), alpha = math::sin(w) / (2 * kQuality);
    const double norm = 1 / (1 + alpha / a);
    section_[i] = {(1 + alpha * a) * norm, -2 * math::cos(w) * norm, (1 - alpha * a) * norm,
                   -2 * math::cos(w) * norm, (1 - alpha / a) * norm};
  };
  for (std::size_t i = 0; i < count_; ++i)
    peaking(i);
  // Neighbouring filters overlap, so each gain is corrected by the error of the whole response at
  // its frequency.
  for (int round = 0; round < kRounds; ++round) {
    std::array<double, kMaxFilters> missing{};
    for (std::size_t i = 0; i < count_; ++i) {
      const auto z = math::polar(1.0, -2 * pi * frequency_hz_[i] / sample_rate_);
      double db = 0;
      for (std::size_t k = 0; k < count_; ++k) {
        const Section& c = section_[k];
        db += 20 * math::log10(
                       math::abs((c.b0 + z * (c.b1 + z * c.b2)) / (1.0 + z * (c.a1 + z * c.a2))));
      }
      missing[i] = target_db_[i] - db;
    }
    for (std::size_t i = 0; i < count_; ++i) {
      gain_db[i] = std::clamp(gain_db[i] + 0.5 * missing[i], -40.0, 40.0);
      peaking(i);
    }
  }
}

double ActuatorEqualiser::next(double x) noexcept {
  for (std::size_t i = 0; i < count_; ++i)
    x = filtered(section_[i], state_[i], x);
  return x;
}

void PeakLimit::prepare(double sample_rate) noexcept {
  recover_ = 1 - math::exp(-1 / (0.05 * sample_rate));
}

double PeakLimit::next(double x, double limit) noexcept {
  gain_ += recover_ * (1 - gain_);
  const double size = std::abs(x);
  if (size * gain_ > limit)
    gain_ = limit / size;
  return std::clamp(x * gain_, -limit, limit);
}

void ActuatorSignals::Channel::reset() noexcept {
  equaliser.reset();
  limit.reset();
  std::fill(line.begin(), line.end(), 0.0);
}

double ActuatorSignals::Channel::next(double x, std::size_t at, std::size_t delay) noexcept {
  x = equaliser.next(x);
  if (delay == 0 || line.empty())
    return x;
  line[at] = x;
  return line[at >= delay ? at - delay : at + line.size() - delay];
}

void ActuatorSignals::prepare(double sample_rate) {
  const bool changed = sample_rate != sample_rate_ || channel_[0].line.empty();
  sample_rate_ = sample_rate;
  ring_out_samples_ = static_cast<std::size_t>((kRingOutTime + kMaxDelay) * sample_rate);
  band_.prepare(sample_rate);
  for (Channel& channel : channel_) {
    channel.equaliser.prepare(sample_rate);
    channel.limit.prepare(sample_rate);
    if (changed)
      channel.line.assign(static_cast<std::size_t>(kMaxDelay * sample_rate) + 2, 0.0);
  }
  if (changed)
    write_index_ = 0;
  set(settings_);
}

void ActuatorSignals::set(const Settings& settings) noexcept {
  settings_ = settings;
  settings_.sensitivity_g = std::max(settings.sensitivity_g, 1e-3);
  settings_.common = std::clamp(settings.common, 0.0, 1.0);
  limit_ = settings_.limit_g / settings_.sensitivity_g;
  const auto delay = static_cast<std::size_t>(
      std::lround(std::clamp(settings.delay_s, 0.0, kMaxDelay) * sample_rate_));
  if (delay_ == 0 && delay > 0) // the delay lines are not written while the delay is 0
    for (Channel& channel : channel_)
      std::fill(channel.line.begin(), channel.line.end(), 0.0);
  delay_ = delay;
}

bool ActuatorSignals::equalise(std::span<const double> table) noexcept {
  return channel_[0].equaliser.set(table) && channel_[1].equaliser.set(table);
}

void ActuatorSignals::reset() noexcept {
  band_.reset();
  for (Channel& channel : channel_)
    channel.reset();
  last_heel_n_ = last_total_n_ = 1;
}

ActuatorSignals::Pair ActuatorSignals::next(double heel_vibration, double ball_vibration,
                                            double heel_n, double ball_n) noexcept {
  const double total = heel_n + ball_n;
  if (total > 0) {
    last_heel_n_ = heel_n;
    last_total_n_ = total;
  }
  if (heel_vibration != 0 || ball_vibration != 0) {
    silent_samples_ = 0;
  } else if (++silent_samples_ > ring_out_samples_) {
    silent_samples_ = ring_out_samples_;
    if (at_rest_)
      return {};
    at_rest_ = true;
    const double last_heel_n = last_heel_n_, last_total_n = last_total_n_;
    reset();
    last_heel_n_ = last_heel_n;
    last_total_n_ = last_total_n;
    return {};
  }
  at_rest_ = false;
  const double separate_gain = settings_.gain * (1 - settings_.common);
  HeelBall moved{separate_gain * heel_vibration, separate_gain * ball_vibration};
  if (settings_.common > 0) {
    const double common = settings_.gain * settings_.common * (heel_vibration + ball_vibration);
    const double share = std::clamp(last_heel_n_ / last_total_n_, 0.0, 1.0);
    moved += HeelBall{common * share, common * (1 - share)};
  }
  moved = band_.next(moved);
  const double heel = channel_[0].next(moved[0], write_index_, delay_);
  const double ball = channel_[1].next(moved[1], write_index_, delay_);
  if (!channel_[0].line.empty() && ++write_index_ == channel_[0].line.size())
    write_index_ = 0;
  return {channel_[0].limit.next(heel, limit_), channel_[1].limit.next(ball, limit_)};
}

} // namespace tactus::footstep
