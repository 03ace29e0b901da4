#pragma once

#include "core/reed/bore_design.hpp"
#include "core/reed/ear.hpp"
#include "core/reed/length_table.hpp"
#include "core/reed/parameters.hpp"

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
/// smoothed (3 ms up, 60 ms down) and within kSoftest..kLoudest, theta_0 goes as r^breath_opening,
/// stiffness and mass as r^breath_tension. With both 1/2 the jet's flow w x sqrt(2 dp/rho) and the
/// valve's force k x_0 grow as p, so that valve and linear bore behave alike at every pressure, but
/// for the channel's inertance and the swept flow; with less the ratio p/P_M grows with p, as from
/// a soft reed to a beating one.
///
/// A note below lowest_note or above highest_note (with half a semitone to spare) is refused: the
/// last good note goes on, or the nearest one when there has been none.
///
/// Where the instrument has settled on another register, which no trim brings back, the player
/// stops the air with the tongue and begins the note anew, up to kTries times.
///
/// Called once per control period of Ear::kPeriod samples. Nothing here allocates.
class Player {
public:
  static constexpr double kSoftest = 0.1, kLoudest = 10; ///< bounds of p/breath_reference
  static constexpr int kTries = 3;

  /// How the instrument is held.
  struct Hold {
    Parameters valve{};               ///< the valve with the player's lips
    double length = 0.48;             ///< L, m
    double reed_scale = 1;            ///< factor on the f_r that the instrument is given
    double trim = 0;                  ///< of the ear: the bore is to sound sharper by exp(trim)
    double breath = 1;                ///< share of the mouth pressure that the tongue lets through
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
    due_ = true;
  }

  /// Due once per control period: f_b in Hz (not above 0: the parameters' length), f_r in Hz, p_m
  /// in Pa (below 0, or no number: the lips stay as at breath_reference).
  const Hold& control(double bore_frequency, double reed_frequency, double mouth_pressure) noexcept;
  /// Whether a player plays a note: valve and bore then follow the hold at once.
  [[nodiscard]] bool plays() const noexcept { return plays_; }
  /// The note that the player plays, Hz, which is not f_b where that is refused or `fingering` set;
  /// 0 when nobody plays.
  [[nodiscard]] double note() const noexcept { return note_; }
  [[nodiscard]] const Refusal& refusal() const noexcept { return refusal_; }
  /// Whether the player wants to hear the bore pressure (listen()).
  [[nodiscard]] bool listens() const noexcept { return listens_; }
  /// The samples of bore pressure since, Pa; at most Ear::kPeriod between two calls of control().
  void listen(const double* bore_pressure, int count) noexcept {
    ear_.listen(bore_pressure, count);
  }

private:
  [[nodiscard]] double playable(double frequency) noexcept;
  void choose(double reed_frequency) noexcept;
  [[nodiscard]] double held_tube() const noexcept;
  void finger(double frequency, bool leap) noexcept;
  void hold_holes() noexcept;
  void set_trim(double logarithm, bool moved) noexcept;
  bool follow_breath(double mouth_pressure) noexcept;
  void hold_valve() noexcept;
  void begin_anew(double reed_frequency) noexcept;
  void move_tongue() noexcept;

  Parameters parameters_{};
  BoreDesign bore_{};
  LengthTable lengths_{};
  Ear ear_{};
  Hold hold_{};
  double bore_frequency_ = 0; // as given
  double note_ = 0;           // f_b played, Hz; 0: none yet
  const Termination* holes_ = nullptr;
  double holes_vent_ = 0;
  Fingering fingering_{}; // of the note
  Parameters lips_{};     // for the note, at breath_reference
  BoreEnd fingered_for_ = BoreEnd::kOpen;
  double breath_ = 1;          // p/breath_reference, smoothed and bounded
  double rise_ = 1, fall_ = 1; // of the smoothing, per control period
  double own_scale_ = 1;       // of f_r: the choice for the note, without the ear's trim
  Refusal refusal_{};
  bool refuses_ = false;
  int tongue_ = 0, tries_ = 0; // control periods that the tongue stays; begun anew so often
  double control_rate_ = 1500; // Hz
  bool due_ = true, plays_ = false, listens_ = false;
};

} // namespace tactus::reed
