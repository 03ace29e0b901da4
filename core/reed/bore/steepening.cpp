#include "core/reed/bore/steepening.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kNotCovered = -1e300;
// Above it Psi, which grows with the mean of the wave, is counted anew from 0: what is then left of
// a double's digits is 1e-8 Pa.
constexpr double kFarFromZero = 1e8; // Pa samples

/// int a dt between two samples from those two, the two beside and the two beyond: exact to the
/// third power of time, and for a sine of 0.227 of the sample rate (10 kHz at 44.1 kHz), 0.04 dB
/// between.
constexpr double kInner = 0.56562322, kMiddle = -0.07760149, kOuter = 0.01197827;
static_assert(2 * (kInner + kMiddle + kOuter) == 1);

/// A wave's mean over a sample, back to the wave: 1 - D^2/24 + 3 D^4/640, D^2 the second
/// difference, as weights of the means here, beside and beyond.
constexpr double kSharpen0 = 1 + 2.0 / 24 + 18.0 / 640, kSharpen1 = -1.0 / 24 - 12.0 / 640,
                 kSharpen2 = 3.0 / 640;

} // namespace

void Steepening::prepare(double highest_rate) {
  const auto needed = static_cast<std::size_t>(2 * kReach * highest_rate) + kMaxRun + 16;
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
  limit_ = kReach * rate;
  reach_ = static_cast<int>(limit_) + 1; // strictly farther, whatever rounding does
  reset();
}

void Steepening::reset() noexcept {
  std::fill(grid_.begin(), grid_.end(), kNotCovered);
  for (int place = -reach_ - 4; place <= 0 && !grid_.empty(); ++place)
    grid_[slot(place)] = 0;
  std::fill(std::begin(past_), std::end(past_), 0.0);
  early_ = potential_ = 0;
}

void Steepening::rebase(double& potential) noexcept {
  for (double& value : grid_)
    value = value > kNotCovered ? value - potential : value;
  potential = 0;
}

void Steepening::run(double* wave, int count, double lead) noexcept {
  if (count < 1 || count > kMaxRun || grid_.empty())
    return;
  constexpr auto index = [](int i) { return static_cast<std::size_t>(i); };
  std::array<double, kPast + kMaxRun> a;
  std::copy(std::begin(past_), std::end(past_), a.begin());
  std::copy_n(wave, count, a.begin() + kPast);
  for (int i = 0; i < count; ++i)
    grid_[slot(reach_ + 1 + i)] = kNotCovered;

  // Nodes 0 to count; node 0 is the last one of the run before. Times are counted from the node's
  // own, so that rounding does not depend on how the stream is cut into runs.
  const double largest = std::min(limit_ / lead, 1e300); // a lead of 0 moves nothing
  std::array<double, kMaxRun + 1> bounded, early, loss;
  for (int i = 0; i <= count; ++i) {
    const double value = a[index(i + kPast - kAhead)];
    const double below = value < largest ? value : largest;
    const double c = below > -largest ? below : -largest;
    bounded[index(i)] = c;
    early[index(i)] = lead * c;
    loss[index(i)] = 0.5 * lead * c * c;
  }
  // Between nodes Psi rises by w (first + u (second + u third)), w what has passed since the first
  // and u = w share the part of the whole.
  std::array<double, kMaxRun> rise, share, first, second, third;
  for (int i = 0; i < count; ++i) {
    const double* x = a.data() + i;
    const auto at = index(i);
    rise[at] = (kInner * (x[2] + x[3]) + (kMiddle * (x[1] + x[4]) + kOuter * (x[0] + x[5]))) -
               (loss[at + 1] - loss[at]);
    share[at] = 1 / (1 + early[at] - early[at + 1]);
    const double chord = rise[at] * share[at];
    // Between pieces of different shifts lie those whose shift is not at its bound.
    const bool together = early[at] == early[at + 1];
    const double a0 = x[2], a1 = x[3], c0 = bounded[at], c1 = bounded[at + 1];
    const double from = together ? a0 : c0, to = together ? a1 : c1;
    first[at] = from;
    second[at] = 3 * chord - 2 * from - to;
    third[at] = from + to - 2 * chord;
  }

  double potential = potential_;
  int place = floor(-early_);
  if (lead != lead_) {
    // The same pressure goes on until the piece arrives with its new lead.
    const int end = floor(-early[0]);
    for (int n = place + 1; n <= end; ++n)
      cover(n, potential + a[2] * (n + early_));
    potential += a[2] * (early_ - early[0]);
    place = end;
    lead_ = lead;
  }
  for (int i = 0; i < count; ++i) {
    const auto at = index(i);
    const int end = i + 1 + floor(-early[at + 1]);
    for (int n = place + 1; n <= end; ++n) {
      const double way = (n - i) + early[at], u = way * share[at];
      cover(n, potential + way * (first[at] + u * (second[at] + u * third[at])));
    }
    place = end;
    potential += rise[at];
    if (std::abs(potential) > kFarFromZero && sane(potential)) [[unlikely]]
      rebase(potential);
  }
  early_ = early[index(count)];
  potential_ = potential;

  std::array<double, kMaxRun + 5> psi;
  const int oldest = -reach_ - 4;
  for (int i = 0; i < count + 5; ++i)
    psi[index(i)] = grid_[slot(oldest + i)];
  for (int i = 0; i < count; ++i) {
    const double* p = psi.data() + i;
    wave[i] = kSharpen0 * (p[3] - p[2]) + (kSharpen1 * ((p[4] - p[3]) + (p[2] - p[1])) +
                                           kSharpen2 * ((p[5] - p[4]) + (p[1] - p[0])));
  }
  first_ = static_cast<int>((static_cast<std::size_t>(first_ + count)) & mask_);
  std::copy_n(a.begin() + count, kPast, std::begin(past_));
}

} // namespace tactus::reed
