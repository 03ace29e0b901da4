#include "core/reed/playability/gradient.hpp"

#include "core/dsp/soft_clip.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
ReedGradient::ReedGradient(simd::VectorSet widest) : ensemble_(make_reed_ensemble(widest)) {
  ensemble_->set_active_lanes(GradientStencil::kPoints);
  guidance_.set(guidance_settings_);
}

void ReedGradient::prepare(double sample_rate) {
  sample_rate_ = sample_rate;
  ensemble_->prepare(sample_rate);
}

void ReedGradient::set(const Parameters& parameters) noexcept {
  parameters_ = clamped(parameters);
  ensemble_->set(parameters_);
  ++revision_;
}

void ReedGradient::set(const PlayabilityParameters& estimator) noexcept {
  ensemble_->set(estimator);
}

void ReedGradient::set_range(const ControlRange& range) noexcept {
  range_ = range;
  frequency_due_ = true;
  ++revision_;
}

void ReedGradient::set_mode(Mode mode) noexcept {
  if (mode == mode_)
    return;
  mode_ = mode;
  guidance_.reset(force_);
  smoother_.reset(force_);
}

void ReedGradient::set_ceiling(double ceiling_n) noexcept {
  guidance_settings_.ceiling_n = ceiling_n;
  guidance_.set(guidance_settings_);
}

void ReedGradient::release_force() noexcept {
  force_ = {};
  guidance_.reset();
  smoother_.reset();
}

void ReedGradient::reset() noexcept {
  ensemble_->reset();
  targets_set_ = force_due_ = false;
  phase_ = 0;
  release_force();
}

void ReedGradient::move(double y, double z, double bore_frequency) noexcept {
  if (std::isfinite(y))
    y_ = y;
  if (std::isfinite(bore_frequency))
    bore_frequency_ = std::clamp(bore_frequency, 0.0, BoreDesign::kHighestFrequency);
  if (std::isfinite(z) && z != z_) {
    z_ = z;
    frequency_due_ = true;
  }
  update_targets();
  if (force_due_)
    update_force();
  force_due_ = !force_due_;
}

/// Starts the ramps of the pressures from the last targets to those of the hand's new position.
void ReedGradient::update_targets() noexcept {
  const GradientStencil stencil(y_, z_, delta_);
  const bool unchanged =
      targets_set_ && !frequency_due_ && stencil.y == stencil_.y && stencil.z == stencil_.z;
  if (unchanged && hand_at_rest_)
    return;
  if (stencil.z != stencil_.z || frequency_due_) {
    // The stencil has three values of z; the unused lanes follow the hand.
    reed_frequency_.fill(range_.frequency(stencil.z[0]));
    reed_frequency_[3] = range_.frequency(stencil.z[3]);
    reed_frequency_[4] = range_.frequency(stencil.z[4]);
  }
  hand_at_rest_ = unchanged;
  stencil_ = stencil;
  for (std::size_t lane = 0; lane < target_.size(); ++lane) {
    const double previous = target_[lane];
    target_[lane] = range_.pressure(stencil.y[lane < stencil.y.size() ? lane : 0]);
    const double start = targets_set_ ? previous : target_[lane];
    mouth_.start[lane] = start;
    mouth_.slope[lane] = (target_[lane] - start) / static_cast<double>(kHandPeriod);
  }
  frequency_due_ = false;
  targets_set_ = true;
}

/// Computes gradient and force, which hold until the reading after next.
void ReedGradient::update_force() noexcept {
  gradient_ = compute_gradient();
  const double elapsed_s = static_cast<double>(kForcePeriod) / sample_rate_;
  if (mode_ == Mode::kGuide) {
    force_ = guide_ != nullptr ? guidance_.advance(guide_->distance_field, stencil_.y[0],
                                                   stencil_.z[0], playability(), elapsed_s)
                               : guidance_.fade(elapsed_s);
  } else {
    force_ = smoother_.advance(
        gradient_force(gradient_, force_gain_n_, guidance_settings_.ceiling_n), elapsed_s);
  }
}

void ReedGradient::process(std::span<double> sound) noexcept {
  mouth_.first = phase_;
  ensemble_->process(mouth_, reed_frequency_, bore_frequency_, sound.size(), sound);
  for (double& x : sound)
    x = soft_clip(parameters_.gain * x);
  phase_ = (phase_ + sound.size()) % kHandPeriod;
}

Gradient ReedGradient::compute_gradient() const noexcept {
  const double y = stencil_.y[0], z = stencil_.z[0];
  if (mode_ == Mode::kReed) {
    std::array<double, GradientStencil::kPoints> f{};
    for (std::size_t lane = 0; lane < f.size(); ++lane)
      f[lane] = ensemble_->playability(lane);
    return stencil_.gradient(f);
  }
  if (guide_ == nullptr)
    return {};
  if (mode_ == Mode::kGrowth)
    return guide_->height.gradient(y, z);
  const Gradient slope = guide_->distance_field.slope(y, z);
  return {-slope.y, -slope.z};
}

PlaneSettings ReedGradient::plane() const noexcept {
  return {embouchure_for(parameters_, bore_frequency_, ensemble_->length()), range_, revision_};
}

} // namespace tactus::reed
