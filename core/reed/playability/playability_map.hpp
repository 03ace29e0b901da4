#pragma once

#include "core/reed/playability/gradient_ensemble.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"

#include <cstddef>
#include <memory>

namespace tactus::reed {

/// Settings of a PlayabilityMap.
struct PlayabilityMapSettings {
  Parameters parameters{};
  double bore_frequency = 0; // f_b, Hz; 0: the instrument's own length
  ControlRange range{};
  PlayabilityParameters estimator{};
  double sample_rate = 48000;
  double settle_s = 0.5; // time from rest to the beginning of the average
  double listen_s = 0.2; // time over which f_p is averaged
};

/// A map of the playability f_p over the plane of mouth pressure and reed frequency, computed by
/// playing every node from rest: a pressure ramp of 20 ms, settle_s, then the mean of f_p over
/// listen_s. Eight nodes are computed at a time, in some milliseconds, independently of all others.
class PlayabilityMap {
public:
  explicit PlayabilityMap(simd::VectorSet widest = simd::kWidest)
      : ensemble_(make_reed_ensemble(widest)) {}
  /// Allocates columns x rows nodes and the reeds; clears the map.
  void begin(const PlayabilityMapSettings& settings, std::size_t columns, std::size_t rows);
  /// Computes up to eight nodes from `first` on (counted along y, then z); returns the first node
  /// not computed.
  std::size_t advance(std::size_t first) noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return field_.columns() * field_.rows(); }
  /// Length of the bore for these settings, m.
  [[nodiscard]] double length() const noexcept { return length_; }
  [[nodiscard]] const GradientField& field() const noexcept { return field_; }

private:
  PlayabilityMapSettings settings_{};
  std::unique_ptr<ReedEnsemble> ensemble_;
  GradientField field_;
  double length_ = 0;
};

} // namespace tactus::reed
