#include "core/modal/pulse.hpp"

#include "core/modal/contact_force.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr int kRounds = 12;

/// Modes of neighbouring frequencies together, four groups an octave: a blow cannot tell them
/// apart, and the search for its duration does not grow with the body.
class Groups {
public:
  explicit Groups(const StruckPlace& place) noexcept {
    const std::size_t count = std::min(place.gain.size(), place.rate.size());
    for (std::size_t k = 0; k < count; ++k) {
      const double omega = std::abs(place.rate[k].imag());
      Group& group = group_[index(omega)];
      const double mobility = place.gain[k] * place.gain[k];
      group.mobility += mobility;
      group.sum += mobility * omega;
    }
  }
  template <class Take> void each(const Take& take) const noexcept {
    for (const Group& group : group_)
      if (group.mobility > 0 && group.sum > 0)
        take(group.mobility, group.sum / group.mobility);
  }

private:
  static constexpr std::size_t kOctaves = 32, kPerOctave = 4;
  struct Group {
    double mobility = 0, sum = 0; ///< of b^2 and of b^2 omega
  };
  /// By the exponent and the first two bits of the mantissa.
  static std::size_t index(double omega) noexcept {
    constexpr std::uint64_t kOfOne = std::uint64_t{1023} << 2;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(std::max(omega, 1.0)) >> 50;
    return std::min<std::size_t>(static_cast<std::size_t>(bits - kOfOne),
                                 kOctaves * kPerOctave - 1);
  }
  std::array<Group, kOctaves * kPerOctave> group_{};
};

} // namespace

double Pulse::spectrum(double radians) noexcept {
  const double x = radians / std::numbers::pi, denominator = 1 - x * x;
  return std::abs(denominator) > 1e-6 ? std::cos(0.5 * radians) / denominator
                                      : std::numbers::pi / 4;
}

Pulse find_pulse(const ContactLaw& law, double striker_mass_kg, double speed_m_per_s,
                 double restitution, const StruckPlace& place) noexcept {
  const Groups groups(place);
  const double own = 1 / striker_mass_kg + place.rigid_mobility_per_kg;
  double mobility = own;
  double duration = law.duration(1 / mobility, speed_m_per_s);
  for (int round = 0; round < kRounds; ++round) {
    mobility = own;
    double compliance = place.compliance_m_per_n;
    groups.each([&](double b_squared, double omega) {
      const double spectrum = Pulse::spectrum(omega * duration);
      const double turns = omega * duration / std::numbers::pi;
      mobility += b_squared * spectrum * spectrum;
      compliance += b_squared / (omega * omega) * turns * turns / (1 + turns * turns);
    });
    // Deepest at m v^2/2 = W(d) + C F(d)^2/2: the law's own duration for its part of the way, half
    // a period of a spring for the compliance's.
    const SeriesContact contact{law, compliance};
    const double energy = 0.5 * speed_m_per_s * speed_m_per_s / mobility;
    double low = 0, high = law.deepest(1 / mobility, speed_m_per_s) +
                           std::sqrt(2 * energy * std::max(compliance, 0.0));
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (contact.stored(middle) < energy ? low : high) = middle;
    }
    const double force = contact.elastic(high), give = compliance * force;
    const double of_law =
        law.duration(1 / mobility, speed_m_per_s) / law.deepest(1 / mobility, speed_m_per_s);
    const double next =
        of_law * std::max(high - give, 0.0) + std::numbers::pi * give / speed_m_per_s;
    if (!(std::isfinite(next) && next > 0))
      break;
    const bool found = std::abs(next - duration) < 1e-3 * duration;
    duration = std::sqrt(duration * next); // towards it, in proportion
    if (found)
      break;
  }
  return {(1 + restitution) * speed_m_per_s / mobility, duration, striker_mass_kg * mobility - 1};
}

} // namespace tactus::modal
