#include "core/reed/playability/guidance.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

double smoothing_gain(double elapsed_s, double time_constant_s) noexcept {
  return time_constant_s > 0 ? 1 - math::exp(-elapsed_s / time_constant_s) : 1;
}

double clamp_to_unit(double x) noexcept { return std::clamp(x, 0.0, 1.0); }

} // namespace

void ForceSmoother::set(double time_constant_s, double slew_n_per_s) noexcept {
  time_constant_s_ = time_constant_s;
  slew_n_per_s_ = slew_n_per_s;
  elapsed_s_ = 0;
}

PlaneForce ForceSmoother::advance(const PlaneForce& target, double elapsed_s) noexcept {
  if (elapsed_s != elapsed_s_) {
    elapsed_s_ = elapsed_s;
    smoothing_gain_ = smoothing_gain(elapsed_s, time_constant_s_);
  }
  const double share = smoothing_gain_, max_change = slew_n_per_s_ * elapsed_s;
  const auto follow = [&](double from, double to) {
    constexpr double kNegligible = 1e-12; // N; set to 0, since subnormal numbers are slow
    const double next =
        from + std::clamp(share * ((std::isfinite(to) ? to : 0) - from), -max_change, max_change);
    return std::abs(next) < kNegligible ? 0 : next;
  };
  return force_ = {follow(force_.y, target.y), follow(force_.z, target.z)};
}

PlaneForce gradient_force(const Gradient& gradient, double gain_n, double ceiling_n) noexcept {
  if (!(ceiling_n > 0))
    return {};
  return {ceiling_n * math::tanh(gain_n * gradient.y / ceiling_n),
          ceiling_n * math::tanh(gain_n * gradient.z / ceiling_n)};
}

void Guidance::set(const Settings& settings) noexcept {
  settings_ = settings;
  smoother_.set(settings.smoothing_s, settings.slew_n_per_s);
}

void Guidance::reset(const PlaneForce& force) noexcept {
  smoother_.reset(force);
  started_ = false;
}

PlaneForce Guidance::fade(double elapsed_s) noexcept {
  started_ = false;
  return smoother_.advance({}, elapsed_s);
}

PlaneForce Guidance::advance(const GuidanceField& field, double y, double z, double playability,
                             double elapsed_s) noexcept {
  if (!std::isfinite(y) || !std::isfinite(z) || field.empty())
    return fade(elapsed_s);
  if (!started_) {
    started_ = true;
    y_ = y;
    z_ = z;
    velocity_y_ = velocity_z_ = 0;
  }
  const double share = smoothing_gain(elapsed_s, settings_.velocity_s);
  velocity_y_ += share * ((y - y_) / elapsed_s - velocity_y_);
  velocity_z_ += share * ((z - z_) / elapsed_s - velocity_z_);
  y_ = y;
  z_ = z;

  const double distance = field.distance(y, z);
  Gradient slope = field.slope(y, z);
  // Differences along two axes can make a slope a little longer than 1 where a border has a corner.
  const double slope_norm = std::max(1.0, math::hypot(slope.y, slope.z));
  slope = {slope.y / slope_norm, slope.z / slope_norm};
  const double predicted_distance =
      distance + settings_.anticipation_s * (velocity_y_ * slope.y + velocity_z_ * slope.z);
  const double wall = clamp_to_unit(1 + predicted_distance / settings_.margin);
  const double depth_pull = clamp_to_unit(2 + distance / settings_.margin);
  const double silence_weight =
      std::isfinite(playability) ? clamp_to_unit((0.4 - playability) / 0.2) : 0;
  const double pull = settings_.ceiling_n * std::max(wall, silence_weight * depth_pull);
  const double flatness = 1 - std::min(1.0, slope.y * slope.y + slope.z * slope.z);
  const double brake = settings_.ceiling_n * settings_.anticipation_s / settings_.margin *
                       flatness *
                       std::min(clamp_to_unit(1 + distance / settings_.margin),
                                clamp_to_unit(1 - 2 * distance / settings_.margin));
  PlaneForce force{-pull * slope.y - brake * velocity_y_, -pull * slope.z - brake * velocity_z_};
  const double magnitude = math::hypot(force.y, force.z);
  if (magnitude > settings_.ceiling_n) {
    force.y *= settings_.ceiling_n / magnitude;
    force.z *= settings_.ceiling_n / magnitude;
  }
  return smoother_.advance(force, elapsed_s);
}

} // namespace tactus::reed
