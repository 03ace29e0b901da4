#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tactus::footstep {

/// Reverberation of a room: a feedback delay network of eight delays of 7 to 29 ms (paths of 2.4 to
/// 10 m) with an orthogonal feedback matrix (Stautner & Puckette 1982; Jot & Chaigne 1991). Every
/// delay decays by 60 dB in t60; a one-pole filter halves this time at `bright_hz`. The level is
/// the energy of the reverberation over that of the direct sound. In a diffuse field it is (r /
/// r_c)^2 at the distance r, with the critical distance r_c (Kuttruff, Room Acoustics, ch. 5).
class Room {
public:
  static constexpr double kMinLevel = -60; ///< dB; at this level and below there is no room

  struct Settings {
    double level_db = kMinLevel; ///< energy of the reverberation over that of the direct sound
    double t60_s = 0.3;
    double bright_hz = 4000; ///< frequency at which the decay time is t60_s / 2

    friend bool operator==(const Settings&, const Settings&) = default;
  };

  void prepare(double sample_rate); ///< may allocate
  void set(const Settings& settings) noexcept;
  void reset() noexcept;
  /// Computes one sample: direct sound in, reverberation out, without the direct sound.
  double next(double direct) noexcept;
  [[nodiscard]] bool silent() const noexcept { return ring_out_left_ == 0; }

private:
  static constexpr std::size_t kLines = 8;
  struct Line {
    std::vector<double> samples;
    std::size_t at = 0;
  };

  Settings settings_;
  double sample_rate_ = 48000;
  double level_ = 0;
  long ring_out_samples_ = 0; ///< samples in which a sound decays by 90 dB
  long ring_out_left_ = 0;    ///< samples until the present sound has decayed
  std::array<Line, kLines> lines_;
  std::array<double, kLines> gain_{}, pole_{}, filter_state_{}; ///< filter of each delay
};

} // namespace tactus::footstep
