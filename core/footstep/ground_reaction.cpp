#include "core/footstep/ground_reaction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr double kPi = std::numbers::pi;

struct Row {
  double speed, first, first_at, valley, valley_at, second, second_at, duty;
};
constexpr Row kWalk[] = {{0.8, 1.02, 0.24, 0.86, 0.48, 1.02, 0.76, 0.66},
                         {1.1, 1.06, 0.23, 0.80, 0.48, 1.06, 0.76, 0.64},
                         {1.4, 1.13, 0.22, 0.72, 0.48, 1.10, 0.77, 0.62},
                         {1.8, 1.30, 0.20, 0.58, 0.46, 1.17, 0.78, 0.60}};

Row walking_at(double speed) noexcept {
  std::size_t i = 0;
  while (i < 2 && speed > kWalk[i + 1].speed)
    ++i;
  const Row &a = kWalk[i], &b = kWalk[i + 1];
  const double t = std::clamp((speed - a.speed) / (b.speed - a.speed), 0.0, 1.0);
  const auto mix = [t](double p, double q) { return p + t * (q - p); };
  return {speed,
          mix(a.first, b.first),
          mix(a.first_at, b.first_at),
          mix(a.valley, b.valley),
          mix(a.valley_at, b.valley_at),
          mix(a.second, b.second),
          mix(a.second_at, b.second_at),
          mix(a.duty, b.duty)};
}

/// From a at 0 to b at 1, level at both ends.
double half_cosine(double a, double b, double u) noexcept {
  return a + (b - a) * 0.5 * (1 - std::cos(kPi * u));
}

/// Passing of a hard heel: sin^2 of this length, as wide at half its height as a bell curve of 7 ms
/// standard deviation.
constexpr double kTransientLength = 0.033; // s
constexpr double kHardestTransient = 0.6;  // weights

} // namespace

double GroundReaction::heel_share(double x) noexcept {
  return 1 / (1 + std::exp((x - 0.46) / 0.07));
}

void GroundReaction::set(const Walker& walker) noexcept {
  weight_n_ = std::clamp(walker.weight_n, 0.0, 1e5);
  run_ = walker.run;
  transient_ = kHardestTransient * std::clamp(walker.shoe, 0.0, 1.0);
  if (run_) {
    const double speed = std::clamp(walker.speed_m_per_s, 1.5, 8.0);
    stance_s_ = std::clamp(0.32 - 0.02 * speed, 0.16, 0.29);
    stride_s_ = 2 * 60 / (150 + 8 * speed); // steps a minute
    transient_width_ = kTransientLength / stance_s_;
    const double mean = stride_s_ / (2 * stance_s_);
    peak_ = 0.5 * kPi * (mean - transient_ * transient_width_ / 2);
    return;
  }
  const double speed = std::clamp(walker.speed_m_per_s, 0.3, 2.5);
  const Row row = walking_at(speed);
  stride_s_ = 2 * 60 / std::clamp(100 + 27.8 * (speed - 1), 70.0, 145.0);
  stance_s_ = row.duty * stride_s_;
  transient_width_ = kTransientLength / stance_s_;
  first_ = row.first;
  first_at_ = row.first_at;
  valley_ = row.valley;
  valley_at_ = row.valley_at;
  second_ = row.second;
  second_at_ = row.second_at;
  const double inner = (valley_at_ - first_at_) * 0.5 * (first_ + valley_) +
                       (second_at_ - valley_at_) * 0.5 * (valley_ + second_);
  const double outer = first_at_ * first_ + (1 - second_at_) * second_;
  // The flanks' mean height: 2 / pi for a sine, 1/2 for its square.
  const double height = (1 / (2 * row.duty) - inner - transient_ * transient_width_ / 2) / outer;
  sine_share_ = std::clamp((height - 0.5) / (2 / kPi - 0.5), 0.0, 1.0);
}

double GroundReaction::force(double x) const noexcept {
  if (!(x > 0 && x < 1))
    return 0;
  double weights = 0;
  if (run_) {
    weights = peak_ * std::sin(kPi * x);
  } else if (x < first_at_ || x > second_at_) {
    const double u = x < first_at_ ? x / first_at_ : (1 - x) / (1 - second_at_);
    const double sine = std::sin(0.5 * kPi * u);
    weights = (x < first_at_ ? first_ : second_) * sine * (sine_share_ + (1 - sine_share_) * sine);
  } else if (x < valley_at_) {
    weights = half_cosine(first_, valley_, (x - first_at_) / (valley_at_ - first_at_));
  } else {
    weights = half_cosine(valley_, second_, (x - valley_at_) / (second_at_ - valley_at_));
  }
  if (x < transient_width_) {
    const double sine = std::sin(kPi * x / transient_width_);
    weights += transient_ * sine * sine;
  }
  return weight_n_ * weights;
}

} // namespace tactus::footstep
