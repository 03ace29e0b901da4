#pragma once

#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// A brass instrument as it is built: a cylinder from the mouthpiece to where the bell flares
/// (bells(), termination.hpp), made longer by valves or by a slide.
struct BrassTube {
  double radius;      ///< of the bore, m
  double cup_volume;  ///< of the mouthpiece, m^3
  double open_length; ///< from the lips to the flare, no valve pressed or slide in, m
  double fundamental; ///< Hz: the open tube's notes are meant to be its multiples
  bool has_valves;    ///< three; else a slide
  double embouchure;  ///< f_r/f_b of lips that sound one of its many modes alone,
  double lip_quality; ///< and by how much their Q is larger
  double steepening;  ///< wavelengths (Parameters::steepening)
};

/// Null for an end that is no brass instrument's.
[[nodiscard]] const BrassTube* brass_tube(BoreEnd end) noexcept;

/// Whether the parameters ask a player to play on such a tube.
[[nodiscard]] bool uses_brass_tube(const Parameters& parameters) noexcept;

/// What is computed for the parameters: on such a tube its cylinder and cup in place of the
/// preset's bore; else a brass instrument's bell is left out, which needs its tube.
[[nodiscard]] Parameters with_brass_tube(const Parameters& parameters) noexcept;

/// How the tube is held for a note.
struct BrassPositions {
  int natural = 2;      ///< the tube's mode that the lips sound
  double semitones = 0; ///< by which valves or slide lower it
};

/// Valves or slide position that players take for a note in Hz: among the naturals from the second
/// on, without the seventh, which lies between the notes, the one that needs the shortest tube, at
/// most six semitones longer. Whole semitones with valves.
[[nodiscard]] BrassPositions standard_positions(const BrassTube& tube, double note) noexcept;

/// Length of the cylinder, m, with that slide position (1 to 7, between them too), each a semitone.
[[nodiscard]] double slide_length(const BrassTube& tube, const Termination& bell,
                                  double position) noexcept;
/// With valves pressed: bit 0 for the first (two semitones), 1 for the second (one), 2 for the
/// third (three). Their tubes add up, so that together they lower by a little less than their sum.
[[nodiscard]] double valve_length(const BrassTube& tube, const Termination& bell,
                                  unsigned pressed) noexcept;
/// Whether valves or slide make a cylinder of that length, m, by half a semitone more or less.
[[nodiscard]] bool within_tube_range(const BrassTube& tube, const Termination& bell,
                                     double length) noexcept;
/// The natural of a tube that lies nearest to a wish, both in Hz, on a logarithmic scale: its mode
/// with the lips shut. 0 when there is none within an octave.
[[nodiscard]] double nearest_natural(const Parameters& parameters, const Termination& bell,
                                     double length, double target_hz) noexcept;
/// The valves that lower by so many whole semitones, 0 to 6.
[[nodiscard]] unsigned standard_valves(int semitones) noexcept;

} // namespace tactus::reed
