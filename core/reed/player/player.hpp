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

/// A note that a player was asked for and cannot play in tune.
struct Refusal {
  unsigned count = 0; ///< of notes refused so far
  double note = 0;    ///< the last of them: f_b, Hz
};

/// Who plays the instrument: from the pitch meant (f_b) to how valve and bore are held. With `tune
/// 0` the valve stays as given and f_b is a length; with `tune 1` the player chooses length and
/// lips for the note (tuning.hpp) and corrects what is heard out of tune (ear.hpp).
///
/// With breath_reference the lips also follow the mouth pressure p: with r = p/breath_reference,
/// smoothed (3 ms up, 60 ms down) and within kMinBreathRatio..kMaxBreathRatio, theta_0 goes as
/// r^breath_opening, stiffness and mass as r^breath_tension. With both 1/2 the jet's flow w x
/// sqrt(2 dp/rho) and the valve's force k x_0 grow as p, so that valve and linear bore behave alike
/// at every pressure, but for the channel's inertance and the swept flow; with less the ratio p/P_M
/// grows with p, as from a soft reed to a beating one.
///
/// A note below lowest_note or above highest_note (with half a semitone to spare) is refused: the
/// last good note goes on, or the nearest one when there has been none.
///
/// Where the instrument has settled on another register, which no trim brings back, the player
/// stops the air with the tongue and begins the note anew, up to kMaxAttempts times.
///
/// The tongue lets a breath go with a burst (tongue.hpp) that brings the valve to the share of its
/// closing pressure from which its notes grow fastest: 1 + burst goes as P_M/p, which is
/// r^(breath_opening + breath_tension - 1). Low notes have fewer cycles to grow in, so that the
/// push goes as f^(-3/2), and as r^(-1/2), for a loud one makes a reed's low notes jump; that of
/// lips, which are tuned to the note, as f^(-1/2) alone.
///
/// Called once per control period of Ear::kPeriod samples. Nothing here allocates.
class Player {
public:
  static constexpr double kMinBreathRatio = 0.1,
                          kMaxBreathRatio = 10; ///< bounds of p/breath_reference
  static constexpr int kMaxAttempts = 3;

  /// How the instrument is held.
  struct Configuration {
    Parameters valve{};               ///< the valve with the player's lips
    double length = 0.48;             ///< L, m
    double reed_scale = 1;            ///< factor on the f_r that the instrument is given
    double trim = 0;                  ///< of the ear: the bore is to sound sharper by exp(trim)
    const Termination* end = nullptr; ///< what the bore ends in; null: an open end
    double vent = 0;                  ///< share of the register vent that is open
    bool valve_changed = false;       ///< since the control period before
  };

  void prepare(double sample_rate) noexcept;
  /// Takes clamped parameters and the bore made of them. Where they change what notes need, that
  /// is forgotten.
  void set(const Parameters& parameters, const BoreDesign& bore) noexcept;
  void reset() noexcept;
  /// Holes that are fingered one by one, which must live on, in place of the fingerings of notes;
  /// null: those of notes again. The line then ends where the first open hole is, nobody corrects
  /// the pitch, and f_b has no say. vent: the share of the register vent that is open.
  void finger(const Termination* holes, double vent = 0) noexcept {
    holes_ = holes;
    holes_vent_ = vent;
    update_due_ = true;
  }

  /// Due once per control period: f_b in Hz (not above 0: the parameters' length), f_r in Hz, p_m
  /// in Pa (below 0, or no number: the lips stay as at breath_reference).
  const Configuration& control(double bore_frequency, double reed_frequency,
                               double mouth_pressure) noexcept;
  /// Whether a player plays a note: valve and bore then follow the hold at once.
  [[nodiscard]] bool plays() const noexcept { return plays_; }
  /// The note that the player plays, Hz, which is not f_b where that is refused or `fingering` set;
  /// 0 when nobody plays.
  [[nodiscard]] double note() const noexcept { return note_; }
  [[nodiscard]] const Refusal& refusal() const noexcept { return refusal_; }
  /// Whether the player wants to hear the bore pressure (listen()).
  [[nodiscard]] bool tracks_pitch() const noexcept { return tracks_pitch_; }
  /// The samples of bore pressure since, Pa; at most Ear::kPeriod between two calls of control().
  void track_pitch(const double* bore_pressure, int count) noexcept {
    tuning_controller_.track_pitch(bore_pressure, count);
  }

  /// The note is tongued: the breath stops for some 5 ms and comes back at once.
  void articulate() noexcept { tongue_.articulate(); }
  /// The next samples of mouth pressure, Pa, become what the tongue makes of them, at most
  /// `highest`; count is at most Ear::kPeriod. V as in ReedBank: of several breaths side by side
  /// the tongue goes by the first.
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
  double bore_frequency_ = 0; // as given
  double note_ = 0;           // f_b played, Hz; 0: none yet
  const Termination* holes_ = nullptr;
  double holes_vent_ = 0;
  Fingering fingering_{}; // of the note
  Parameters lips_{};     // for the note, at breath_reference
  BoreEnd fingering_end_ = BoreEnd::kOpen;
  double breath_ = 1;                    // p/breath_reference, smoothed and bounded
  double rise_gain_ = 1, fall_gain_ = 1; // of the smoothing, per control period
  double relative_closing_pressure_ = 1; // P_M/p, relative to that at breath_reference
  double note_reed_scale_ = 1;           // of f_r: the choice for the note, without the ear's trim
  Refusal refusal_{};
  bool refusing_ = false;
  int attempts_ = 0; // begun anew so often
  bool update_due_ = true, plays_ = false, tracks_pitch_ = false;
};

} // namespace tactus::reed
