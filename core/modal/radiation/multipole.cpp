#include "core/modal/radiation/multipole.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {
namespace {

Complex widened(std::complex<float> z) noexcept { return {z.real(), z.imag()}; }

/// Orthonormal associated Legendre functions with Condon and Shortley's phase: [l (l + 1)/2 + m].
std::vector<double> legendre(std::size_t highest, double cosine) {
  std::vector<double> p((highest + 1) * (highest + 2) / 2);
  const auto at = [&](std::size_t l, std::size_t m) -> double& { return p[l * (l + 1) / 2 + m]; };
  const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  at(0, 0) = std::sqrt(1 / (4 * std::numbers::pi));
  for (std::size_t m = 1; m <= highest; ++m) {
    const double n = static_cast<double>(m);
    at(m, m) = -std::sqrt((2 * n + 1) / (2 * n)) * sine * at(m - 1, m - 1);
  }
  for (std::size_t m = 0; m < highest; ++m)
    at(m + 1, m) = std::sqrt(2 * static_cast<double>(m) + 3) * cosine * at(m, m);
  for (std::size_t m = 0; m <= highest; ++m)
    for (std::size_t l = m + 2; l <= highest; ++l) {
      const double a = static_cast<double>(l), b = static_cast<double>(m);
      const double scale = std::sqrt((4 * a * a - 1) / (a * a - b * b));
      const double back = std::sqrt(((a - 1) * (a - 1) - b * b) / (4 * (a - 1) * (a - 1) - 1));
      at(l, m) = scale * (cosine * at(l - 1, m) - back * at(l - 2, m));
    }
  return p;
}

} // namespace

std::vector<Complex> spherical_hankel(std::size_t max_degree, double x) {
  std::vector<Complex> h(max_degree + 1);
  const Complex wave = math::polar(1.0, -x);
  h[0] = Complex(0, 1) * wave / x;
  if (max_degree > 0)
    h[1] = wave * (Complex(0, 1) / (x * x) - 1.0 / x);
  for (std::size_t l = 1; l < max_degree; ++l)
    h[l + 1] = (2.0 * static_cast<double>(l) + 1) / x * h[l] - h[l - 1];
  return h;
}

MultipoleDirection::MultipoleDirection(const ModalTable& table, const Vec3& direction)
    : poles_(&table.multipoles) {
  const double length = norm(direction);
  const double cosine = length > 0 ? std::clamp(direction.z / length, -1.0, 1.0) : 1;
  const double azimuth = math::atan2(direction.y, direction.x);
  std::int32_t max_degree = 0;
  for (const auto* const degrees : {&poles_->highest_degree, &poles_->band.highest_degree})
    for (const std::int32_t degree : *degrees)
      max_degree = std::max(max_degree, degree);
  const std::vector<double> polynomial = legendre(static_cast<std::size_t>(max_degree), cosine);
  for (std::int32_t l = 0; l <= max_degree; ++l)
    for (std::int32_t m = -l; m <= l; ++m) {
      const double sign = m < 0 && m % 2 != 0 ? -1 : 1;
      harmonic_.push_back(
          math::polar(1.0, m * azimuth) *
          (sign * polynomial[static_cast<std::size_t>(l * (l + 1) / 2 + std::abs(m))]));
    }
}

std::vector<Complex> MultipoleDirection::sums(std::size_t mode, double ratio) const {
  const std::vector<double>& scales = poles_->scales;
  const auto upper = std::upper_bound(scales.begin(), scales.end(), ratio);
  const std::size_t right =
      std::min(static_cast<std::size_t>(upper - scales.begin()), scales.size() - 1);
  const std::size_t left = right > 0 ? right - 1 : 0;
  double part = 0;
  if (right > left)
    part = std::clamp((ratio - scales[left]) / (scales[right] - scales[left]), 0.0, 1.0);
  const auto degree = static_cast<std::size_t>(poles_->highest_degree[mode]);
  const auto total = static_cast<std::size_t>(poles_->offset.back());
  std::vector<Complex> sums(degree + 1);
  for (std::size_t l = 0; l <= degree; ++l)
    for (std::size_t j = 0; j <= 2 * l; ++j) {
      const std::size_t at = static_cast<std::size_t>(poles_->offset[mode]) + l * l + j;
      const Complex a = widened(poles_->coefficients[left * total + at]);
      const Complex b = widened(poles_->coefficients[right * total + at]);
      sums[l] += (a + part * (b - a)) * harmonic_[l * l + j];
    }
  return sums;
}

std::vector<Complex> MultipoleDirection::band_sums(std::size_t mode, std::size_t frequency) const {
  const MultipoleTable::Band& band = poles_->band;
  const auto degree = static_cast<std::size_t>(band.highest_degree[mode]);
  const std::complex<float>* const c = band.coefficients.data() +
                                       frequency * static_cast<std::size_t>(band.offset.back()) +
                                       static_cast<std::size_t>(band.offset[mode]);
  std::vector<Complex> sums(degree + 1);
  for (std::size_t l = 0; l <= degree; ++l) {
    Complex sum = 0;
    for (std::size_t j = 0; j <= 2 * l; ++j)
      sum += widened(c[l * l + j]) * harmonic_[l * l + j];
    sums[l] = sum;
  }
  return sums;
}

ListenerTransfer multipole_transfer(const ModalTable& table, std::span<const Complex> rate,
                                    std::span<const std::size_t> mode, const Vec3& listener,
                                    const RadiatingSurface::Scene& scene) {
  const double size = scene.size, sound_speed = scene.sound_speed_m_per_s;
  const MultipoleTable& poles = table.multipoles;
  ListenerTransfer out;
  out.pressure.assign(rate.size(), 0);
  const Vec3 from_centre = listener - size * poles.centre;
  const double reference = size * poles.reference_radius_m;
  // The series does not hold inside the reference sphere, so a nearer listener is moved onto the
  // sphere.
  const double distance = std::max(norm(from_centre), reference);
  const MultipoleDirection direction(table, from_centre);
  out.delay_s = (distance - reference) / sound_speed;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    // A change of size leaves k a as it is; only a change of sqrt(E/rho) changes the ratio.
    const double ratio =
        rate[i].imag() * size / (2 * std::numbers::pi * table.frequency_hz[mode[i]]);
    const std::vector<Complex> sums = direction.sums(mode[i], ratio);
    const double wavenumber = rate[i].imag() / sound_speed;
    const auto near = spherical_hankel(sums.size() - 1, wavenumber * reference);
    const auto far = spherical_hankel(sums.size() - 1, wavenumber * distance);
    Complex sum = 0;
    for (std::size_t l = 0; l < sums.size(); ++l) {
      const Complex spread = far[l] / near[l];
      // If the Hankel functions overflow, only the near field is left.
      sum += sums[l] * (std::isfinite(spread.real()) && std::isfinite(spread.imag())
                            ? spread
                            : Complex(math::pow(reference / distance, static_cast<double>(l) + 1)));
    }
    // The delay line holds the delay from the reference sphere to the listener.
    const Complex advance = math::polar(1.0, wavenumber * (distance - reference));
    out.pressure[i] = scene.shape_scale * scene.air_density_kg_per_m3 /
                      table.air_density_kg_per_m3 * sum * advance;
  }
  return out;
}

} // namespace tactus::modal
