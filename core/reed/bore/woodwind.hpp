#pragma once

#include "core/reed/bore/termination.hpp"

#include <array>
#include <cstddef>
#include <numbers>

namespace tactus::reed {

/// A woodwind as it is built: bore, tone holes and bell in metres. The geometry of
/// bench/reed_bores/bores.py, which has its sources: one tone hole a semitone, their sizes from the
/// cut-off frequency of the open lattice (Benade 1976, chapter 21), an end correction of 2 cm
/// before each note's first open hole.
struct Woodwind {
  struct Corner {
    double distance, ratio; // from the last hole's place; radius over the bore's there
  };
  struct Hole {
    double position, radius, height; // place from the reed's end; of a cone from its apex
  };
  static constexpr int kBellCorners = 5;
  static constexpr std::size_t kMaxToneHoles = 32;

  int lowest_key = 50, highest_key = 70; // MIDI; all tone holes closed, all open
  double input_radius = 7.5e-3;
  double apex = 0;        // from the apex to the reed's end; 0: cylinder
  double cutoff = 1500;   // of the lattice, Hz; at its lowest hole where it rises
  double chimney = 8e-3;  // height of the tone holes
  double cutoff_rise = 0; // power of the note by which the cut-off rises up the bore,
  int cutoff_top = 127;   // up to this key's hole
  std::array<Corner, kBellCorners> bell{};
  int bell_corners = 0;
  Hole vent{};                // the register vent; its place on the line, from the reed's end
  int overblow_interval = 19; // semitones from a fingering's note to the one with the vent open

  /// A note's first open hole; the lowest note's is the beginning of the bell.
  [[nodiscard]] double position(double key) const noexcept;
  /// Cut-off of the lattice about the hole that a note opens first, Hz.
  [[nodiscard]] double cutoff_at(int key) const noexcept;
  /// Radius of the bore.
  [[nodiscard]] double radius(double position) const noexcept {
    return input_radius * (apex > 0 ? position / apex : 1);
  }
  /// Tone holes are counted from the reed down: 0 belongs to the highest note.
  [[nodiscard]] std::size_t tone_holes() const noexcept {
    return static_cast<std::size_t>(highest_key - lowest_key);
  }
  [[nodiscard]] Hole tone_hole(std::size_t index) const noexcept;
  /// The note of which a tone hole is the first open one.
  [[nodiscard]] int key_of(std::size_t index) const noexcept {
    return highest_key - static_cast<int>(index);
  }
};

/// The instrument whose holes the bore ends in; null for the open end.
[[nodiscard]] const Woodwind* woodwind(BoreEnd end) noexcept;

} // namespace tactus::reed
