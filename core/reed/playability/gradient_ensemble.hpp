#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/playability_follower.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// Eight reeds of one instrument, side by side in vector registers, each with its own mouth
/// pressure and reed frequency, each followed by its own estimator of playability. They share the
/// bore frequency. Equal to as many scalar instruments within single precision (docs/guidance.md
/// says how near).
class ReedEnsemble {
public:
  static constexpr std::size_t kLanes = 8;
  /// Longest stretch that process() takes.
  static constexpr std::size_t kMaxFrames = 64;
  using PerLane = std::array<double, kLanes>;

  virtual ~ReedEnsemble() = default;
  /// Allocates; keeps the physical state when the rate is the same.
  virtual void prepare(double sample_rate) = 0;
  virtual void set(const Parameters& parameters) noexcept = 0;
  virtual void set(const PlayabilityParameters& parameters) noexcept = 0;
  virtual void reset() noexcept = 0;
  /// Advances frames <= kMaxFrames samples. Mouth pressures go along straight lines: sample i has
  /// start + slope (first + i + 1). Reed and bore frequency are targets (0: the instrument's own).
  /// sound, as long as frames or empty, is the pressure that lane 0 radiates to 1 m, Pa.
  struct Pressure {
    PerLane start{}, slope{};
    std::size_t first = 0;
  };
  virtual void process(const Pressure& mouth, const PerLane& reed_frequency, double bore_frequency,
                       std::size_t frames, std::span<double> sound) noexcept = 0;

  /// Only the first count lanes are judged from now on (all from the start).
  virtual void set_active_lanes(std::size_t count) noexcept = 0;
  /// theta, rad, and f_p of a lane as they are now. f_p is that of the paper's mode: lanes have no
  /// analysis of periodicity, which would cost more than the reeds and lag by 85 ms.
  [[nodiscard]] virtual double angle(std::size_t lane) const noexcept = 0;
  [[nodiscard]] virtual double bore_pressure(std::size_t lane) const noexcept = 0;
  [[nodiscard]] virtual double playability(std::size_t lane) const noexcept = 0;
  [[nodiscard]] virtual double envelope(std::size_t lane) const noexcept = 0;
  /// The bore's length now, m.
  [[nodiscard]] virtual double length() const noexcept = 0;
};

/// Which instructions an ensemble is compiled for.
enum class Instructions { kBaseline, kAvx2, kAvx512 };
/// The best that this machine runs and this build has.
[[nodiscard]] Instructions best_instructions() noexcept;
/// Null when this machine or build lacks them.
[[nodiscard]] std::unique_ptr<ReedEnsemble> make_reed_ensemble(Instructions instructions);
[[nodiscard]] inline std::unique_ptr<ReedEnsemble> make_reed_ensemble() {
  return make_reed_ensemble(best_instructions());
}

} // namespace tactus::reed
