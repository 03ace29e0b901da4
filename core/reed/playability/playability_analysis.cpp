#include "core/reed/playability/playability_analysis.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tactus::reed {
namespace {

constexpr double kFrameTime = 4096.0 / 48000;
constexpr double kThreshold = 0.1;
constexpr std::size_t kShortestLag = 2;

} // namespace

void PeriodicityAnalysis::prepare(double sample_rate, std::shared_ptr<RealTransform> transform) {
  if (sample_rate == sample_rate_ && transform == transform_)
    return;
  sample_rate_ = sample_rate;
  transform_ = std::move(transform);
  const auto power = std::clamp(std::lround(math::log2(kFrameTime * sample_rate)), 6L, 20L);
  const std::size_t size = std::size_t{1} << power;
  if (transform_)
    transform_->prepare(size);
  ring_.assign(size, 0);
  frame_.assign(size, 0);
  work_.assign(size, 0);
  difference_.assign(size / 2, 0);
  spectrum_.assign(size / 2 + 1, {});
  half_frame_spectrum_.assign(size / 2 + 1, {});
  reset();
}

void PeriodicityAnalysis::reset() noexcept {
  write_ = filled_ = samples_since_frame_ = 0;
  result_ = {};
}

bool PeriodicityAnalysis::tick(double sample) noexcept {
  if (!transform_)
    return false;
  ring_[write_] = std::abs(sample) < 1e6 ? sample : 0;
  write_ = (write_ + 1) % ring_.size();
  filled_ = std::min(filled_ + 1, ring_.size());
  if (++samples_since_frame_ < ring_.size() / 4)
    return false;
  samples_since_frame_ = 0;
  if (filled_ < ring_.size())
    return false;
  analyse();
  return true;
}

/// difference_[tau] = d(tau) = energy of the first half + energy of the shifted half - 2 r(tau),
/// r(tau) = sum_{j < N/2} x_j x_{j+tau}: no lag below N/2 wraps around in N points.
void PeriodicityAnalysis::difference() noexcept {
  const std::size_t half = frame_.size() / 2;
  std::copy_n(frame_.begin(), half, work_.begin());
  std::fill(work_.begin() + static_cast<std::ptrdiff_t>(half), work_.end(), 0.0);
  transform_->forward(frame_, spectrum_);
  transform_->forward(work_, half_frame_spectrum_);
  for (std::size_t k = 0; k < spectrum_.size(); ++k)
    half_frame_spectrum_[k] = spectrum_[k] * math::conj(half_frame_spectrum_[k]);
  transform_->inverse(half_frame_spectrum_, work_);
  double first = 0;
  for (std::size_t j = 0; j < half; ++j)
    first += frame_[j] * frame_[j];
  double shifted = first;
  const double scale = 2 / static_cast<double>(frame_.size());
  for (std::size_t lag = 0; lag < half; ++lag) {
    difference_[lag] = std::max(0.0, first + shifted - scale * work_[lag]);
    shifted += frame_[lag + half] * frame_[lag + half] - frame_[lag] * frame_[lag];
  }
}

void PeriodicityAnalysis::analyse() noexcept {
  const std::size_t size = ring_.size(), half = size / 2;
  double mean = 0;
  for (std::size_t j = 0; j < size; ++j) {
    frame_[j] = ring_[(write_ + j) % size];
    mean += frame_[j];
  }
  mean /= static_cast<double>(size);
  double energy = 0;
  for (double& x : frame_) {
    x -= mean;
    energy += x * x;
  }
  result_ = {};
  if (!(energy > 1e-30))
    return;

  difference();
  double sum = 0;
  difference_[0] = 1;
  for (std::size_t lag = 1; lag < half; ++lag) {
    sum += difference_[lag];
    difference_[lag] = sum > 0 ? difference_[lag] * static_cast<double>(lag) / sum : 1;
  }
  std::size_t best = kShortestLag;
  for (std::size_t lag = kShortestLag; lag + 1 < half; ++lag) {
    if (difference_[lag] < kThreshold) {
      best = lag;
      while (best + 2 < half && difference_[best + 1] < difference_[best])
        ++best;
      break;
    }
    if (difference_[lag] < difference_[best])
      best = lag;
  }
  const double left = difference_[best - 1], centre = difference_[best],
               right = difference_[best + 1];
  const double curvature = left - 2 * centre + right;
  const double shift = curvature > 0 ? std::clamp(0.5 * (left - right) / curvature, -1.0, 1.0) : 0;
  const double minimum = std::clamp(centre - 0.25 * (left - right) * shift, 0.0, 1.0);
  // If no lag resembles the frame, as when a displacement decays, there is no period.
  if (minimum < 1)
    result_.frequency_hz = sample_rate_ / (static_cast<double>(best) + shift);
  result_.periodicity = 1 - minimum;
  const double harmonics_to_noise = std::max(result_.periodicity, 1e-9) / std::max(minimum, 1e-9);
  result_.harmonicity_db = 10 * math::log10(harmonics_to_noise);

  for (std::size_t j = 0; j < size; ++j)
    work_[j] = frame_[j] * (0.5 - 0.5 * math::cos(2 * std::numbers::pi * static_cast<double>(j) /
                                                  static_cast<double>(size)));
  transform_->forward(work_, spectrum_);
  double power = 0, moment = 0;
  for (std::size_t k = 1; k < spectrum_.size(); ++k) {
    const double p = math::norm(spectrum_[k]);
    power += p;
    moment += p * static_cast<double>(k);
  }
  if (power > 0)
    result_.centroid_hz = moment / power * sample_rate_ / static_cast<double>(size);
}

} // namespace tactus::reed
