#pragma once

#include "core/dsp/vector_set.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/playability_follower.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// Eight reeds of one instrument computed together in vector lanes (single precision), each with
/// its own mouth pressure, reed frequency and playability estimator; they share the bore frequency.
///
/// Interface of LaneEnsemble, which is compiled once per instruction set. Each lane equals a scalar
/// Instrument within single precision (docs/theory/guidance.md has the figures).
class ReedEnsemble {
public:
  static constexpr std::size_t kLanes = 8;
  /// Largest number of samples that process() takes at once.
  static constexpr std::size_t kMaxFrames = 64;
  using PerLane = std::array<double, kLanes>;

  virtual ~ReedEnsemble() = default;
  /// Allocates; keeps the physical state when the rate is the same.
  virtual void prepare(double sample_rate) = 0;
  virtual void set(const Parameters& parameters) noexcept = 0;
  virtual void set(const PlayabilityParameters& parameters) noexcept = 0;
  virtual void reset() noexcept = 0;
  /// Mouth pressures, Pa, as linear ramps: sample i has start + slope (first + i + 1).
  struct Pressure {
    PerLane start{}, slope{};
    std::size_t first = 0;
  };
  /// Advances frames <= kMaxFrames samples. Reed and bore frequency in Hz are targets (0: the
  /// instrument's own). sound, empty or of that size, is the pressure of lane 0 at 1 m, Pa.
  virtual void process(const Pressure& mouth, const PerLane& reed_frequency, double bore_frequency,
                       std::size_t frames, std::span<double> sound) noexcept = 0;

  /// Limits the playability estimators to the first count lanes (default: all).
  virtual void set_active_lanes(std::size_t count) noexcept = 0;
  /// theta of a lane after the last sample, rad.
  [[nodiscard]] virtual double angle(std::size_t lane) const noexcept = 0;
  /// p_b, Pa.
  [[nodiscard]] virtual double bore_pressure(std::size_t lane) const noexcept = 0;
  /// f_p in mode `paper`, because a periodicity analysis would cost more than the reeds and lag by
  /// 85 ms.
  [[nodiscard]] virtual double playability(std::size_t lane) const noexcept = 0;
  /// y, rad (PlayabilityFollower).
  [[nodiscard]] virtual double envelope(std::size_t lane) const noexcept = 0;
  /// The bore's length now, m.
  [[nodiscard]] virtual double length() const noexcept = 0;
};

/// The implementation for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::VectorSet widest);
[[nodiscard]] std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::Baseline);
[[nodiscard]] std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::Avx2);
[[nodiscard]] std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::Avx512);

} // namespace tactus::reed
