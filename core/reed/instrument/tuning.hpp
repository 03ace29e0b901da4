#pragma once

#include "core/reed/bore/register_vent.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// Fingering of a note: open holes and register vent.
struct Fingering {
  const Termination* end = nullptr; // termination of the bore; null: an open end
  bool vented = false;              // the register vent is open: the note is overblown

  friend bool operator==(const Fingering&, const Fingering&) = default;
};
/// The standard fingering of the note bore_frequency (Hz). From Parameters::register_note on, it is
/// the fingering of the note a twelfth (on a cone: an octave) below, with the register vent open.
[[nodiscard]] Fingering standard_fingering(const Parameters& parameters,
                                           double bore_frequency) noexcept;
/// MIDI number of the note that a fingering sounds.
[[nodiscard]] double key_of(const Parameters& parameters, const Fingering& fingering) noexcept;

/// Length of the bore, m, near which tuned_length() searches for a note (Hz): the length whose
/// ideal lowest resonance is the note. For lips it is the instrument's own length, or with
/// Parameters::highest_mode a shorter bore on which the note is not above that mode. On a brass
/// tube it is the length that valves or slide set.
[[nodiscard]] double nominal_length(const Parameters& parameters, double bore_frequency,
                                    const Termination* end = nullptr) noexcept;

/// Length of the bore, m, at which the linearised instrument plays bore_frequency (Hz) with the
/// given reed frequency (Hz).
///
/// A neutral oscillation exp(i 2 pi f_b t) solves Y_in(L) = Y_valve(p_m) (LinearStability). p_m is
/// the lowest pressure that has such a solution, times over_threshold >= 1 (at most half way to the
/// highest pressure). If no pressure has a solution, p_m is the pressure that comes nearest. If
/// there are several lengths, the one nearest to nominal_length() is taken: a blown-open valve
/// plays a mode of a longer bore, other valves play the lowest mode. Bounded work (about 60
/// evaluations of a few complex functions), no allocation.
[[nodiscard]] double tuned_length(const Parameters& parameters, double bore_frequency,
                                  double reed_frequency, double over_threshold = 1,
                                  const Fingering& fingering = {}) noexcept;

/// Valve, length and fingering that a player chooses for a note.
struct PlayingSetup {
  Parameters valve;      // the instrument with the player's lips
  double length;         // L, m
  double reed_scale = 1; // factor on the f_r that the instrument is given
  Fingering fingering{};
};

/// The player's setup for the note bore_frequency (Hz), given f_r = reed_frequency (Hz).
///
/// The lips change the valve by Parameters::lip_... The length is tuned_length() of that valve at
/// usual playing pressures: 1.5 times the threshold for reeds, 2.5 times for lips. Linear theory
/// does not contain the shift of pitch with amplitude; Parameters::aim (cents, added to f_b)
/// compensates it.
///
/// With an embouchure (lips, folds, membranes) the valve follows the note. Its frequency becomes
/// embouchure * f_b at constant stiffness (a lower note moves more mass), so that threshold and
/// opening do not change. f_r then bends the pitch, relative to Parameters::reed_frequency. A note
/// well below the bore's lowest resonance depends on the valve alone (valve_only_length()).
[[nodiscard]] PlayingSetup tuned(const Parameters& parameters, double bore_frequency,
                                 double reed_frequency, const Fingering& fingering) noexcept;
/// tuned() with standard_fingering().
[[nodiscard]] PlayingSetup tuned(const Parameters& parameters, double bore_frequency,
                                 double reed_frequency) noexcept;

/// Phase of the round trip of a bore of this length (m) at the note bore_frequency (Hz), in turns
/// (2 pi rad): the phase of the delay and of the wall loss.
[[nodiscard]] double round_trip_turns(const Parameters& parameters, double bore_frequency,
                                      double length) noexcept;
/// Inverse of round_trip_turns(): L in m, at least 5 mm.
[[nodiscard]] double length_from_turns(const Parameters& parameters, double bore_frequency,
                                       double turns) noexcept;

/// Length of a bore, m, whose lowest resonance is so far above the note (4/3 of it or more) that
/// the valve alone sets the pitch. It is the parameters' own length or, for high notes, a shorter
/// length down to Parameters::shortest_tract, as singers raise their first formant with the note
/// (Joliveau, Smith & Wolfe 2004, Nature 427). 0 if there is no such length, or no embouchure; then
/// the bore sets the pitch.
[[nodiscard]] double valve_only_length(const Parameters& parameters, double bore_frequency,
                                       const Termination* end = nullptr) noexcept;

/// tuned() without the search for a length, which stays the parameters' own.
[[nodiscard]] PlayingSetup player_lips(const Parameters& parameters,
                                       double bore_frequency) noexcept;

/// Valve and fingering for the note bore_frequency (Hz; 0: none) on a bore of this length. With
/// `tune`, a note and no length_override they are those of tuned(), else those of the parameters.
/// Corrections by TuningController are not included.
[[nodiscard]] PlayingSetup embouchure_for(const Parameters& parameters, double bore_frequency,
                                          double length_m) noexcept;

} // namespace tactus::reed
