#pragma once

#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Nonlinear propagation of a loud plane wave by weak-shock theory: crests travel faster than
/// troughs, fronts steepen and break into shocks.
///
/// A piece of the wave a(t) (Pa) that leaves at t arrives at
///   tau = t - s(a),   s = lead * a, limited to +-kMaxShift.
/// Where pieces overtake one another, a shock cuts off equal areas of the multivalued wave (Whitham
/// 1974, Linear and Nonlinear Waves, section 2.8).
///
/// Both follow from the potential Psi(tau) = int y dtau of the arriving wave y. Along the piece
/// that left at t,
///   Psi = int a dt - lead c^2/2,   c = s/lead.
/// If several pieces arrive together, the piece with the largest Psi counts (Hopf-Lax formula;
/// equal potentials mean equal areas). Psi is interpolated at the sample times by cubic Hermite
/// polynomials whose slope at each node is the pressure there. The output is the increment of Psi
/// over each sample, which is the mean of y over that sample. A shock therefore keeps its time
/// between samples, with the aliasing of a step behind a rectangular window. The droop of that
/// window is compensated (0.04 dB to 10 kHz at 44.1 kHz).
///
/// The output is delayed by delay() samples. Times are in samples unless stated. Only prepare()
/// allocates.
class Steepening {
public:
  /// Limit of |s|, in seconds.
  static constexpr double kMaxShift = 0.5e-3;
  static constexpr int kMaxRun = 64; // samples

  /// Allocates for sample rates up to highest_rate, Hz.
  void prepare(double highest_rate);
  /// The sample rate, Hz, at most that of prepare(). A new rate starts from silence.
  void set_rate(double rate) noexcept;
  void reset() noexcept;
  /// Delay of a weak wave, samples; half a sample of it comes from the mean.
  [[nodiscard]] double delay() const noexcept { return max_shift_ + kLookAhead + 1.5; }
  /// False when the input was NaN or unbounded.
  [[nodiscard]] bool is_bounded() const noexcept { return is_bounded(potential_); }

  /// Replaces count <= kMaxRun samples of a wave in Pa by the arriving wave; lead >= 0 in samples
  /// per Pa. A sample costs at most 2 kMaxShift times the rate in steps.
  void run(double* wave, int count, double lead) noexcept;

private:
  static constexpr int kHistory = 5;   // samples before the run that the quadrature needs
  static constexpr int kLookAhead = 3; // samples by which the quadrature lags

  [[nodiscard]] std::size_t slot(int node) const noexcept {
    return static_cast<std::size_t>(first_ + node) & mask_;
  }
  static bool is_bounded(double potential) noexcept {
    return potential < 1e300 && potential > -1e300;
  }
  /// floor(time) for times not below -kMaxShift.
  [[nodiscard]] int floor(double time) const noexcept {
    return static_cast<int>(time + (max_shift_ + 1)) - (max_shift_ + 1);
  }
  void raise_potential(int node, double potential) noexcept {
    double& value_there = grid_[slot(node)];
    value_there = potential > value_there ? potential : value_there;
  }
  void rebase(double& potential) noexcept;
  /// Writes count samples of the arriving wave from Psi on the grid.
  void differentiate(double* wave, int count) const noexcept;

  std::vector<double> grid_{}; // Psi at whole samples, a ring buffer
  std::size_t mask_ = 0;
  int first_ = 0;     // slot of the last node's departure time
  int max_shift_ = 0; // whole samples, more than kMaxShift
  double limit_ = 0, rate_ = 0;
  double history_[kHistory] = {};
  double shift_ = 0, potential_ = 0, lead_ = 0; // values of the last node
};

} // namespace tactus::reed
