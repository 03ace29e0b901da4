#pragma once

#include "core/reed/gradient_ensemble.hpp"
#include "core/reed/gradient_plane.hpp"
#include "core/reed/growth_map.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// The paper's haptic gradient from one object: five reeds at and around the hand's place in the
/// plane, each judged, and the central differences of their playability; or, in growth mode, the
/// slope of the GrowthMap at the hand, with the one reed that sounds.
///
/// The hand's place is read every 32 samples; pressures move there in straight lines, reed
/// frequencies at the reeds' own pace.
class ReedGradient {
public:
  enum class Mode { kReed, kGrowth };
  static constexpr std::size_t kGrowthNodes = 41; // along y and along z

  explicit ReedGradient(Instructions instructions = best_instructions());

  /// Allocates; keeps the physical state when the rate is the same.
  void prepare(double sample_rate);
  void set(const Parameters& parameters) noexcept;
  void set(const PlayabilityParameters& judge) noexcept;
  void set_range(const ControlRange& range) noexcept;
  /// 0 < delta <= 0.25, of the plane's side.
  void set_delta(double delta) noexcept { delta_ = delta; }
  void set_mode(Mode mode) noexcept { mode_ = mode; }
  void reset() noexcept;

  /// The hand's place at one sample; what is not finite is ignored, the rest clamped to [0, 1].
  /// To be called before process() of that sample; see takes_hand().
  void move(double y, double z, double bore_frequency) noexcept;
  /// Samples until move() is read next; 0: now.
  [[nodiscard]] std::size_t until_hand() const noexcept { return phase_ == 0 ? 0 : kHold - phase_; }
  /// Advances sound.size() samples, at most those until the next reading of the hand. sound is that
  /// of greed~: gain times the pressure at 1 m, linear to 0.5, within +-1.
  void process(std::span<double> sound) noexcept;

  /// f_p of the reed at the hand.
  [[nodiscard]] double playability() const noexcept { return ensemble_->playability(0); }
  [[nodiscard]] Gradient gradient() const noexcept;

  /// Growth mode: true while the map lags behind the settings; advance_map() then computes up to
  /// that many nodes. Off the audio path: a node takes up to some 100 us.
  [[nodiscard]] bool map_lags() const noexcept;
  void advance_map(std::size_t nodes) noexcept;
  [[nodiscard]] const GrowthMap& map() const noexcept { return map_; }

  [[nodiscard]] const ReedEnsemble& ensemble() const noexcept { return *ensemble_; }
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] const ControlRange& range() const noexcept { return range_; }
  [[nodiscard]] double delta() const noexcept { return delta_; }
  [[nodiscard]] Mode mode() const noexcept { return mode_; }
  static constexpr std::size_t kHold = 32; // samples between readings of the hand

private:
  void aim() noexcept;

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
  bool aimed_ = false, retune_ = true;
  bool resting_ = false; // the hand has not moved since the last reading, nor do the pressures
  GrowthMap map_;
  bool stale_ = true;
  double map_length_ = 0;
};

} // namespace tactus::reed
