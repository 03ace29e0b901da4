#pragma once

#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/linear_stability.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace tactus::reed {

/// A map of how fast notes start over the plane of mouth pressure and reed frequency, by linear
/// theory (LinearStability). Its gradient points to playing states, also where nothing sounds:
///   height = g/(g + 50 1/s)   where a note starts by itself,
///          = -d               elsewhere.
/// g > 0 is the growth rate of the dominant mode (1/s), d the distance in the plane to the nearest
/// node where a note starts. g < 0 gives no useful gradient: without any pressure a resonance
/// decays more slowly than with a little pressure, so that g would point away from notes.
///
/// The map is computed a few nodes at a time; meanwhile the previous map stays in use. Limits of
/// linear theory: docs/theory/guidance.md.
class GrowthMap {
public:
  /// Allocates columns x rows nodes.
  void prepare(std::size_t columns, std::size_t rows);
  /// Discards unfinished work and starts a map of the instrument as it is played
  /// (embouchure_for()). No allocation.
  void begin(const PlayingSetup& playing, const ControlRange& range) noexcept;
  /// Computes up to `nodes` nodes; true when the map is finished. Each node takes 20 to 150 us.
  bool advance(std::size_t nodes) noexcept;
  [[nodiscard]] bool ready() const noexcept { return ready_; }
  /// Share of the nodes computed, 0..1.
  [[nodiscard]] double progress() const noexcept;

  /// The finished map: the height above, and g in 1/s.
  [[nodiscard]] const GradientField& height() const noexcept { return height_; }
  [[nodiscard]] const GradientField& growth() const noexcept { return growth_; }

private:
  void finish() noexcept;

  std::optional<LinearStability> theory_;
  ControlRange range_{};
  double reed_scale_ = 1;
  GradientField in_progress_, growth_, height_;
  std::vector<char> grows_; // nodes of in_progress_ where a note starts
  std::vector<double> squared_distances_, scratch_;
  std::size_t next_ = 0;
  bool ready_ = false;
};

} // namespace tactus::reed
