#pragma once

#include "core/reed/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// How parameters change while an instrument sounds, in control periods: numbers run straight from
/// what they are to what they are to be; for what has no way in between (a switch, a word, a size
/// far away: near() in parameters.hpp), the sound fades out, the instrument is changed in silence,
/// and it is blown anew.
class ParameterGlide {
public:
  /// Seconds that numbers take, and that the sound takes to fade out or in.
  static constexpr double kTime = 0.016, kFadeOutTime = 0.008, kFadeInTime = 0.03;

  void prepare(double control_rate) noexcept {
    periods_ = static_cast<int>(kTime * control_rate) + 1;
    fade_out_ = 1.0 / (static_cast<int>(kFadeOutTime * control_rate) + 1);
    fade_in_ = 1.0 / (static_cast<int>(kFadeInTime * control_rate) + 1);
  }
  /// The instrument is this now, and no number is on its way.
  void jump(const Parameters& parameters) noexcept {
    now_ = wanted_ = parameters;
    left_ = 0;
    fades_out_ = false;
  }
  /// Nothing sounds yet that would have to fade.
  void full() noexcept { loudness_from_ = loudness_to_ = 1; }
  /// It is to become something else.
  void begin(const Parameters& target) noexcept {
    left_ = periods_;
    fades_out_ = fades_out_ || !near(wanted_, target);
    if (!fades_out_)
      wanted_ = target;
  }
  [[nodiscard]] const Parameters& now() const noexcept { return now_; }
  /// Whether numbers are on their way.
  [[nodiscard]] bool moves() const noexcept { return left_ > 0 && !fades_out_; }
  /// Whether the sound fades out for a change that has no way in between.
  [[nodiscard]] bool fades_out() const noexcept { return fades_out_; }

  /// Once per control period; true when the sound has faded out: jump() is due.
  bool fade() noexcept {
    loudness_from_ = loudness_to_;
    if (fades_out_ && loudness_from_ <= 0)
      return true;
    const double step = fades_out_ ? -fade_out_ : fade_in_, next = loudness_from_ + step;
    const double small = 0.5 * std::abs(step);
    loudness_to_ = next < small ? 0 : next > 1 - small ? 1 : next;
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

private:
  Parameters now_{}, wanted_{}; // wanted_: what now_ is made from, the player's lips aside
  int periods_ = 1, left_ = 0;
  double fade_out_ = 1, fade_in_ = 1, loudness_from_ = 1, loudness_to_ = 1;
  bool fades_out_ = false;
};

} // namespace tactus::reed
