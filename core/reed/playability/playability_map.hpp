#pragma once

#include "core/reed/playability/gradient_ensemble.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"

#include <cstddef>
#include <memory>

namespace tactus::reed {

/// What a map of f_p is of.
struct PlayabilityMapSettings {
  Parameters parameters{};
  double bore_frequency = 0; // f_b, Hz; 0: the instrument's own length
  ControlRange range{};
  PlayabilityParameters estimator{};
  double sample_rate = 48000;
  double settle_s = 0.5; // from rest, before one listens
  double listen_s = 0.2; // over which f_p is averaged
};

/// The playability f_p over the plane of mouth pressure and reed frequency, found by playing every
/// node from rest: pressure up within 20 ms, some time to speak, then the mean of f_p. Eight nodes
/// are played at a time; a portion of eight takes some milliseconds and depends on nothing before.
class PlayabilityMap {
public:
  explicit PlayabilityMap(Instructions instructions = best_instructions())
      : ensemble_(make_reed_ensemble(instructions)) {}
  /// Allocates columns x rows nodes and the reeds; starts anew.
  void begin(const PlayabilityMapSettings& settings, std::size_t columns, std::size_t rows);
  /// Computes the eight nodes from `first` on (counted along y, then z), or what is left of them;
  /// returns the first node not computed.
  std::size_t advance(std::size_t first) noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return field_.columns() * field_.rows(); }
  /// The bore's length that the settings stand for, m.
  [[nodiscard]] double length() const noexcept { return length_; }
  [[nodiscard]] const GradientField& field() const noexcept { return field_; }

private:
  PlayabilityMapSettings settings_{};
  std::unique_ptr<ReedEnsemble> ensemble_;
  GradientField field_;
  double length_ = 0;
};

} // namespace tactus::reed
