#pragma once

#include "core/reed/playability/gradient_ensemble.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/guidance.hpp"
#include "core/reed/playability/plane_guide.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// The paper's haptic gradient from one object, and the force on the hand that follows from it.
/// Five reeds at and around the hand's place in the plane, each judged, and then
///   reed     the central differences of their playability;
///   growth   the slope of a GrowthMap at the hand;
///   guide    the way to where a note grows (GuidanceField), and Guidance's force.
/// The force of the first two is gradient_force() through a ForceSmoother of 30 ms and 20 N/s.
///
/// The hand's place is read every 32 samples; then pressures set out for the new place in straight
/// lines, reed frequencies at the reeds' own pace. The force advances at every second reading, from
/// the second on: in the middle of a host's block of 64.
class ReedGradient {
public:
  enum class Mode { kReed, kGrowth, kGuide };
  static constexpr std::size_t kGrowthNodes = 41; // along y and along z

  explicit ReedGradient(Instructions instructions = best_instructions());

  /// Allocates; keeps the physical state when the rate is the same.
  void prepare(double sample_rate);
  void set(const Parameters& parameters) noexcept;
  void set(const PlayabilityParameters& estimator) noexcept;
  void set_range(const ControlRange& range) noexcept;
  /// 0 < delta <= 0.25, of the plane's side.
  void set_delta(double delta) noexcept { delta_ = delta; }
  /// The force goes on from what it was.
  void set_mode(Mode mode) noexcept;
  /// F_max >= 0, N: of each axis in modes reed and growth, of the whole vector in mode guide.
  void set_ceiling(double ceiling_n) noexcept;
  /// Force for a slope of 1 in modes reed and growth, N.
  void set_force_gain(double gain_n) noexcept { force_gain_n_ = gain_n; }
  void reset() noexcept;

  /// The hand's place at one sample; what is not finite is ignored, the rest clamped to [0, 1].
  /// To be called before process() of that sample; see takes_hand().
  void move(double y, double z, double bore_frequency) noexcept;
  /// Samples until move() is read next; 0: now.
  [[nodiscard]] std::size_t samples_until_hand() const noexcept {
    return phase_ == 0 ? 0 : kHandPeriod - phase_;
  }
  /// Advances sound.size() samples, at most those until the next reading of the hand. sound is that
  /// of greed~: gain times the pressure at 1 m, linear to 0.5, within +-1.
  void process(std::span<double> sound) noexcept;

  /// f_p of the reed at the hand.
  [[nodiscard]] double playability() const noexcept { return ensemble_->playability(0); }
  /// Towards where it plays better, for one unit of y and of z, since the last step of the force.
  /// In mode guide the slope of the distance, turned round: of length 1, or 0 where there is no
  /// way. 0 without a guide.
  [[nodiscard]] const Gradient& gradient() const noexcept { return gradient_; }
  /// On the hand, N, towards where it plays better; since the last step of the force.
  [[nodiscard]] const PlaneForce& force() const noexcept { return force_; }
  /// No force, as long as the hand is not read again.
  void release_force() noexcept;

  /// What a guide for the present instrument, note and range depends on.
  [[nodiscard]] PlaneSettings plane() const noexcept;
  /// Of modes growth and guide; must live as long as it is set. Null: no slope and no force.
  void set_guide(const PlaneGuide* guide) noexcept { guide_ = guide; }

  [[nodiscard]] const ReedEnsemble& ensemble() const noexcept { return *ensemble_; }
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] const ControlRange& range() const noexcept { return range_; }
  [[nodiscard]] double delta() const noexcept { return delta_; }
  [[nodiscard]] Mode mode() const noexcept { return mode_; }
  [[nodiscard]] double ceiling() const noexcept { return guidance_settings_.ceiling_n; }
  [[nodiscard]] double force_gain() const noexcept { return force_gain_n_; }
  static constexpr std::size_t kHandPeriod = 32; // samples between readings of the hand
  static constexpr std::size_t kForcePeriod = 2 * kHandPeriod; // and between steps of the force

private:
  void update_targets() noexcept;
  void update_force() noexcept;
  [[nodiscard]] Gradient compute_gradient() const noexcept;

  std::unique_ptr<ReedEnsemble> ensemble_;
  Parameters parameters_{};
  ControlRange range_{};
  double delta_ = 0.01;
  Mode mode_ = Mode::kReed;
  double y_ = 0, z_ = 0, bore_frequency_ = 0;
  GradientStencil stencil_{0, 0, 0.01};
  ReedEnsemble::Pressure mouth_{};
  ReedEnsemble::PerLane target_{}, reed_frequency_{};
  std::size_t phase_ = 0;
  bool targets_set_ = false, frequency_due_ = true, force_due_ = false;
  bool hand_at_rest_ = false; // the hand has not moved since the last reading, nor do the pressures
  unsigned revision_ = 0;
  const PlaneGuide* guide_ = nullptr;
  double sample_rate_ = 48000, force_gain_n_ = 0.3;
  Guidance::Settings guidance_settings_{};
  Guidance guidance_;
  ForceSmoother smoother_;
  Gradient gradient_{};
  PlaneForce force_{};
};

} // namespace tactus::reed
