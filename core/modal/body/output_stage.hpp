#pragma once

#include "core/modal/body/body_model.hpp"
#include "core/modal/radiation/delay_line.hpp"

#include <array>
#include <cstddef>

namespace tactus::modal {

using DelayLines = std::array<DelayLine, kMaxListeners>;

/// Allocates for distances up to 34 m.
inline void prepare(DelayLines& lines, double sample_rate) {
  for (DelayLine& line : lines)
    line.prepare(static_cast<std::size_t>(0.1 * sample_rate) + 1);
}

/// From the sound at a body to the listeners: travel time, gain, limit.
class OutputStage {
public:
  void prepare(double sample_rate) {
    sample_rate_ = sample_rate;
    modal::prepare(delay_, sample_rate);
  }
  /// Sets the travel times of a model. `doppler`, `jump`: see DelayLine::set().
  void set_delays(const BodyModel& body, bool doppler, bool jump) noexcept;
  [[nodiscard]] DelayLines& delay_lines() noexcept { return delay_; }

  /// Gain in full scales for 1 Pa. It is smoothed while something sounds; in silence it is applied
  /// at once.
  void set_gain(double gain) noexcept;
  /// Delays the sound of each listener.
  void delay(ChannelBlock& sound, std::size_t listeners, std::size_t frames) noexcept;
  /// Applies the gain, and with `soft_limit` soft_clip() after it.
  void amplify(ChannelBlock& sound, std::size_t listeners, std::size_t frames,
               bool soft_limit) noexcept;
  /// True if the output has been zero for a while.
  [[nodiscard]] bool silent() const noexcept { return silent_samples_ >= kSilence; }

private:
  static constexpr std::size_t kSilence = 64; ///< samples of zeros that count as silence
  double sample_rate_ = 48000;
  DelayLines delay_{};
  double gain_ = 0.01, smooth_gain_ = 0.01;
  std::size_t silent_samples_ = kSilence; ///< sent since the last sound
};

} // namespace tactus::modal
