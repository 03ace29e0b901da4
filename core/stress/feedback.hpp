#pragma once

#include "core/dsp/vector_set.hpp"
#include "core/geometry/vec3.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

/// Reduces the stress of all elements of a part to one number, or one per axis, for haptic
/// feedback: Fischer, Vance & Vo, "Haptic feedback to guide interactive product design", WINVR
/// 2009, equations (1) to (4).
///   (1) g   = (1/N) sum s            mean
///   (2) g   = (1/N) sum h s          weighted, with (3) h = (h_x + h_y + h_z)/3
///       g_a = (1/N) sum h_a s        axis
///   (1q) g  = ((1/N) sum s^q)^(1/q) power mean, q > 1 (not in the paper): between the mean and the
///       largest stress, near the latter for large q; s below 0 counts as 0
///   (4) gamma = (g - min)/(max - min), within 0..1; 0 when max = min
/// s: stress of an element, Pa. N: number of elements. h_a = ds/dp_a: sensitivity of s to the
/// control point's coordinate along axis a, Pa/m. min, max: over all elements, of s in (1), of h s
/// or h_a s in the others. The paper prints (1) and (2) without 1/N, but only a mean lies between
/// min and max.
namespace tactus::stress {

enum class Mapping : std::uint8_t { kMean, kWeighted, kAxis };
enum class Range : std::uint8_t { kCurrent, kInitial, kFixed };
enum class Weights : std::uint8_t { kUniform, kVolume };
enum class Sensitivity : std::uint8_t { kSigned, kAbsolute };
enum class State : std::uint8_t { kVonMises, kShear };
enum class Norm : std::uint8_t { kMean, kSum };

inline constexpr unsigned kMaxPower = 64;

struct FeedbackSettings {
  Mapping mapping = Mapping::kMean;
  Range range = Range::kInitial;
  double fixed_min = 0, fixed_max = 1; ///< Pa, or Pa^2/m in the weighted and axis mappings
  Weights weights = Weights::kUniform; ///< kVolume: uniform if the table has no volumes
  Sensitivity sensitivity = Sensitivity::kAbsolute;
  State state = State::kVonMises;
  Norm norm = Norm::kMean; ///< kSum: N times the mean; with a power, N^(1/q) times the power mean
  unsigned power = 1;      ///< q, 1..kMaxPower; used by the mean mapping only
  friend bool operator==(const FeedbackSettings&, const FeedbackSettings&) = default;
};

/// Upper limit of s/scale in the sum of powers, so that the sum stays finite.
inline constexpr double kMaxShare = 1e4;

/// Weighted sum and extremes of a quantity over the elements.
struct Extremes {
  double sum = 0;
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
};

/// One term of the Taylor series: a row of the sensitivities times a displacement.
struct TaylorTerm {
  const float* row; ///< [N] Pa/m
  double displacement_m;
};

/// Input of one pass over the elements; N is the size of `stress`.
struct FeedbackTask {
  std::span<const float> stress; ///< [N] Pa
  std::span<const TaylorTerm> terms;
  const float* weight = nullptr;   ///< [N]; null: 1
  std::array<const float*, 3> h{}; ///< [N] each; null: 0
  bool absolute = false;           ///< uses |h| in place of h
  Mapping mapping = Mapping::kMean;
  unsigned power = 1;    ///< q; 1: no sum of powers
  double scale_pa = 1.0; ///< divisor of the stress in the sum of powers
};

struct FeedbackSums {
  Extremes stress;                   ///< sum and extremes of s
  std::array<Extremes, 3> product{}; ///< those of h s; weighted mapping: [0] only; axis: one per
                                     ///< axis
  Extremes power; ///< those of (s/scale)^q, s/scale clamped to 0..kMaxShare; mean mapping with q >
                  ///< 1
};

/// Computes FeedbackSums of s = stress + sum of terms. Every instruction set gives the same bits.
class FeedbackKernel {
public:
  virtual ~FeedbackKernel() = default;
  [[nodiscard]] virtual FeedbackSums run(const FeedbackTask& task) const noexcept = 0;
};
/// The implementation for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] const FeedbackKernel*
feedback_kernel(simd::VectorSet widest = simd::kWidest) noexcept;
[[nodiscard]] const FeedbackKernel* feedback_kernel(simd::Baseline) noexcept;
[[nodiscard]] const FeedbackKernel* feedback_kernel(simd::Avx2) noexcept;

/// gamma of equation (4), 0..1.
[[nodiscard]] inline double gamma_of(double raw, double min, double max) noexcept {
  const double gamma = (raw - min) / (max - min);
  return max > min && gamma > 0 ? std::min(gamma, 1.0) : 0.0;
}

} // namespace tactus::stress
