#pragma once

#include "core/reed/bore/termination.hpp"

#include <array>
#include <cstddef>
#include <numbers>

namespace tactus::reed {

/// Geometry of a woodwind: bore, tone holes, register vent and bell, in metres.
///
/// One tone hole per semitone; their sizes follow from the cut-off frequency of the open lattice
/// (Benade 1976, ch. 21), their positions from an end correction of 2 cm. The same geometry, with
/// its sources, is in bench/reed_bores/bores.py.
struct Woodwind {
  struct Corner {
    double distance, ratio; // distance from the last hole's position; radius relative to the bore's
                            // at that hole
  };
  struct Hole {
    double position, radius, height; // position from the reed's end, or for a cone from its apex
  };
  static constexpr int kBellCorners = 5;
  static constexpr std::size_t kMaxToneHoles = 32;

  int lowest_key = 50, highest_key = 70; // MIDI; all tone holes closed, all open
  double input_radius = 7.5e-3;
  double apex = 0;        // distance from the apex to the reed's end; 0: cylinder
  double cutoff = 1500;   // cut-off of the lattice, Hz; if it rises, at the lowest hole
  double chimney = 8e-3;  // height of the tone holes
  double cutoff_rise = 0; // the cut-off rises with the note's frequency to this power
  int cutoff_top = 127;   // the cut-off rises up to this key's hole
  std::array<Corner, kBellCorners> bell{};
  int bell_corners = 0;
  Hole vent{};                // the register vent; position from the reed's end, also for a cone
  int overblow_interval = 19; // semitones by which the open vent raises a fingering's note

  /// Position of a note's first open hole; for the lowest note, the beginning of the bell.
  [[nodiscard]] double position(double key) const noexcept;
  /// Cut-off of the lattice around a note's first open hole, Hz.
  [[nodiscard]] double cutoff_at(int key) const noexcept;
  /// Radius of the bore.
  [[nodiscard]] double radius(double position) const noexcept {
    return input_radius * (apex > 0 ? position / apex : 1);
  }
  /// Tone holes are counted from the reed down: 0 belongs to the highest note.
  [[nodiscard]] std::size_t tone_holes() const noexcept {
    return static_cast<std::size_t>(highest_key - lowest_key);
  }
  /// Position, radius and height of a tone hole.
  [[nodiscard]] Hole tone_hole(std::size_t index) const noexcept;
  /// MIDI number of the note whose first open hole this is.
  [[nodiscard]] int key_of(std::size_t index) const noexcept {
    return highest_key - static_cast<int>(index);
  }
};

/// The woodwind of kClarinet, kSaxophone or kOboe; null for other ends.
[[nodiscard]] const Woodwind* woodwind(BoreEnd end) noexcept;

} // namespace tactus::reed
