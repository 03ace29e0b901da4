#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tactus::footstep {

/// The room around a step: what walls, ceiling and furniture send back, as a diffuse field that
/// dies down exponentially. Eight delays of 7 to 29 ms (paths of 2.4 to 10 m) fed back through an
/// orthogonal matrix (Stautner & Puckette 1982; Jot & Chaigne 1991): each loses 60 dB in t60, and
/// in half of that at `bright_hz`, by a one-pole filter solved for it.
/// In a diffuse field the energy of the room's answer over the direct sound's is the square of the
/// distance in critical distances (Kuttruff, Room Acoustics, ch. 5); that ratio is the level.
class Room {
public:
  static constexpr double kMinLevel = -60; ///< dB, no room from there down

  struct Settings {
    double level_db = kMinLevel; ///< energy of the answer over the direct sound's
    double t60_s = 0.3;
    double bright_hz = 4000; ///< where the decay time is half

    friend bool operator==(const Settings&, const Settings&) = default;
  };

  void prepare(double sample_rate); ///< may allocate
  void set(const Settings& settings) noexcept;
  void reset() noexcept;
  /// One sample of the direct sound in, the room's answer out, without the direct sound.
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
  long ring_out_samples_ = 0,
       ring_out_left_ = 0; ///< samples until 90 dB are lost: of a sound, of what still sounds
  std::array<Line, kLines> lines_;
  std::array<double, kLines> gain_{}, pole_{}, filter_state_{}; ///< of each line's filter
};

} // namespace tactus::footstep
