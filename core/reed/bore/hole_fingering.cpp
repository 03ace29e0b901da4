#include "core/reed/bore/hole_fingering.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/hole_lattice.hpp"
#include "core/reed/bore/pole_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;

/// Frequencies of the response, Hz: dense where resonances are.
constexpr std::size_t kMagnitudes = 132;
constexpr double frequency(std::size_t i) {
  if (i < 80)
    return 10 + 25 * static_cast<double>(i); // up to 1985 Hz
  if (i < 112)
    return 2000 + 62.5 * static_cast<double>(i - 79); // up to 4000 Hz
  return 4000 + 200 * static_cast<double>(i - 111);   // up to 8000 Hz
}
/// Frequencies far above the cut-off, where R is taken as 0, with a small weight in the fit. Hz.
constexpr std::array<double, 4> kHighFrequencies{12e3, 20e3, 40e3, 80e3};
constexpr double kHighFrequencyWeight = 3e-3;
static_assert(kMagnitudes + kHighFrequencies.size() <= kMaxResponsePoints);

/// Minimum phase that belongs to magnitudes at frequency(i), by the real cepstrum on the circle
/// tan(theta/2) = f/1500 Hz. The magnitude is proportional to f towards 0 Hz and constant beyond
/// the last frequency.
class MinimumPhase {
public:
  explicit MinimumPhase(const std::array<double, kMagnitudes>& magnitude) noexcept {
    // Cepstrum of magnitude/|i f/(i f + f_c)|; the phase of the divisor is added in at().
    for (std::size_t n = 0; n <= kHalf; ++n) {
      const double theta = pi * (static_cast<double>(n) + 0.5) / (kHalf + 1.0);
      const double f = std::clamp(kScale * math::tan(theta / 2), frequency(0), 8000.0);
      std::size_t i = 0;
      while (i + 2 < kMagnitudes && frequency(i + 1) < f)
        ++i;
      const double share = (f - frequency(i)) / (frequency(i + 1) - frequency(i));
      const auto log_magnitude = [&](std::size_t k) {
        return math::log(std::max(magnitude[k], 1e-12) * math::hypot(1, kCorner / frequency(k)));
      };
      const double level = log_magnitude(i) +
                           std::clamp(share, 0.0, 1.0) * (log_magnitude(i + 1) - log_magnitude(i));
      for (std::size_t k = 1; k < kCepstrum; ++k)
        cepstrum_[k] += 2 * level * math::cos(static_cast<double>(k) * theta) / (kHalf + 1.0);
    }
  }
  [[nodiscard]] double at(double f) const noexcept {
    const double theta = 2 * math::atan(f / kScale);
    double phase = math::atan2(kCorner, f);
    for (std::size_t k = 1; k < kCepstrum; ++k)
      phase -= cepstrum_[k] * math::sin(static_cast<double>(k) * theta);
    return phase;
  }

private:
  static constexpr std::size_t kHalf = 127, kCepstrum = 64;
  static constexpr double kScale = 1500, kCorner = 500; // Hz
  std::array<double, kCepstrum> cepstrum_{};
};

} // namespace

bool finger_holes(const Woodwind& instrument, std::span<const double> closed,
                  Termination& fingering) noexcept {
  const HoleLattice lattice(instrument, closed);
  std::array<ResponsePoint, kMagnitudes + kHighFrequencies.size()> reflected;
  std::array<ResponsePoint, kMagnitudes> radiated;
  std::array<double, kMagnitudes> magnitude;
  const double cutoff = instrument.cutoff_at(lattice.key());
  double loudest = 0;
  for (std::size_t i = 0; i < kMagnitudes; ++i) {
    const double f = frequency(i), omega = 2 * pi * f;
    const double spacing = i + 1 < kMagnitudes ? frequency(i + 1) - f : 200;
    const HoleLattice::Response response = lattice.at(omega);
    const double cube = math::pow(f / cutoff, 3);
    reflected[i] = {omega, response.reflected, std::sqrt(spacing / (f + 200)) / (0.1 + cube)};
    magnitude[i] = response.radiated;
    loudest = std::max(loudest, response.radiated);
  }
  for (std::size_t i = 0; i < kHighFrequencies.size(); ++i)
    reflected[kMagnitudes + i] = {2 * pi * kHighFrequencies[i], 0.0, kHighFrequencyWeight};
  const MinimumPhase phase(magnitude);
  for (std::size_t i = 0; i < kMagnitudes; ++i) {
    const double f = frequency(i), spacing = i + 1 < kMagnitudes ? frequency(i + 1) - f : 200;
    radiated[i] = {2 * pi * f, math::polar(magnitude[i], phase.at(f)),
                   std::sqrt(spacing) / (magnitude[i] + 0.02 * loudest) / (1 + f / 4000)};
  }
  Termination found;
  found.key = lattice.key();
  if (!fit_poles(reflected, -1, 5.6 * pi * cutoff, found.reflection) ||
      !fit_poles(radiated, 0, 8 * pi * cutoff, found.radiation))
    return false;
  // |R| <= 1 at every frequency.
  const double scale = std::min(1.0, (1 - 1e-9) / largest_response(-1, found.reflection));
  found.dc_value = -scale;
  for (Termination::Block& block : found.reflection) {
    block.c *= scale;
    block.d *= scale;
  }
  fingering = found;
  return true;
}

const Termination* HoleFingerings::find(BoreEnd end, std::span<const double> closed) noexcept {
  const Woodwind* const instrument = woodwind(end);
  if (instrument == nullptr || closed.size() != instrument->tone_holes())
    return nullptr;
  CacheEntry* oldest = &entries_.front();
  for (CacheEntry& entry : entries_) {
    if (entry.last_use > 0 && entry.end == end &&
        std::equal(closed.begin(), closed.end(), entry.closed.begin())) {
      entry.last_use = ++use_count_;
      return &entry.fingering;
    }
    if (entry.last_use < oldest->last_use)
      oldest = &entry;
  }
  Termination fingering;
  if (!finger_holes(*instrument, closed, fingering))
    return nullptr;
  oldest->end = end;
  std::copy(closed.begin(), closed.end(), oldest->closed.begin());
  oldest->fingering = fingering;
  oldest->last_use = ++use_count_;
  return &oldest->fingering;
}

} // namespace tactus::reed
