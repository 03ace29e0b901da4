#include "core/reed/playability/gradient.hpp"

#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/soft_clip.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
ReedGradient::ReedGradient(Instructions instructions)
    : ensemble_(make_reed_ensemble(instructions)) {
  ensemble_->judge_first(GradientStencil::kPoints);
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

void ReedGradient::set(const PlayabilityParameters& judge) noexcept { ensemble_->set(judge); }

void ReedGradient::set_range(const ControlRange& range) noexcept {
  range_ = range;
  retune_ = true;
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

void ReedGradient::let_go() noexcept {
  force_ = {};
  guidance_.reset();
  smoother_.reset();
}

void ReedGradient::reset() noexcept {
  ensemble_->reset();
  aimed_ = pushing_ = false;
  phase_ = 0;
  let_go();
}

void ReedGradient::move(double y, double z, double bore_frequency) noexcept {
  if (std::isfinite(y))
    y_ = y;
  if (std::isfinite(bore_frequency))
    bore_frequency_ = std::clamp(bore_frequency, 0.0, BoreDesign::kHighestFrequency);
  if (std::isfinite(z) && z != z_) {
    z_ = z;
    retune_ = true;
  }
  aim();
  if (pushing_)
    push();
  pushing_ = !pushing_;
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

/// Gradient and force for the next two readings of the hand.
void ReedGradient::push() noexcept {
  gradient_ = find_gradient();
  const double elapsed_s = static_cast<double>(kForceHold) / sample_rate_;
  if (mode_ == Mode::kGuide) {
    force_ = guide_ != nullptr ? guidance_.advance(guide_->way, stencil_.y[0], stencil_.z[0],
                                                   playability(), elapsed_s)
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
  phase_ = (phase_ + sound.size()) % kHold;
}

Gradient ReedGradient::find_gradient() const noexcept {
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
  const Gradient away = guide_->way.slope(y, z);
  return {-away.y, -away.z};
}

PlaneSettings ReedGradient::plane() const noexcept {
  return {embouchure_for(parameters_, bore_frequency_, ensemble_->length()), range_, revision_};
}

} // namespace tactus::reed
