#pragma once

#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Plane waves of finite amplitude over some way, as weak-shock theory has them: a piece of the
/// wave a(t) arrives earlier by its pressure, at
///   tau = t - s(a),   s = lead * a, at most kMaxShift either way,
/// and where pieces overtake one another the wave breaks: a shock stands where it cuts off equal
/// areas of the multivalued wave (Whitham, Linear and Nonlinear Waves, section 2.8).
///
/// Both follow from the potential Psi(tau) = int y dtau of the wave that arrives. Along the piece
/// that left at t it is
///   Psi = int a dt - lead c^2/2,   c = s/lead,
/// and of several pieces that arrive together the one with the largest potential is heard (Hopf and
/// Lax's formula; the areas between two equal potentials are equal). Psi is put on the grid of
/// samples by cubic Hermite interpolation, its slope at each node being the pressure there, and
/// what is given out is its rise over each sample: the mean of the wave over that sample, so that a
/// shock keeps its place between samples and aliases as little as a step that went through a
/// rectangular window. The fall of that window is made up for (0.04 dB to 10 kHz at 44.1 kHz).
///
/// The wave comes out delay() samples later. All times are in samples of the rate it was given.
class Steepening {
public:
  /// Farthest that a piece may run ahead or lag, s.
  static constexpr double kMaxShift = 0.5e-3;
  static constexpr int kMaxRun = 64; // samples

  /// Allocates room for rates up to highest_rate, Hz.
  void prepare(double highest_rate);
  /// The sample rate, Hz, not above the highest: another one begins with silence.
  void set_rate(double rate) noexcept;
  void reset() noexcept;
  /// Samples from the wave to where an unsteepened one comes out, half a sample included.
  [[nodiscard]] double delay() const noexcept { return max_shift_ + kLookAhead + 1.5; }
  /// False when what it was given was no number.
  [[nodiscard]] bool sane() const noexcept { return sane(potential_); }

  /// Replaces count <= kMaxRun samples of a wave in Pa by the wave that arrives; lead >= 0 in
  /// samples for each Pa. A sample costs at most as many steps as twice the reach has samples.
  void run(double* wave, int count, double lead) noexcept;

private:
  static constexpr int kHistory = 5;   // samples before the run that the quadrature needs
  static constexpr int kLookAhead = 3; // by which it is behind

  [[nodiscard]] std::size_t slot(int node) const noexcept {
    return static_cast<std::size_t>(first_ + node) & mask_;
  }
  static bool sane(double potential) noexcept { return potential < 1e300 && potential > -1e300; }
  /// floor(time) of times not before -kMaxShift.
  [[nodiscard]] int floor(double time) const noexcept {
    return static_cast<int>(time + (max_shift_ + 1)) - (max_shift_ + 1);
  }
  void raise_potential(int node, double potential) noexcept {
    double& value_there = grid_[slot(node)];
    value_there = potential > value_there ? potential : value_there;
  }
  void rebase(double& potential) noexcept;

  std::vector<double> grid_{}; // Psi at whole samples, a ring
  std::size_t mask_ = 0;
  int first_ = 0;     // slot of the last node's own time
  int max_shift_ = 0; // whole samples, more than kMaxShift
  double limit_ = 0, rate_ = 0;
  double history_[kHistory] = {};
  double shift_ = 0, potential_ = 0, lead_ = 0; // of the last node
};

} // namespace tactus::reed
