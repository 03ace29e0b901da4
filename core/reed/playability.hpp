#pragma once

#include "core/reed/playability_analysis.hpp"
#include "core/reed/playability_follower.hpp"

#include <memory>

namespace tactus::reed {

/// What kind of oscillation the analysis hears. The boundaries (periodicity 0.985 and 0.85) are
/// choices; weakly chaotic motion passes as periodic. See docs/playability.md.
enum class Regime { kSilent, kPeriodic, kQuasiPeriodic, kChaotic };

/// The judge of one reed: how well it plays, from the angle of its valve alone.
class Playability {
public:
  /// Allocates; keeps its state when nothing changed. Without a transform there is no analysis,
  /// and the robust mode falls back to the paper's.
  void prepare(double sample_rate, std::shared_ptr<RealTransform> transform);
  void set(const PlayabilityParameters& parameters) noexcept { follower_.set(parameters); }
  void set_analysis(bool on) noexcept;
  void reset() noexcept;
  /// The next angle, rad.
  void tick(double angle) noexcept;

  [[nodiscard]] double playability() const noexcept;
  [[nodiscard]] const PlayabilityFollower<double>& follower() const noexcept { return follower_; }
  [[nodiscard]] const Periodicity& periodicity() const noexcept { return analysis_.result(); }
  [[nodiscard]] Regime regime() const noexcept { return regime_; }
  [[nodiscard]] bool analysing() const noexcept { return analysing_; }
  /// Number of frames analysed since reset.
  [[nodiscard]] std::size_t frames() const noexcept { return frames_; }

private:
  void judge() noexcept;

  PlayabilityFollower<double> follower_;
  PeriodicityAnalysis analysis_;
  bool analysing_ = true, sounding_ = false;
  std::size_t frames_ = 0;
  Regime regime_ = Regime::kSilent, candidate_ = Regime::kSilent;
};

} // namespace tactus::reed
