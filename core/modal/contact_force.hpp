#pragma once

#include "core/modal/striker.hpp"

namespace tactus::modal {

/// A contact law in series with a linear compliance C (m/N): compression = d + C f(d), what the
/// contact gives way by d and what lies behind it by C f.
struct SeriesContact {
  ContactLaw law;
  double compliance_m_per_n = 0;

  /// Elastic force at a compression, N.
  [[nodiscard]] double elastic(double compression_m) const noexcept;
  /// Work W stored at a compression, J.
  [[nodiscard]] double stored(double compression_m) const noexcept;
  /// Force of a step from compression `start` to `end` within `time_s`: the stored work over the
  /// way, (W(end) - W(start))/(end - start), times the loss 1 + mu way/time; never negative.
  /// It grows with `end`.
  [[nodiscard]] double mean_force(double start, double stored_at_start, double end,
                                  double time_s) const noexcept;
  /// The force of a step that would end at `free` without force and gives way by `answer` m/N:
  /// the root of d + answer F(d) = free. `guess`: a force that may be near.
  [[nodiscard]] double solve(double start, double free, double answer, double time_s,
                             double guess) const noexcept;

private:
  /// The same for a ball that stays in contact without loss; -1 where it does not stay.
  [[nodiscard]] double solve_ball(double start, double free, double answer,
                                  double guess) const noexcept;
};

} // namespace tactus::modal
