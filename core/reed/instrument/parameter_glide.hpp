#pragma once

#include "core/reed/instrument/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// Changes of parameters without clicks while an instrument sounds, stepped once per control
/// period.
///
/// Numbers are interpolated linearly over kTime. A change that cannot be interpolated (a switch, a
/// word, a number far away: can_interpolate()) happens in silence: the sound fades out, the
/// instrument is changed, its transient passes unheard, and the sound fades in. Where the air
/// cannot continue (can_continue()) it starts from rest in that silence, with a mouth pressure that
/// rises slowly, so that no attack is heard.
class ParameterGlide {
public:
  /// Durations, s: of the interpolation, of both fades.
  static constexpr double kTime = 0.016, kFadeOutTime = 0.008, kFadeInTime = 0.03;
  /// Silence after a change, s: of a note that continues, and of one that starts from rest.
  static constexpr double kSettleTime = 0.03, kRestartTime = 0.15;

  void prepare(double control_rate) noexcept {
    periods_ = static_cast<int>(kTime * control_rate) + 1;
    fade_out_ = 1.0 / (static_cast<int>(kFadeOutTime * control_rate) + 1);
    fade_in_ = 1.0 / (static_cast<int>(kFadeInTime * control_rate) + 1);
    settle_periods_ = static_cast<int>(kSettleTime * control_rate) + 1;
    restart_periods_ = static_cast<int>(kRestartTime * control_rate) + 1;
  }
  /// Takes these parameters at once and ends any change.
  void jump(const Parameters& parameters) noexcept {
    current_ = target_ = parameters;
    periods_left_ = 0;
    fades_out_ = restarts_ = false;
  }
  /// Requests a restart from rest in silence.
  void restart() noexcept { fades_out_ = restarts_ = true; }
  [[nodiscard]] bool restarts() const noexcept { return restarts_; }
  /// Ends fades and silence: where nothing sounds there is nothing to hide.
  void end_silence() noexcept {
    fade_from_ = fade_to_ = breath_gain_from_ = breath_gain_to_ = 1;
    silence_left_ = 0;
  }
  /// The sound has faded out and the instrument is changed. restarted: from rest.
  void begin_silence(bool restarted) noexcept {
    silence_left_ = restarted ? restart_periods_ : settle_periods_;
    if (restarted)
      breath_gain_to_ = 0;
  }
  /// Begins the change to the target.
  void begin(const Parameters& target) noexcept {
    periods_left_ = periods_;
    fades_out_ = fades_out_ || !can_interpolate(target_, target);
    if (!fades_out_)
      target_ = target;
  }
  [[nodiscard]] const Parameters& current() const noexcept { return current_; }
  /// The parameters last reached or approached, without the player's lips.
  [[nodiscard]] const Parameters& parameters() const noexcept { return target_; }
  /// Whether numbers are being interpolated.
  [[nodiscard]] bool is_moving() const noexcept { return periods_left_ > 0 && !fades_out_; }
  /// Whether the sound fades out for a change that cannot be interpolated.
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
  /// Once per control period while is_moving(). target: with the player's lips.
  void move(const Parameters& target) noexcept {
    current_ = periods_left_ == 1 ? target : interpolate(current_, target, 1.0 / periods_left_);
    --periods_left_;
  }
  /// Takes the valve as the player's lips hold it.
  void follow(const Parameters& held) noexcept { current_ = held; }

  /// Factor of all outputs at the beginning and at the end of this control period.
  [[nodiscard]] double fade_from() const noexcept { return fade_from_; }
  [[nodiscard]] double fade_to() const noexcept { return fade_to_; }
  /// The same of the mouth pressure, which rises slowly after a restart. It does not fall while the
  /// sound fades out: a reed that is released sends a pulse.
  [[nodiscard]] double breath_gain_from() const noexcept { return breath_gain_from_; }
  [[nodiscard]] double breath_gain_to() const noexcept { return breath_gain_to_; }

private:
  /// One step towards 0 or 1, without rounding errors that would miss the end.
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
