#pragma once

#include "core/reed/bore/register_vent.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// What the fingers do for a note.
struct Fingering {
  const Termination* end = nullptr; // what the bore ends in; null: an open end
  bool vented = false;              // the register vent is open: the note is overblown

  friend bool operator==(const Fingering&, const Fingering&) = default;
};
/// The standard fingering of the note bore_frequency (Hz): from Parameters::register_note on that
/// of the note a twelfth (of a cone: an octave) below, with the register vent.
[[nodiscard]] Fingering standard_fingering(const Parameters& parameters,
                                           double bore_frequency) noexcept;
/// MIDI number of the note that a fingering sounds.
[[nodiscard]] double key_of(const Parameters& parameters, const Fingering& fingering) noexcept;

/// Length of the bore, m, near which a note (Hz) is looked for: where its ideal lowest resonance
/// lies. Lips choose a resonance of the instrument's own bore, or with Parameters::highest_mode one
/// not above that, on a shorter bore.
[[nodiscard]] double nominal_length(const Parameters& parameters, double bore_frequency,
                                    const Termination* end = nullptr) noexcept;

/// Length of the bore, m, with which the instrument's linear playing frequency is bore_frequency
/// (Hz) at that reed frequency (Hz): the neutral oscillation exp(i 2 pi f_b t) of
/// Y_in(L) = Y_valve(p_m) at the lowest pressure that has one, or at over_threshold >= 1 times that
/// (at most half way to the highest). A blown-open valve plays a mode of a longer bore: among the
/// solutions the one nearest to the parameters' own length is taken; the others play their lowest
/// mode. Where no pressure starts the note, the pressure counts
/// that comes nearest to it. Bounded work (about 60 evaluations of a few complex functions), no
/// allocation.
[[nodiscard]] double tuned_length(const Parameters& parameters, double bore_frequency,
                                  double reed_frequency, double over_threshold = 1,
                                  const Fingering& fingering = {}) noexcept;

/// What a player chooses to sound a note.
struct PlayingSetup {
  Parameters valve;      // the instrument with the player's lips
  double length;         // L, m
  double reed_scale = 1; // factor on the f_r that the instrument is given
  Fingering fingering{};
};

/// A player's choice for the note bore_frequency (Hz), given f_r = reed_frequency (Hz).
///
/// Linear theory knows nothing of amplitude: the choice is made for Parameters::aim beside f_b.
/// The player's lips change the valve (Parameters::lip_...), and the length is tuned_length() of
/// that valve where notes are usually played: at one and a half times the threshold, lips at two
/// and a half. With an embouchure (lips, folds, membranes) the valve also goes with the note: it is
/// brought to embouchure * f_b, at constant stiffness (a lower note takes more of the lip's mass),
/// so that threshold and opening stay what they were; f_r then bends it, its own value being no
/// bend. A note well below the bore's lowest resonance is that valve's alone (valve_only_length()).
[[nodiscard]] PlayingSetup tuned(const Parameters& parameters, double bore_frequency,
                                 double reed_frequency, const Fingering& fingering) noexcept;
/// The same with the fingering of the note, when the instrument has fingerings.
[[nodiscard]] PlayingSetup tuned(const Parameters& parameters, double bore_frequency,
                                 double reed_frequency) noexcept;

/// The round trip of a bore of that length, m, at the note bore_frequency (Hz), in turns: the delay
/// and what the wall loss adds to it.
[[nodiscard]] double round_trip_turns(const Parameters& parameters, double bore_frequency,
                                      double length) noexcept;
/// The inverse: L in m, at least 5 mm.
[[nodiscard]] double length_from_turns(const Parameters& parameters, double bore_frequency,
                                       double turns) noexcept;

/// Length of the bore, m, whose lowest resonance lies so far above the note that this is the
/// valve's alone: the parameters' own or, for high notes, one that the player shortens to
/// Parameters::shortest_tract at most, as singers raise their first formant with the note
/// (Joliveau, Smith & Wolfe, Nature 427, 2004). 0 where there is none: the bore has to sound the
/// note.
[[nodiscard]] double valve_only_length(const Parameters& parameters, double bore_frequency,
                                       const Termination* end = nullptr) noexcept;

/// The lips of tuned(), without the search for a length: that is the parameters' own.
[[nodiscard]] PlayingSetup player_lips(const Parameters& parameters,
                                       double bore_frequency) noexcept;

/// The instrument as it is held for the note bore_frequency (Hz; 0: none) on a bore of that length:
/// with `tune`, a note and no length of one's own the lips are those of tuned(), else the valve is
/// as given. What the `ear` adds is left out.
[[nodiscard]] PlayingSetup embouchure_for(const Parameters& parameters, double bore_frequency,
                                          double length_m) noexcept;

} // namespace tactus::reed
