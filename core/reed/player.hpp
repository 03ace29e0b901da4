#pragma once

#include "core/reed/bore_design.hpp"
#include "core/reed/ear.hpp"
#include "core/reed/length_table.hpp"
#include "core/reed/parameters.hpp"

namespace tactus::reed {

/// Who plays the instrument: from the pitch meant (f_b) to how valve and bore are held. With `tune
/// 0` the valve stays as given and f_b is a length; with `tune 1` the player chooses length and
/// lips for the note (tuning.hpp) and corrects what is heard out of tune (ear.hpp).
///
/// Called once per control period of Ear::kPeriod samples. Nothing here allocates.
class Player {
public:
  /// How the instrument is held.
  struct Hold {
    Parameters valve{};         ///< the valve with the player's lips
    double length = 0.48;       ///< L, m
    double reed_scale = 1;      ///< factor on the f_r that the instrument is given
    double trim = 0;            ///< of the ear: the bore is to sound sharper by exp(trim)
    bool valve_changed = false; ///< since the control period before
  };

  void prepare(double sample_rate) noexcept { ear_.prepare(sample_rate); }
  /// Takes clamped parameters and the bore made of them; what notes needed is forgotten.
  void set(const Parameters& parameters, const BoreDesign& bore) noexcept;
  void reset() noexcept { ear_.reset(); }

  /// Due once per control period: f_b in Hz (not above 0: the parameters' length), f_r in Hz.
  const Hold& control(double bore_frequency, double reed_frequency) noexcept;
  /// Whether a player plays a note: valve and bore then follow the hold at once.
  [[nodiscard]] bool plays() const noexcept { return plays_; }
  /// Whether the player wants to hear the bore pressure (listen()).
  [[nodiscard]] bool listens() const noexcept { return listens_; }
  /// The samples of bore pressure since, Pa; at most Ear::kPeriod between two calls of control().
  void listen(const double* bore_pressure, int count) noexcept {
    ear_.listen(bore_pressure, count);
  }

private:
  void set_trim(double logarithm, bool moved) noexcept;

  Parameters parameters_{};
  BoreDesign bore_{};
  LengthTable lengths_{};
  Ear ear_{};
  Hold hold_{};
  double bore_frequency_ = 0; // as given
  double note_ = 0;           // f_b played, Hz; 0: none yet
  double own_scale_ = 1;      // of f_r: the choice for the note, without the ear's trim
  bool due_ = true, plays_ = false, listens_ = false;
};

} // namespace tactus::reed
