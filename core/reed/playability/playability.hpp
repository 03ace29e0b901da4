#pragma once

#include "core/reed/playability/playability_analysis.hpp"
#include "core/reed/playability/playability_follower.hpp"

#include <memory>

namespace tactus::reed {

/// Kind of oscillation found by the analysis. The boundaries (periodicity 0.985 and 0.85) are
/// choices; weakly chaotic motion counts as periodic. See docs/theory/playability.md.
enum class Regime { kSilent, kPeriodic, kQuasiPeriodic, kChaotic };

/// Playability estimator of one reed: from the angle of its valve to f_p in 0..1, by amplitude and
/// zero crossings (PlayabilityFollower) and periodicity (PeriodicityAnalysis). Equations:
/// docs/theory/playability.md.
class Playability {
public:
  /// Allocates; keeps its state when nothing has changed. Without a transform (null) there is no
  /// analysis, and the motion counts as periodic.
  void prepare(double sample_rate, std::shared_ptr<RealTransform> transform);
  void set(const PlayabilityParameters& parameters) noexcept;
  /// Turns periodicity() and regime() on or off. The robust mode runs the analysis in either case.
  void set_analysis(bool on) noexcept;
  void reset() noexcept;
  /// The next angle, rad.
  void tick(double angle) noexcept;

  [[nodiscard]] double playability() const noexcept;
  [[nodiscard]] const PlayabilityFollower<double>& follower() const noexcept { return follower_; }
  [[nodiscard]] const Periodicity& periodicity() const noexcept { return analysis_.result(); }
  [[nodiscard]] Regime regime() const noexcept { return regime_; }
  /// The value last given to set_analysis().
  [[nodiscard]] bool analysis() const noexcept { return requested_; }
  /// Number of frames analysed since reset.
  [[nodiscard]] std::size_t frames() const noexcept { return frames_; }

private:
  void choose_analysis() noexcept;
  void update_regime() noexcept;

  PlayabilityFollower<double> follower_;
  PeriodicityAnalysis analysis_;
  bool requested_ = true, analysing_ = true, sounding_ = false;
  std::size_t frames_ = 0;
  Regime regime_ = Regime::kSilent, candidate_ = Regime::kSilent;
};

} // namespace tactus::reed
