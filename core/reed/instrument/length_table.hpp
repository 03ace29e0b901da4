#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <array>
#include <cstddef>
#include <optional>

namespace tactus::reed {

/// Cache of the bore lengths that tuned() finds, one per quarter tone: a moving f_b costs one
/// search per quarter tone, once.
///
/// Between the entries the phase of the bore's round trip at the note, in turns, is interpolated
/// linearly. Valve and open end determine that phase, and it varies slowly with the note.
///
/// A blown-open valve plays one of several modes of a longer bore. While f_b glides, the valve
/// stays on its mode, as long as the bore is not much shorter or longer than the instrument's own.
/// A note that is reached by a leap takes the mode whose bore is nearest to that length.
///
/// Fixed size, no allocation; at most two searches per call of length(), 6 to 16 us each.
class LengthTable {
public:
  /// Sets the instrument and clears the table. same_mode: the next note stays on the mode of the
  /// last one, as in a glide.
  void set(const Parameters& parameters, bool same_mode) noexcept;
  /// L, m, for a note bore_frequency at the given f_r, both in Hz, with the given fingering. leap:
  /// the note was not reached by gliding.
  [[nodiscard]] double length(double bore_frequency, double reed_frequency, bool leap,
                              const Fingering& fingering = {}) noexcept;

private:
  static constexpr double kLowest = 8; // Hz, of the first entry
  static constexpr double kSteps = 24; // entries per octave
  static constexpr std::size_t kCount = 220;
  struct Step {
    double turns = 0; // turns of the round trip
    bool computed = false;
    Fingering fingering{}; // fingering for which it was computed
  };

  double turns_at(std::size_t step, const Fingering& fingering) noexcept;

  Parameters parameters_{};
  double reed_frequency_ = 0; // f_r for which the steps were computed, Hz
  std::array<Step, kCount> steps_{};
  std::optional<double> turns_{}; // turns of the last note
};

} // namespace tactus::reed
