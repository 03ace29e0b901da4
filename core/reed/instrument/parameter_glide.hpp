#pragma once

#include "core/reed/instrument/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// How parameters change while an instrument sounds, in control periods: numbers run straight from
/// what they are to what they are to be; for what has no way in between (a switch, a word, a size
/// far away: near() in parameters.hpp), the sound fades out, the instrument is changed in silence,
/// and the sound fades in again when what the change does to the note is over. Where the air cannot
/// go on (another kind of instrument), it is blown anew in that silence, by a breath that swells:
/// an attack is no part of the change.
class ParameterGlide {
public:
  /// Seconds that numbers take, and that the sound takes to fade out or in.
  static constexpr double kTime = 0.016, kFadeOutTime = 0.008, kFadeInTime = 0.03;
  /// Seconds of silence after a change: of a note that goes on, and of one that is blown anew.
  static constexpr double kSettleTime = 0.03, kRestartTime = 0.15;

  void prepare(double control_rate) noexcept {
    periods_ = static_cast<int>(kTime * control_rate) + 1;
    fade_out_ = 1.0 / (static_cast<int>(kFadeOutTime * control_rate) + 1);
    fade_in_ = 1.0 / (static_cast<int>(kFadeInTime * control_rate) + 1);
    settle_periods_ = static_cast<int>(kSettleTime * control_rate) + 1;
    restart_periods_ = static_cast<int>(kRestartTime * control_rate) + 1;
  }
  /// The instrument is this now, and no number is on its way.
  void jump(const Parameters& parameters) noexcept {
    current_ = target_ = parameters;
    periods_left_ = 0;
    fades_out_ = restarts_ = false;
  }
  /// It is to be as new, with its valve at rest and its air still.
  void restart() noexcept { fades_out_ = restarts_ = true; }
  [[nodiscard]] bool restarts() const noexcept { return restarts_; }
  /// Nothing sounds yet that would have to fade.
  void end_silence() noexcept {
    fade_from_ = fade_to_ = breath_gain_from_ = breath_gain_to_ = 1;
    silence_left_ = 0;
  }
  /// The sound has faded out and the instrument is changed; `anew`: its air is at rest.
  void begin_silence(bool restarted) noexcept {
    silence_left_ = restarted ? restart_periods_ : settle_periods_;
    if (restarted)
      breath_gain_to_ = 0;
  }
  /// It is to become something else.
  void begin(const Parameters& target) noexcept {
    periods_left_ = periods_;
    fades_out_ = fades_out_ || !can_interpolate(target_, target);
    if (!fades_out_)
      target_ = target;
  }
  [[nodiscard]] const Parameters& current() const noexcept { return current_; }
  /// What that is made from, the player's lips aside.
  [[nodiscard]] const Parameters& parameters() const noexcept { return target_; }
  /// Whether numbers are on their way.
  [[nodiscard]] bool is_moving() const noexcept { return periods_left_ > 0 && !fades_out_; }
  /// Whether the sound fades out for a change that has no way in between.
  [[nodiscard]] bool fades_out() const noexcept { return fades_out_; }

  /// Once per control period; true when the sound has faded out: jump() is due.
  bool fade() noexcept {
    fade_from_ = fade_to_;
    breath_gain_from_ = breath_gain_to_;
    breath_gain_to_ = step_toward(breath_gain_to_, fade_in_);
    if (fades_out_ && fade_from_ <= 0)
      return true;
    if (!fades_out_ && silence_left_ > 0) {
      --silence_left_;
      return false;
    }
    fade_to_ = step_toward(fade_to_, fades_out_ ? -fade_out_ : fade_in_);
    return false;
  }
  /// Once per control period while moves(), target being what is wanted by now.
  void move(const Parameters& target) noexcept {
    current_ = periods_left_ == 1 ? target : interpolate(current_, target, 1.0 / periods_left_);
    --periods_left_;
  }
  /// The instrument is held otherwise, by its player.
  void follow(const Parameters& held) noexcept { current_ = held; }

  /// Factor of all outputs at the beginning and at the end of this control period.
  [[nodiscard]] double fade_from() const noexcept { return fade_from_; }
  [[nodiscard]] double fade_to() const noexcept { return fade_to_; }
  /// The same of the mouth pressure, which swells where the instrument is blown anew. A sound that
  /// fades out keeps its breath: a reed that is let go sends a pulse.
  [[nodiscard]] double breath_gain_from() const noexcept { return breath_gain_from_; }
  [[nodiscard]] double breath_gain_to() const noexcept { return breath_gain_to_; }

private:
  /// A step on the way to 0 or 1.
  static double step_toward(double from, double step) noexcept {
    const double next = from + step, tolerance = 0.5 * std::abs(step);
    return next < tolerance ? 0 : next > 1 - tolerance ? 1 : next;
  }

  Parameters current_{}, target_{};
  int periods_ = 1, periods_left_ = 0;
  int settle_periods_ = 1, restart_periods_ = 1, silence_left_ = 0; // control periods of silence
  double fade_out_ = 1, fade_in_ = 1, fade_from_ = 1, fade_to_ = 1;
  double breath_gain_from_ = 1, breath_gain_to_ = 1;
  bool fades_out_ = false, restarts_ = false;
};

} // namespace tactus::reed
