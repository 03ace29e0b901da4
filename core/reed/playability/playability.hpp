#pragma once

#include "core/reed/playability/playability_analysis.hpp"
#include "core/reed/playability/playability_follower.hpp"

#include <memory>

namespace tactus::reed {

/// What kind of oscillation the analysis finds. The boundaries (periodicity 0.985 and 0.85) are
/// choices; weakly chaotic motion passes as periodic. See docs/playability.md.
enum class Regime { kSilent, kPeriodic, kQuasiPeriodic, kChaotic };

/// Playability estimator of one reed, from the angle of its valve alone.
class Playability {
public:
  /// Allocates; keeps its state when nothing changed. Without a transform (null) there is no
  /// analysis, and aperiodicity counts as 0 in every mode.
  void prepare(double sample_rate, std::shared_ptr<RealTransform> transform);
  void set(const PlayabilityParameters& parameters) noexcept;
  /// Whether periodicity and regime are asked for. The robust mode needs the analysis and runs it
  /// whether or not they are.
  void set_analysis(bool on) noexcept;
  void reset() noexcept;
  /// The next angle, rad.
  void tick(double angle) noexcept;

  [[nodiscard]] double playability() const noexcept;
  [[nodiscard]] const PlayabilityFollower<double>& follower() const noexcept { return follower_; }
  [[nodiscard]] const Periodicity& periodicity() const noexcept { return analysis_.result(); }
  [[nodiscard]] Regime regime() const noexcept { return regime_; }
  /// As last given to set_analysis().
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
