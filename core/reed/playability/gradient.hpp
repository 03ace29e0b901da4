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

/// The haptic gradient of Smyth, Smyth & Kirkpatrick: five reeds at and around the hand's position
/// in the plane of mouth pressure and reed frequency, the gradient of their playability, and the
/// force on the hand.
///
/// Mode     gradient                                      force
///   reed   central differences of the playability f_p    gradient_force()
///   growth slope of a GrowthMap at the hand              gradient_force()
///   guide  direction to the nearest note (GuidanceField) Guidance
/// gradient_force() is smoothed by a ForceSmoother of 30 ms and 20 N/s.
///
/// The hand's position is read every kHandPeriod samples. Pressures then move linearly to the new
/// position within one period; reed frequencies follow through the low-pass of ReedBank. The force
/// is updated at every second reading, in the middle of a host's block of 64. Laws and
/// measurements: docs/theory/guidance.md.
class ReedGradient {
public:
  enum class Mode { kReed, kGrowth, kGuide };
  static constexpr std::size_t kGrowthNodes = 41; // nodes along y and along z

  explicit ReedGradient(simd::VectorSet widest = simd::kWidest);

  /// Allocates; keeps the physical state when the rate is the same.
  void prepare(double sample_rate);
  void set(const Parameters& parameters) noexcept;
  void set(const PlayabilityParameters& estimator) noexcept;
  void set_range(const ControlRange& range) noexcept;
  /// Distance of the neighbours as a share of the plane's side, 0 < delta <= 0.25.
  void set_delta(double delta) noexcept { delta_ = delta; }
  /// The force continues from its present value.
  void set_mode(Mode mode) noexcept;
  /// F_max >= 0, N: of each axis in modes reed and growth, of the whole vector in mode guide.
  void set_ceiling(double ceiling_n) noexcept;
  /// Force for a slope of 1 in modes reed and growth, N.
  void set_force_gain(double gain_n) noexcept { force_gain_n_ = gain_n; }
  void reset() noexcept;

  /// The hand's position in [0, 1] (clamped) and f_b, Hz; values that are not finite are ignored.
  /// To be called when samples_until_hand() is 0, before process().
  void move(double y, double z, double bore_frequency) noexcept;
  /// Samples until move() is due; 0: now.
  [[nodiscard]] std::size_t samples_until_hand() const noexcept {
    return phase_ == 0 ? 0 : kHandPeriod - phase_;
  }
  /// Advances sound.size() samples, at most samples_until_hand() or kHandPeriod of them. sound is
  /// that of Instrument.
  void process(std::span<double> sound) noexcept;

  /// f_p of the reed at the hand.
  [[nodiscard]] double playability() const noexcept { return ensemble_->playability(0); }
  /// The gradient per unit of y and of z, as of the last update of the force; it points to higher
  /// playability. In mode guide: minus the slope of the distance, of length 1 or less. 0 without a
  /// guide.
  [[nodiscard]] const Gradient& gradient() const noexcept { return gradient_; }
  /// The force on the hand, N, as of its last update.
  [[nodiscard]] const PlaneForce& force() const noexcept { return force_; }
  /// Sets the force to 0 until the hand is read again.
  void release_force() noexcept;

  /// The settings that a guide for the present instrument, note and range depends on.
  [[nodiscard]] PlaneSettings plane() const noexcept;
  /// Sets the guide of modes growth and guide, which must outlive its use. Null: no slope, no
  /// force.
  void set_guide(const PlaneGuide* guide) noexcept { guide_ = guide; }

  [[nodiscard]] const ReedEnsemble& ensemble() const noexcept { return *ensemble_; }
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] const ControlRange& range() const noexcept { return range_; }
  [[nodiscard]] double delta() const noexcept { return delta_; }
  [[nodiscard]] Mode mode() const noexcept { return mode_; }
  [[nodiscard]] double ceiling() const noexcept { return guidance_settings_.ceiling_n; }
  [[nodiscard]] double force_gain() const noexcept { return force_gain_n_; }
  static constexpr std::size_t kHandPeriod = 32; // samples between readings of the hand
  static constexpr std::size_t kForcePeriod = 2 * kHandPeriod; // samples between updates of the
                                                               // force

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
  bool hand_at_rest_ = false; // neither hand nor pressures have moved since the last reading
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
