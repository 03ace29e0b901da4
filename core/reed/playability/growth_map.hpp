#pragma once

#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/linear_stability.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace tactus::reed {

/// Guidance from linear theory, also where nothing sounds: over the plane of mouth pressure and
/// reed frequency, a height whose slope leads to playing states,
///   height = g/(g + 50 1/s)   where a note starts by itself,
///          = -d               elsewhere,
/// g > 0 the growth rate of the dominant mode (LinearStability) and d the distance, in the plane,
/// to the nearest node where a note starts. Within a note the slope leads to ready speech, from the
/// deepest silence to the nearest note. In silence g itself is no guide: an instrument that is not
/// blown at all rings on for longer than one blown a little, so its slope leads away from notes.
///
/// The map is computed a few nodes at a time, so that it can grow between blocks of audio; the
/// finished one before it is used meanwhile.
class GrowthMap {
public:
  /// Allocates columns x rows nodes.
  void prepare(std::size_t columns, std::size_t rows);
  /// Forgets unfinished work and starts a map of the instrument as it is played (embouchure_for());
  /// allocation-free.
  void begin(const PlayingSetup& playing, const ControlRange& range) noexcept;
  /// Computes up to that many nodes; true when the map is finished. Each takes 20 to 150 us.
  bool advance(std::size_t nodes) noexcept;
  [[nodiscard]] bool ready() const noexcept { return ready_; }
  [[nodiscard]] bool working() const noexcept { return theory_.has_value(); }
  /// Nodes done over nodes in all, of the map at work.
  [[nodiscard]] double progress() const noexcept;

  /// The finished map. growth() holds g in 1/s, height() what guides.
  [[nodiscard]] const GradientField& height() const noexcept { return height_; }
  [[nodiscard]] const GradientField& growth() const noexcept { return growth_; }

private:
  void finish() noexcept;

  std::optional<LinearStability> theory_;
  ControlRange range_{};
  double reed_scale_ = 1;
  GradientField in_progress_, growth_, height_;
  std::vector<char> grows_; // where a note starts, of the nodes at work
  std::vector<double> squared_distances_, scratch_;
  std::size_t next_ = 0;
  bool ready_ = false;
};

} // namespace tactus::reed
