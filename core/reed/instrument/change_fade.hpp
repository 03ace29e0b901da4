#pragma once

#include "core/reed/instrument/oversampler.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// Hides a change that cannot be interpolated (a switch, a word, a number far away:
/// can_interpolate()). It is stepped once per control period. The sound fades out, the instrument
/// is changed, its transient passes unheard, and the sound fades in. If the air cannot continue
/// (can_continue()), it starts from rest in that silence, with a mouth pressure that rises slowly,
/// so that no attack is heard.
class ChangeFade {
public:
  static constexpr double kFadeOutTime = 0.008, kFadeInTime = 0.03; ///< s
  /// Silence after a change, s: for a note that continues, and for a note that starts from rest.
  static constexpr double kSettleTime = 0.03, kRestartTime = 0.15;

  void prepare(double control_rate) noexcept {
    fade_out_ = 1.0 / (static_cast<int>(kFadeOutTime * control_rate) + 1);
    fade_in_ = 1.0 / (static_cast<int>(kFadeInTime * control_rate) + 1);
    settle_periods_ = static_cast<int>(kSettleTime * control_rate) + 1;
    restart_periods_ = static_cast<int>(kRestartTime * control_rate) + 1;
  }
  void begin() noexcept { fades_out_ = true; }
  /// The change is a restart from rest.
  void begin_restart() noexcept { fades_out_ = restarts_ = true; }
  [[nodiscard]] bool restarts() const noexcept { return restarts_; }
  /// True if the sound fades out for a change.
  [[nodiscard]] bool fades_out() const noexcept { return fades_out_; }
  /// To be called when the change, or another that includes it, has been made.
  void changed() noexcept { fades_out_ = restarts_ = false; }
  /// Begins the silence after the change. restarted: the air starts from rest.
  void begin_silence(bool restarted) noexcept {
    silence_left_ = restarted ? restart_periods_ : settle_periods_;
    if (restarted)
      breath_to_ = 0;
  }
  /// Ends fades and silence, which are not needed while nothing sounds.
  void end_silence() noexcept {
    from_ = to_ = breath_from_ = breath_to_ = 1;
    silence_left_ = 0;
  }
  /// To be called once per control period. True when the sound has faded out and the change is due.
  bool step() noexcept {
    from_ = to_;
    breath_from_ = breath_to_;
    breath_to_ = step_toward(breath_to_, fade_in_);
    if (fades_out_ && from_ <= 0)
      return true;
    if (!fades_out_ && silence_left_ > 0) {
      --silence_left_;
      return false;
    }
    to_ = step_toward(to_, fades_out_ ? -fade_out_ : fade_in_);
    return false;
  }

  /// Factor of all outputs at the end of this control period.
  [[nodiscard]] double gain() const noexcept { return to_; }
  /// Factor of the mouth pressure at the end of this control period. It rises slowly after a
  /// restart. It does not fall while the sound fades out, because a reed that is released emits a
  /// pulse.
  [[nodiscard]] double breath_gain() const noexcept { return breath_to_; }
  /// Apply the factors to count samples, the first of them `phase` samples after the beginning of
  /// the control period.
  template <class V> void apply_to_breath(V* mouth_pressure, int phase, int count) const noexcept {
    if (breath_from_ < 1 || breath_to_ < 1)
      for (int i = 0; i < count; ++i)
        mouth_pressure[i] =
            V(breath_from_ + (breath_to_ - breath_from_) * share(phase + i)) * mouth_pressure[i];
  }
  template <class V> void apply_to(const ReedOutputs<V>& out, int phase, int count) const noexcept {
    if (from_ < 1 || to_ < 1)
      for (int i = 0; i < count; ++i) {
        const double gain = from_ + (to_ - from_) * share(phase + i);
        out.radiated[i] *= gain;
        for (V* signal : {out.angle, out.bore_pressure, out.flow})
          signal[i] = V(gain) * signal[i];
      }
  }

private:
  static double share(int phase) noexcept { return (phase + 1.0) / kControlPeriod; }
  /// One step towards 0 or 1, without rounding errors that would miss the end.
  static double step_toward(double from, double step) noexcept {
    const double next = from + step, tolerance = 0.5 * std::abs(step);
    return next < tolerance ? 0 : next > 1 - tolerance ? 1 : next;
  }

  int settle_periods_ = 1, restart_periods_ = 1, silence_left_ = 0; // control periods
  double fade_out_ = 1, fade_in_ = 1, from_ = 1, to_ = 1, breath_from_ = 1, breath_to_ = 1;
  bool fades_out_ = false, restarts_ = false;
};

} // namespace tactus::reed
