#pragma once

#include "core/reed/bore/hole_fingering.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/reed_bank.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// A pressure-controlled valve (reed, lips, vocal folds, syrinx) on a bore, played by mouth
/// pressure, reed frequency and bore frequency. Generalised reed of Smyth, Abel & Smith (2005)
/// after the equations of docs/greed.md.
///
/// prepare() allocates; everything else is bounded and allocates nothing, for any input. The same
/// input gives the same bits however the stream is cut into blocks.
class Instrument {
public:
  /// Largest mouth pressure taken, Pa; what lies beyond is clamped.
  static constexpr double kHighestPressure = ReedBank<double>::kHighestPressure;

  /// sample_rate in Hz. Called again with the same rate, the sound goes on; another rate starts the
  /// air from rest. Blocks of any size are taken, whatever max_block says.
  void prepare(double sample_rate, std::size_t max_block);
  /// Takes the nearest usable parameters (see clamped()). Another oversampling stills the air.
  /// While it sounds, numbers take some 16 ms, and switches and words fade the sound out and in.
  void set(const Parameters& parameters) noexcept {
    if (parameters.end != bank_.parameters().end)
      bank_.finger(nullptr);
    bank_.set(parameters);
  }
  [[nodiscard]] const Parameters& parameters() const noexcept { return bank_.parameters(); }
  /// The note is tongued: the breath stops for some 5 ms and comes back at once. Only a player
  /// (`tune 1`) has a tongue.
  void articulate() noexcept { bank_.articulate(); }
  /// With tune: fingers the holes of Parameters::end one by one, the register vent and then the
  /// tone holes from the reed down (1 closed, 0 open, in between partly covered), until
  /// release_holes() or another end. A state that has not been fingered lately takes some
  /// milliseconds of computation. False, and the fingering as before, where the end has another
  /// number of holes, a number is not within 0..1 or nothing is found.
  [[nodiscard]] bool finger_holes(std::span<const double> closed) noexcept;
  /// The fingerings of notes again.
  void release_holes() noexcept { bank_.finger(nullptr); }
  /// Valve at rest, air still, noise from its beginning.
  void reset() noexcept;
  /// The same for an instrument that sounds, without a click: within 8 ms, and the note, blown
  /// anew, is heard after another 0.15 s.
  void restart() noexcept { bank_.restart(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return bank_.length(); }

  /// The notes that the player refused, with `tune` (Parameters::lowest_note, highest_note).
  [[nodiscard]] const Refusal& refusal() const noexcept { return bank_.refusal(); }

  /// One block; all spans of the same length, outputs may be inputs.
  /// mouth_pressure p_m in Pa.
  /// reed_frequency f_r in Hz: not above 0 means the parameters' own.
  /// bore_frequency f_b in Hz: not above 0 means the parameters' length.
  /// Of each, no number means the last good one; an infinite frequency too.
  /// sound: gain times the pressure at 1 m, linear to 0.5, within +-1.
  /// theta in rad, p_b in Pa, U in m^3/s; with oversampling 2 (4) all four come 7.5 (9.25) samples
  /// later.
  template <class S>
  void process(std::span<const S> mouth_pressure, std::span<const S> reed_frequency,
               std::span<const S> bore_frequency, std::span<S> sound, std::span<S> theta,
               std::span<S> bore_pressure, std::span<S> flow) noexcept;

private:
  static constexpr std::size_t kBlock = ReedBank<double>::kControlPeriod;
  ReedBank<double> bank_;
  // Copies of an instrument share it: what a bore ends in stays where it is.
  std::shared_ptr<HoleFingerings> fingerings_ = std::make_shared<HoleFingerings>();
  void move_gain() noexcept;

  double gain_ = 0, gain_step_ = 0;        // at the end of this control period, and the way there
  double target_gain_ = 0, gain_rate_ = 0; // a control period
  double gain_periods_ = 1;
  bool gain_unset_ = true; // not yet taken from the parameters
  double last_pressure_ = 0, reed_frequency_ = 0, bore_frequency_ = 0;
};

} // namespace tactus::reed
