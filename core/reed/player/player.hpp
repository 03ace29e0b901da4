#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/length_table.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/player/tongue.hpp"
#include "core/reed/player/tuning_controller.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// Notes outside the compass that were requested and refused.
struct Refusal {
  unsigned count = 0; ///< number of notes refused so far
  double note = 0;    ///< the last refused note: f_b, Hz
};

/// A model of the player: from the target note f_b to the settings of valve and bore. With `tune 0`
/// the valve stays as given and f_b sets the length alone. With `tune 1` the player chooses length
/// and lips for the note (tuning.hpp) and corrects the pitch (tuning_controller.hpp).
///
/// Breath: with breath_reference > 0 the lips follow the mouth pressure p. r = p/breath_reference
/// is smoothed (3 ms up, 60 ms down) and limited to kMinBreathRatio..kMaxBreathRatio; theta_0 is
/// multiplied by r^breath_opening, stiffness and mass by r^breath_tension. If both powers are 1/2,
/// the jet's flow w x sqrt(2 dp/rho) and the valve's force k x_0 grow as p. Valve and linear bore
/// then behave alike at every pressure, except for the channel's inertance and the swept flow. With
/// smaller powers p/P_M grows with p, from a soft sound to a beating reed.
///
/// Compass: a note below lowest_note or above highest_note (half a semitone to spare) is refused.
/// The last good note continues, or the nearest limit when there was none.
///
/// Registers: if another register sounds, which no trim corrects, the player tongues the note
/// again, every other time with a soft attack, up to kMaxAttempts times.
///
/// Tongue: the burst (tongue.hpp) brings the valve to the ratio of pressure to closing pressure at
/// which notes grow fastest. 1 + burst is proportional to P_M/p, that is r^(breath_opening +
/// breath_tension - 1). A low note has fewer cycles to grow in, so that the excess goes as f^(-3/2)
/// and, because a strong one makes a reed's low notes jump, as r^(-1/2). For lips, which are tuned
/// to the note, it goes as f^(-1/2) alone.
///
/// Called once per control period. Nothing here allocates.
class Player {
public:
  static constexpr double kMinBreathRatio = 0.1,
                          kMaxBreathRatio = 10; ///< bounds of p/breath_reference
  static constexpr int kMaxAttempts = 3;

  /// Settings of valve and bore for the present note and breath.
  struct Configuration {
    Parameters valve{};               ///< the valve with the player's lips
    double length = 0.48;             ///< L, m
    double reed_scale = 1;            ///< factor on the f_r that the instrument is given
    double trim = 0;                  ///< ln of the factor on the pitch, by TuningController
    const Termination* end = nullptr; ///< end of the bore; null: an open end
    double vent = 0;                  ///< share of the register vent that is open
    bool valve_changed = false;       ///< the valve has changed since the last control period
  };

  void prepare(double sample_rate) noexcept;
  /// Takes clamped parameters and their bore. Lengths and corrections of notes are cleared if the
  /// parameters affect them.
  void set(const Parameters& parameters, const BoreDesign& bore) noexcept;
  void reset() noexcept;
  /// Sets holes fingered one by one in place of the fingerings of notes; null: the fingerings of
  /// notes again. holes must outlive their use. The bore then ends at the first open hole, the
  /// pitch is not corrected, and f_b is ignored. vent: share of the register vent that is open.
  void finger(const Termination* holes, double vent = 0) noexcept {
    holes_ = holes;
    holes_vent_ = vent;
    update_due_ = true;
  }

  /// To be called once per control period: f_b in Hz (0 or less: the parameters' length), f_r in
  /// Hz, p_m in Pa (below 0 or NaN: the lips stay as at breath_reference).
  const Configuration& control(double bore_frequency, double reed_frequency,
                               double mouth_pressure) noexcept;
  /// Whether the player plays a note: valve and bore then follow without low-pass.
  [[nodiscard]] bool plays() const noexcept { return plays_; }
  /// The note being played, Hz; not f_b if f_b is refused or `fingering` is set. 0: none.
  [[nodiscard]] double note() const noexcept { return note_; }
  [[nodiscard]] const Refusal& refusal() const noexcept { return refusal_; }
  /// Whether the pitch is corrected, which needs track_pitch().
  [[nodiscard]] bool tracks_pitch() const noexcept { return tracks_pitch_; }
  /// Takes the samples of bore pressure since control(), Pa; at most kControlPeriod of them.
  void track_pitch(const double* bore_pressure, int count) noexcept {
    tuning_controller_.track_pitch(bore_pressure, count);
  }

  /// Tongues the note: the breath stops for some 5 ms and returns at once.
  void articulate() noexcept { tongue_.articulate(); }
  /// Applies the tongue to count <= kControlPeriod samples of mouth pressure, Pa, in place, limited
  /// to `highest`. V is that of ReedBank; if there are several lanes, the first controls the
  /// tongue.
  template <class V> void apply_tongue(V* mouth_pressure, int count, double highest) noexcept {
    if (!plays_)
      return;
    std::array<double, TuningController::kPeriod> pressure{}, factor;
    for (int i = 0; i < count; ++i)
      pressure[static_cast<std::size_t>(i)] = static_cast<double>(simd::lane(mouth_pressure[i], 0));
    if (tongue_.factors(pressure.data(), factor.data(), count))
      for (int i = 0; i < count; ++i)
        mouth_pressure[i] =
            simd::minimum(V(factor[static_cast<std::size_t>(i)]) * mouth_pressure[i], V(highest));
  }

private:
  [[nodiscard]] double accept_note(double frequency) noexcept;
  void choose_configuration(double reed_frequency) noexcept;
  [[nodiscard]] double fixed_tube_length() const noexcept;
  void finger(double frequency, bool leap) noexcept;
  void use_open_holes() noexcept;
  void set_trim(double logarithm, bool moved) noexcept;
  [[nodiscard]] double burst() const noexcept;
  bool follow_breath(double mouth_pressure) noexcept;
  void update_lips() noexcept;
  void retry_note(double reed_frequency) noexcept;

  Parameters parameters_{};
  BoreDesign bore_{};
  LengthTable lengths_{};
  TuningController tuning_controller_{};
  Tongue tongue_{};
  Configuration configuration_{};
  double bore_frequency_ = 0; // f_b as given
  double note_ = 0;           // f_b played, Hz; 0: none yet
  const Termination* holes_ = nullptr;
  double holes_vent_ = 0;
  Fingering fingering_{}; // fingering of the note
  Parameters lips_{};     // lips for the note, at breath_reference
  BoreEnd fingering_end_ = BoreEnd::kOpen;
  double breath_ = 1;                    // p/breath_reference, smoothed and bounded
  double rise_gain_ = 1, fall_gain_ = 1; // gains of the smoothing, per control period
  double relative_closing_pressure_ = 1; // P_M/p, relative to that at breath_reference
  double note_reed_scale_ = 1;           // factor on f_r for the note, without the trim
  Refusal refusal_{};
  bool refusing_ = false;
  int attempts_ = 0; // restarts of the present note
  bool update_due_ = true, plays_ = false, tracks_pitch_ = false;
};

} // namespace tactus::reed
