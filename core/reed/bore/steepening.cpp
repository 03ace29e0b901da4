#include "core/reed/bore/steepening.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kNoPotential = -1e300;
// Psi grows with the mean of the wave. Above this limit it starts again from 0; the rounding error
// at the limit is 1e-8 Pa.
constexpr double kRebaseLimit = 1e8; // Pa samples

/// Weights of int a dt between two samples, from these two samples and two on either side. They are
/// exact for cubic polynomials and for a sine of 0.227 of the sample rate (10 kHz at 44.1 kHz), and
/// within 0.04 dB below this frequency.
constexpr double kInner = 0.56562322, kMiddle = -0.07760149, kOuter = 0.01197827;
static_assert(2 * (kInner + kMiddle + kOuter) == 1);

/// Compensates the droop of the mean over a sample: 1 - D^2/24 + 3 D^4/640, D^2 the second
/// difference, as weights of the means at distances 0, 1 and 2.
constexpr double kSharpen0 = 1 + 2.0 / 24 + 18.0 / 640, kSharpen1 = -1.0 / 24 - 12.0 / 640,
                 kSharpen2 = 3.0 / 640;

} // namespace

void Steepening::prepare(double highest_rate) {
  const auto needed = static_cast<std::size_t>(2 * kMaxShift * highest_rate) + kMaxRun + 16;
  std::size_t size = 1;
  while (size < needed)
    size *= 2;
  grid_.assign(size, 0.0);
  mask_ = size - 1;
  rate_ = 0;
}

void Steepening::set_rate(double rate) noexcept {
  if (rate == rate_)
    return;
  rate_ = rate;
  limit_ = kMaxShift * rate;
  max_shift_ = static_cast<int>(limit_) + 1; // strictly above limit_, whatever the rounding
  reset();
}

void Steepening::reset() noexcept {
  std::fill(grid_.begin(), grid_.end(), kNoPotential);
  for (int node = -max_shift_ - 4; node <= 0 && !grid_.empty(); ++node)
    grid_[slot(node)] = 0;
  std::fill(std::begin(history_), std::end(history_), 0.0);
  shift_ = potential_ = 0;
}

void Steepening::rebase(double& potential) noexcept {
  for (double& value : grid_)
    value = value > kNoPotential ? value - potential : value;
  potential = 0;
}

// One function, because its loops pass arrays of a run to each other, which stay on the stack.
void Steepening::run(double* wave, int count, double lead) noexcept {
  if (count < 1 || count > kMaxRun || grid_.empty())
    return;
  constexpr auto index = [](int i) { return static_cast<std::size_t>(i); };
  std::array<double, kHistory + kMaxRun> a;
  std::copy(std::begin(history_), std::end(history_), a.begin());
  std::copy_n(wave, count, a.begin() + kHistory);
  for (int i = 0; i < count; ++i)
    grid_[slot(max_shift_ + 1 + i)] = kNoPotential;

  // Nodes 0 to count; node 0 is the last node of the previous run. Times are relative to each node,
  // so that rounding does not depend on how the stream is cut into runs.
  const double max_pressure = std::min(limit_ / lead, 1e300); // a lead of 0 moves nothing
  std::array<double, kMaxRun + 1> bounded, shift, loss;
  for (int i = 0; i <= count; ++i) {
    const double value = a[index(i + kHistory - kLookAhead)];
    const double below = value < max_pressure ? value : max_pressure;
    const double c = below > -max_pressure ? below : -max_pressure;
    bounded[index(i)] = c;
    shift[index(i)] = lead * c;
    loss[index(i)] = 0.5 * lead * c * c;
  }
  // Between nodes Psi increases by w (first + u (second + u third)), w the time since the first
  // node and u = w share its fraction.
  std::array<double, kMaxRun> rise, share, first, second, third;
  for (int i = 0; i < count; ++i) {
    const double* x = a.data() + i;
    const auto at = index(i);
    rise[at] = (kInner * (x[2] + x[3]) + (kMiddle * (x[1] + x[4]) + kOuter * (x[0] + x[5]))) -
               (loss[at + 1] - loss[at]);
    share[at] = 1 / (1 + shift[at] - shift[at + 1]);
    const double chord = rise[at] * share[at];
    // Between pieces of different shifts the shift is not at its limit.
    const bool equal_shifts = shift[at] == shift[at + 1];
    const double a0 = x[2], a1 = x[3], c0 = bounded[at], c1 = bounded[at + 1];
    const double from = equal_shifts ? a0 : c0, to = equal_shifts ? a1 : c1;
    first[at] = from;
    second[at] = 3 * chord - 2 * from - to;
    third[at] = from + to - 2 * chord;
  }

  double potential = potential_;
  int node = floor(-shift_);
  if (lead != lead_) {
    // The pressure is constant until the piece with the new lead arrives.
    const int end = floor(-shift[0]);
    for (int n = node + 1; n <= end; ++n)
      raise_potential(n, potential + a[2] * (n + shift_));
    potential += a[2] * (shift_ - shift[0]);
    node = end;
    lead_ = lead;
  }
  for (int i = 0; i < count; ++i) {
    const auto at = index(i);
    const int end = i + 1 + floor(-shift[at + 1]);
    for (int n = node + 1; n <= end; ++n) {
      const double elapsed = (n - i) + shift[at], u = elapsed * share[at];
      raise_potential(n, potential + elapsed * (first[at] + u * (second[at] + u * third[at])));
    }
    node = end;
    potential += rise[at];
    if (std::abs(potential) > kRebaseLimit && is_bounded(potential)) [[unlikely]]
      rebase(potential);
  }
  shift_ = shift[index(count)];
  potential_ = potential;

  differentiate(wave, count);
  first_ = static_cast<int>((static_cast<std::size_t>(first_ + count)) & mask_);
  std::copy_n(a.begin() + count, kHistory, std::begin(history_));
}

void Steepening::differentiate(double* wave, int count) const noexcept {
  std::array<double, kMaxRun + 5> psi;
  const int oldest = -max_shift_ - 4;
  for (int i = 0; i < count + 5; ++i)
    psi[static_cast<std::size_t>(i)] = grid_[slot(oldest + i)];
  for (int i = 0; i < count; ++i) {
    const double* p = psi.data() + i;
    wave[i] = kSharpen0 * (p[3] - p[2]) + (kSharpen1 * ((p[4] - p[3]) + (p[2] - p[1])) +
                                           kSharpen2 * ((p[5] - p[4]) + (p[1] - p[0])));
  }
}

} // namespace tactus::reed
