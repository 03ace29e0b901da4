#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// The lengths that tuned() chooses, kept in steps of a quarter tone, so that a moving f_b costs
/// one search a step and nothing when it comes by again.
///
/// Between the steps the round trip of the bore runs straight: its phase at the note, in turns, is
/// what valve and open end ask of it, and that varies slowly with the note. A blown-open valve
/// plays a mode of a longer bore: while f_b glides it stays on that mode (slide and lips move
/// together), as long as the bore is not much shorter or longer than the instrument's own; a note
/// that is struck anew takes the mode nearest to that.
///
/// Fixed size, no allocation; two searches at most for each call of length().
class LengthTable {
public:
  /// Another instrument: all lengths are searched anew. The same parameters change nothing.
  void set(const Parameters& parameters) noexcept;
  /// L in m for the note at that f_r, both in Hz, with that fingering.
  /// leap: it has not been reached by gliding.
  [[nodiscard]] double length(double bore_frequency, double reed_frequency, bool leap,
                              const Fingering& fingering = {}) noexcept;

private:
  static constexpr double kLowest = 8; // Hz, of the first step
  static constexpr double kSteps = 24; // in an octave
  static constexpr std::size_t kCount = 220;
  struct Step {
    double turns = 0; // of the round trip
    bool computed = false;
    Fingering fingering{}; // of the bore that it is right for
  };

  double turns_at(std::size_t step, const Fingering& fingering) noexcept;

  Parameters parameters_{};
  double reed_frequency_ = 0; // for which the steps are right
  std::array<Step, kCount> steps_{};
  double turns_ = 0; // of the last note
};

} // namespace tactus::reed
