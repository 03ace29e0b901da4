#pragma once

#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// Tube of a trumpet or trombone: a cylinder from the mouthpiece to the beginning of the bell
/// (bells(), termination.hpp), lengthened by valves or a slide. Lengths in m.
struct BrassTube {
  double radius;      ///< radius of the bore
  double cup_volume;  ///< volume of the mouthpiece's cup, m^3
  double open_length; ///< length from the lips to the flare, without valves or slide
  double fundamental; ///< Hz; the notes of the open tube are its multiples
  bool has_valves;    ///< three valves; else a slide
  double embouchure;  ///< f_r/f_b of lips on such a tube
  double lip_quality; ///< factor on the lips' Q, so that they select one of the tube's many modes
  double steepening;  ///< wavelengths (Parameters::steepening)
};

/// The tube of kTrumpet or kTrombone; null for other ends.
[[nodiscard]] const BrassTube* brass_tube(BoreEnd end) noexcept;

/// True if the parameters let a player play on such a tube: `tube`, `valves` or `slide` with
/// `tune`.
[[nodiscard]] bool uses_brass_tube(const Parameters& parameters) noexcept;

/// The parameters with cylinder and cup of the tube in place of the preset's bore. If the tube is
/// not used, a brass bell becomes an open end, because the bell's filter needs its tube.
[[nodiscard]] Parameters with_brass_tube(const Parameters& parameters) noexcept;

/// Mode and tube length for a note.
struct BrassPositions {
  int natural = 2;      ///< number of the mode that the lips play
  double semitones = 0; ///< semitones by which valves or slide lower the open tube
};

/// Standard valves or slide position for a note in Hz. Of the modes from the second on, it uses the
/// mode that needs the shortest tube, lowered by at most six semitones. The seventh mode is left
/// out, because it is out of tune. With valves, the semitones are whole numbers.
[[nodiscard]] BrassPositions standard_positions(const BrassTube& tube, double note) noexcept;

/// Length of the cylinder, m, at a slide position from 1 to 7, which may be a fraction; one
/// position is a semitone.
[[nodiscard]] double slide_length(const BrassTube& tube, const Termination& bell,
                                  double position) noexcept;
/// Length of the cylinder, m, with valves pressed: bit 0 for the first valve (two semitones), 1 for
/// the second (one semitone), 2 for the third (three semitones). The lengths of their tubes add up,
/// so that several valves together lower the note by a little less than the sum of their semitones.
[[nodiscard]] double valve_length(const BrassTube& tube, const Termination& bell,
                                  unsigned pressed) noexcept;
/// True if a cylinder of this length, m, is within the range of valves or slide, with half a
/// semitone to spare.
[[nodiscard]] bool within_tube_range(const BrassTube& tube, const Termination& bell,
                                     double length) noexcept;
/// The mode of the tube with closed lips nearest to target_hz on a logarithmic scale, Hz. 0 when
/// none is found within an octave of it.
[[nodiscard]] double nearest_natural(const Parameters& parameters, const Termination& bell,
                                     double length, double target_hz) noexcept;
/// The standard valves, as bits, that lower the tube by 0 to 6 semitones.
[[nodiscard]] unsigned standard_valves(int semitones) noexcept;

} // namespace tactus::reed
