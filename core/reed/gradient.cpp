#include "core/reed/gradient.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

/// As Instrument's: y = x to 1/2, then sign(x) (1 - 1/(4|x|)).
double soft_clip(double x) noexcept {
  const double size = std::abs(x);
  return size <= 0.5 ? x : std::copysign(1 - 0.25 / size, x);
}

} // namespace

ReedGradient::ReedGradient(Instructions instructions)
    : ensemble_(make_reed_ensemble(instructions)) {
  map_.prepare(kGrowthNodes, kGrowthNodes);
}

void ReedGradient::prepare(double sample_rate) { ensemble_->prepare(sample_rate); }

void ReedGradient::set(const Parameters& parameters) noexcept {
  parameters_ = clamped(parameters);
  ensemble_->set(parameters_);
  stale_ = true;
}

void ReedGradient::set(const PlayabilityParameters& judge) noexcept { ensemble_->set(judge); }

void ReedGradient::set_range(const ControlRange& range) noexcept {
  range_ = range;
  retune_ = true;
  stale_ = true;
}

void ReedGradient::reset() noexcept {
  ensemble_->reset();
  aimed_ = false;
  phase_ = 0;
}

void ReedGradient::move(double y, double z, double bore_frequency) noexcept {
  if (std::isfinite(y))
    y_ = y;
  if (std::isfinite(bore_frequency))
    bore_frequency_ = bore_frequency;
  if (std::isfinite(z) && z != z_) {
    z_ = z;
    retune_ = true;
  }
  aim();
}

/// Pressures are on their way from the last targets to those of the hand's new place.
void ReedGradient::aim() noexcept {
  const GradientStencil stencil(y_, z_, delta_);
  const bool still = aimed_ && !retune_ && stencil.y == stencil_.y && stencil.z == stencil_.z;
  if (still && resting_)
    return;
  if (stencil.z != stencil_.z || retune_) {
    // Three different places along z; the lanes beyond the stencil do as the hand does.
    reed_frequency_.fill(range_.frequency(stencil.z[0]));
    reed_frequency_[3] = range_.frequency(stencil.z[3]);
    reed_frequency_[4] = range_.frequency(stencil.z[4]);
  }
  resting_ = still;
  stencil_ = stencil;
  for (std::size_t lane = 0; lane < target_.size(); ++lane) {
    const double before = target_[lane];
    target_[lane] = range_.pressure(stencil.y[lane < stencil.y.size() ? lane : 0]);
    const double start = aimed_ ? before : target_[lane];
    mouth_.start[lane] = start;
    mouth_.slope[lane] = (target_[lane] - start) / static_cast<double>(kHold);
  }
  retune_ = false;
  aimed_ = true;
}

void ReedGradient::process(std::span<double> sound) noexcept {
  mouth_.first = phase_;
  ensemble_->process(mouth_, reed_frequency_, bore_frequency_, sound.size(), sound);
  for (double& x : sound)
    x = soft_clip(parameters_.gain * x);
  phase_ = (phase_ + sound.size()) % kHold;
}

Gradient ReedGradient::gradient() const noexcept {
  if (mode_ == Mode::kGrowth)
    return map_.height().gradient(stencil_.y[0], stencil_.z[0]);
  std::array<double, GradientStencil::kPoints> f{};
  for (std::size_t lane = 0; lane < f.size(); ++lane)
    f[lane] = ensemble_->playability(lane);
  return stencil_.gradient(f);
}

bool ReedGradient::map_lags() const noexcept {
  return map_.working() || stale_ || std::abs(ensemble_->length() / map_length_ - 1) > 1e-3;
}

void ReedGradient::advance_map(std::size_t nodes) noexcept {
  if (stale_ || !(std::abs(ensemble_->length() / map_length_ - 1) <= 1e-3)) {
    stale_ = false;
    map_length_ = ensemble_->length();
    map_.begin(parameters_, map_length_, range_);
  }
  map_.advance(nodes);
}

} // namespace tactus::reed
