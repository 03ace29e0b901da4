#include "core/modal/contact/pulse.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr int kMaxIterations = 12;

constexpr std::size_t kPerOctave = 4, kBands = kPulseBands;

/// The mobility (sum of b^2) and mean angular frequency of the modes in each band.
class Bands {
public:
  explicit Bands(const StruckPoint& point) noexcept {
    const std::size_t count = std::min(point.gain.size(), point.rate.size());
    const bool known = point.band.size() >= count;
    // Several sums side by side, so that the additions of neighbouring modes, which are mostly in
    // one band, do not wait for each other.
    std::array<std::array<Band, kApart>, kBands> part{};
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t index = known ? point.band[k] % kBands : pulse_band(point.rate[k].imag());
      Band& band = part[index][k % kApart];
      const double mobility = point.gain[k] * point.gain[k];
      band.mobility += mobility;
      band.sum += mobility * point.rate[k].imag();
    }
    for (std::size_t i = 0; i < kBands; ++i)
      for (const Band& band : part[i]) {
        band_[i].mobility += band.mobility;
        band_[i].sum += band.sum;
      }
  }
  template <class Take> void each(const Take& take) const noexcept {
    for (const Band& band : band_)
      if (band.mobility > 0 && band.sum > 0)
        take(band.mobility, band.sum / band.mobility);
  }

private:
  static constexpr std::size_t kApart = 4;
  struct Band {
    double mobility = 0, sum = 0; ///< sums of b^2 and of b^2 omega
  };
  std::array<Band, kBands> band_{};
};

} // namespace

/// From the exponent and the first two bits of the mantissa of the floating-point number.
std::uint8_t pulse_band(double omega_per_s) noexcept {
  constexpr std::uint64_t kOfOne = std::uint64_t{1023} << 2;
  const double omega = omega_per_s > 1 ? omega_per_s : 1;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(omega) >> 50;
  return static_cast<std::uint8_t>(std::min<std::uint64_t>(bits - kOfOne, kBands - 1));
}

double pulse_band_begin(std::size_t band) noexcept {
  const auto part = static_cast<double>(band % kPerOctave) / kPerOctave;
  return std::ldexp(1 + part, static_cast<int>(band / kPerOctave));
}

double Pulse::spectrum(double radians) noexcept {
  const double x = radians / std::numbers::pi, denominator = 1 - x * x;
  return std::abs(denominator) > 1e-6 ? math::cos(0.5 * radians) / denominator
                                      : std::numbers::pi / 4;
}

Pulse find_pulse(const contact::ImpactLaw& law, double striker_mass_kg, double speed_m_per_s,
                 double restitution, const StruckPoint& point) noexcept {
  const Bands bands(point);
  const double own = 1 / striker_mass_kg + point.rigid_mobility_per_kg;
  double mobility = own;
  double duration = law.duration(1 / mobility, speed_m_per_s);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    mobility = own;
    double compliance = point.compliance_m_per_n;
    bands.each([&](double b_squared, double omega) {
      const double spectrum = Pulse::spectrum(omega * duration);
      const double x = omega * duration / std::numbers::pi;
      mobility += b_squared * spectrum * spectrum;
      compliance += b_squared / (omega * omega) * x * x / (1 + x * x);
    });
    // The largest depth d from m v^2/2 = W(d) + C F(d)^2/2. The law's share of it takes the law's
    // own duration, the compliance's share half a period of a spring.
    contact::ImpactLaw compliant = law;
    compliant.compliance_m_per_n = std::max(compliance, 0.0);
    const double energy = 0.5 * speed_m_per_s * speed_m_per_s / mobility;
    const double deepest = compliant.deepest(energy), force = compliant.force(deepest, 0);
    const double compression = compliance * force;
    const double law_duration_ratio =
        law.duration(1 / mobility, speed_m_per_s) / law.deepest(energy);
    const double next = law_duration_ratio * std::max(deepest - compression, 0.0) +
                        std::numbers::pi * compression / speed_m_per_s;
    if (!(std::isfinite(next) && next > 0))
      break;
    const bool found = std::abs(next - duration) < 1e-3 * duration;
    duration = std::sqrt(duration * next); // geometric mean, for convergence
    if (found)
      break;
  }
  return {(1 + restitution) * speed_m_per_s / mobility, duration, striker_mass_kg * mobility - 1};
}

} // namespace tactus::modal
