#pragma once

#include "core/reed/bore/hole_fingering.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/reed_bank.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::reed {

/// A wind instrument: a pressure-controlled valve (reed, lips, vocal folds, syrinx) on a bore,
/// played by mouth pressure, reed frequency and bore frequency.
///
/// Generalised reed of Smyth, Abel & Smith (2005); equations, units and limits are in
/// docs/theory/greed.md. All quantities are SI. prepare() allocates; everything else is bounded and
/// allocates nothing, for any input. The same input gives the same bits however the stream is cut
/// into blocks.
class Instrument {
public:
  /// Limit of |mouth pressure|, Pa; larger values are clamped.
  static constexpr double kHighestPressure = ReedBank<double>::kHighestPressure;

  /// sample_rate in Hz, clamped to 1 kHz..1 MHz. The same rate again changes nothing; another rate
  /// starts the air from rest. Blocks may have any size, independent of max_block.
  void prepare(double sample_rate, std::size_t max_block);
  /// Takes the nearest usable parameters (clamped()). While the instrument sounds, numbers are
  /// interpolated over about 16 ms; switches and words fade the sound out and in (ChangeFade).
  /// Another oversampling starts the air from rest.
  void set(const Parameters& parameters) noexcept {
    if (parameters.end != bank_.parameters().end)
      bank_.finger(nullptr);
    bank_.set(parameters);
  }
  [[nodiscard]] const Parameters& parameters() const noexcept { return bank_.parameters(); }
  /// Tongues the note: the breath stops for some 5 ms and returns at once. Only with `tune`, which
  /// enables the player model.
  void articulate() noexcept { bank_.articulate(); }
  /// With `tune`: sets the holes of Parameters::end one by one, the register vent and then the tone
  /// holes from the reed down (1 closed, 0 open, in between partly covered), until release_holes()
  /// or another end. A state that is not among the last 32 takes some milliseconds of computation.
  /// Returns false, without any change, when the end has another number of holes, a number is not
  /// within 0..1 or no filter is found.
  [[nodiscard]] bool finger_holes(std::span<const double> closed) noexcept;
  /// Returns to the standard fingerings of notes.
  void release_holes() noexcept { bank_.finger(nullptr); }
  /// Sets valve and air to rest and restarts the noise sequence.
  void reset() noexcept;
  /// reset() without a click while the instrument sounds: the sound fades out in 8 ms, and the
  /// note's new start is heard 0.15 s later.
  void restart() noexcept { bank_.restart(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return bank_.length(); }

  /// Notes outside Parameters::lowest_note..highest_note, which the player refused (with `tune`).
  [[nodiscard]] const Refusal& refusal() const noexcept { return bank_.refusal(); }

  /// Control signals of a block. NaN or an infinite frequency means the last good value.
  template <class S> struct Controls {
    std::span<const S> mouth_pressure; ///< p_m, Pa
    std::span<const S> reed_frequency; ///< f_r, Hz; 0 or less: that of the parameters
    std::span<const S> bore_frequency; ///< f_b, Hz; 0 or less: the parameters' length
  };
  /// Output signals of a block. With oversampling 2 (4) all four are 7.5 (9.25) samples late.
  template <class S> struct Outputs {
    std::span<S> sound;         ///< gain times the pressure at 1 m, linear to 0.5, within +-1
    std::span<S> theta;         ///< angle of the valve, rad
    std::span<S> bore_pressure; ///< p_b, Pa
    std::span<S> flow;          ///< U, m^3/s
  };
  /// Computes one block; all spans have the same length, and outputs may be inputs.
  template <class S> void process(const Controls<S>& in, const Outputs<S>& out) noexcept;

private:
  static constexpr std::size_t kBlock = ReedBank<double>::kControlPeriod;
  ReedBank<double> bank_;
  // Shared by copies of an instrument, because the bank keeps pointers into it.
  std::shared_ptr<HoleFingerings> fingerings_ = std::make_shared<HoleFingerings>();
  void update_gain() noexcept;
  void read_mouth_pressure(double* mouth, std::size_t count) noexcept;
  void apply_gain(double* radiated, std::size_t count) const noexcept;

  double gain_ = 0, gain_step_ = 0;        // gain at the end of this control period; change within
                                           // it
  double target_gain_ = 0, gain_rate_ = 0; // target of the ramp; change per control period
  double gain_periods_ = 1;                // control periods of a ramp
  bool gain_unset_ = true;                 // not yet taken from the parameters
  double last_pressure_ = 0, reed_frequency_ = 0, bore_frequency_ = 0;
};

} // namespace tactus::reed
