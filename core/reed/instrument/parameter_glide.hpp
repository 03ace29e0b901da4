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
  static constexpr double kSettleTime = 0.03, kSpeakTime = 0.15;

  void prepare(double control_rate) noexcept {
    periods_ = static_cast<int>(kTime * control_rate) + 1;
    fade_out_ = 1.0 / (static_cast<int>(kFadeOutTime * control_rate) + 1);
    fade_in_ = 1.0 / (static_cast<int>(kFadeInTime * control_rate) + 1);
    settling_ = static_cast<int>(kSettleTime * control_rate) + 1;
    speaking_ = static_cast<int>(kSpeakTime * control_rate) + 1;
  }
  /// The instrument is this now, and no number is on its way.
  void jump(const Parameters& parameters) noexcept {
    now_ = wanted_ = parameters;
    left_ = 0;
    fades_out_ = restarts_ = false;
  }
  /// It is to be as new, with its valve at rest and its air still.
  void restart() noexcept { fades_out_ = restarts_ = true; }
  [[nodiscard]] bool restarts() const noexcept { return restarts_; }
  /// Nothing sounds yet that would have to fade.
  void full() noexcept {
    loudness_from_ = loudness_to_ = breath_from_ = breath_to_ = 1;
    silent_ = 0;
  }
  /// The sound has faded out and the instrument is changed; `anew`: its air is at rest.
  void proceed(bool anew) noexcept {
    silent_ = anew ? speaking_ : settling_;
    if (anew)
      breath_to_ = 0;
  }
  /// It is to become something else.
  void begin(const Parameters& target) noexcept {
    left_ = periods_;
    fades_out_ = fades_out_ || !near(wanted_, target);
    if (!fades_out_)
      wanted_ = target;
  }
  [[nodiscard]] const Parameters& now() const noexcept { return now_; }
  /// What that is made from, the player's lips aside.
  [[nodiscard]] const Parameters& parameters() const noexcept { return wanted_; }
  /// Whether numbers are on their way.
  [[nodiscard]] bool moves() const noexcept { return left_ > 0 && !fades_out_; }
  /// Whether the sound fades out for a change that has no way in between.
  [[nodiscard]] bool fades_out() const noexcept { return fades_out_; }

  /// Once per control period; true when the sound has faded out: jump() is due.
  bool fade() noexcept {
    loudness_from_ = loudness_to_;
    breath_from_ = breath_to_;
    breath_to_ = toward(breath_to_, fade_in_);
    if (fades_out_ && loudness_from_ <= 0)
      return true;
    if (!fades_out_ && silent_ > 0) {
      --silent_;
      return false;
    }
    loudness_to_ = toward(loudness_to_, fades_out_ ? -fade_out_ : fade_in_);
    return false;
  }
  /// Once per control period while moves(), target being what is wanted by now.
  void move(const Parameters& target) noexcept {
    now_ = left_ == 1 ? target : between(now_, target, 1.0 / left_);
    --left_;
  }
  /// The instrument is held otherwise, by its player.
  void follow(const Parameters& held) noexcept { now_ = held; }

  /// Factor of all outputs at the beginning and at the end of this control period.
  [[nodiscard]] double loudness_from() const noexcept { return loudness_from_; }
  [[nodiscard]] double loudness_to() const noexcept { return loudness_to_; }
  /// The same of the mouth pressure, which swells where the instrument is blown anew. A sound that
  /// fades out keeps its breath: a reed that is let go sends a pulse.
  [[nodiscard]] double breath_from() const noexcept { return breath_from_; }
  [[nodiscard]] double breath_to() const noexcept { return breath_to_; }

private:
  /// A step on the way to 0 or 1.
  static double toward(double from, double step) noexcept {
    const double next = from + step, small = 0.5 * std::abs(step);
    return next < small ? 0 : next > 1 - small ? 1 : next;
  }

  Parameters now_{}, wanted_{};
  int periods_ = 1, left_ = 0;
  int settling_ = 1, speaking_ = 1, silent_ = 0; // control periods of silence
  double fade_out_ = 1, fade_in_ = 1, loudness_from_ = 1, loudness_to_ = 1;
  double breath_from_ = 1, breath_to_ = 1;
  bool fades_out_ = false, restarts_ = false;
};

} // namespace tactus::reed
