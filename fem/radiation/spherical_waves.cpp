#include "fem/radiation/spherical_waves.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {

std::vector<double> spherical_bessel(std::size_t highest, double x) {
  std::vector<double> j(highest + 1, 0.0);
  if (x < 1e-8) {
    j[0] = 1;
    return j;
  }
  const auto start = std::max(highest, static_cast<std::size_t>(x)) + 20 +
                     static_cast<std::size_t>(4 * std::sqrt(x + static_cast<double>(highest)));
  double next = 0, now = 1e-300;
  for (std::size_t l = start; l > 0; --l) {
    const double before = (2 * static_cast<double>(l) + 1) / x * now - next;
    next = now;
    now = before;
    if (l - 1 <= highest)
      j[l - 1] = now;
    if (std::abs(now) > 1e200) {
      now *= 1e-200;
      next *= 1e-200;
      for (double& value : j)
        value *= 1e-200;
    }
  }
  // Scaled by whichever of j_0 and j_1 is not near a zero.
  const double j0 = std::sin(x) / x, j1 = (std::sin(x) / x - std::cos(x)) / x;
  const double scale = highest == 0 || std::abs(j0) > std::abs(j1) ? j0 / j[0] : j1 / j[1];
  for (double& value : j)
    value *= scale;
  return j;
}

std::vector<Complex> spherical_hankel(std::size_t highest, double x) {
  std::vector<Complex> h(highest + 1);
  const Complex wave = std::polar(1.0, -x);
  h[0] = Complex(0, 1) * wave / x;
  if (highest > 0)
    h[1] = wave * Complex(-1 / x, 1 / (x * x));
  for (std::size_t l = 1; l < highest; ++l)
    h[l + 1] = (2.0 * static_cast<double>(l) + 1) / x * h[l] - h[l - 1];
  return h;
}

std::vector<Complex> regular_waves(std::size_t highest, double k, const Vector3& x) {
  const double r = length(x), cosine = r > 0 ? std::clamp(x.z / r, -1.0, 1.0) : 1;
  const double sine = std::sqrt(1 - cosine * cosine), azimuth = std::atan2(x.y, x.x);
  const auto j = spherical_bessel(highest, k * r);
  std::vector<Complex> psi((highest + 1) * (highest + 1));
  double diagonal = std::sqrt(1 / (4 * std::numbers::pi));
  for (std::size_t m = 0; m <= highest; ++m) {
    const double b = static_cast<double>(m);
    if (m > 0)
      diagonal *= -std::sqrt((2 * b + 1) / (2 * b)) * sine;
    const Complex turn = std::polar(1.0, b * azimuth);
    double before = 0, now = diagonal, back = 0;
    for (std::size_t l = m; l <= highest; ++l) {
      const Complex y = j[l] * now * turn;
      psi[l * l + l + m] = y;
      psi[l * l + l - m] = (m % 2 ? -1.0 : 1.0) * std::conj(y);
      const double a = static_cast<double>(l) + 1;
      const double scale = std::sqrt((4 * a * a - 1) / (a * a - b * b));
      const double next = scale * (cosine * now - back * before);
      back = 1 / scale;
      before = now;
      now = next;
    }
  }
  return psi;
}

std::vector<Complex> regular_slopes(std::size_t highest, double k, std::span<const Complex> psi,
                                    const Vector3& n) {
  std::vector<Complex> slope((highest + 1) * (highest + 1));
  const auto at = [&](long l, long m) -> Complex {
    return l < 0 || m > l || m < -l ? Complex(0) : psi[static_cast<std::size_t>(l * l + l + m)];
  };
  const Complex plus(.5 * n.x, -.5 * n.y), minus(.5 * n.x, .5 * n.y);
  for (long l = 0; l <= static_cast<long>(highest); ++l)
    for (long m = -l; m <= l; ++m) {
      const double a = static_cast<double>(l), b = static_cast<double>(m);
      const double low = 1 / std::sqrt(std::max(4 * a * a - 1, 1.0));
      const double high = 1 / std::sqrt((2 * a + 1) * (2 * a + 3));
      const auto root = [](double product) { return std::sqrt(std::max(product, 0.0)); };
      const Complex along_z = low * root(a * a - b * b) * at(l - 1, m) -
                              high * root((a + 1) * (a + 1) - b * b) * at(l + 1, m);
      // d/dx + j d/dy raises m, d/dx - j d/dy lowers it.
      const Complex up = high * root((a + b + 1) * (a + b + 2)) * at(l + 1, m + 1) +
                         low * root((a - b) * (a - b - 1)) * at(l - 1, m + 1);
      const Complex down = -high * root((a - b + 1) * (a - b + 2)) * at(l + 1, m - 1) -
                           low * root((a + b) * (a + b - 1)) * at(l - 1, m - 1);
      slope[static_cast<std::size_t>(l * l + l + m)] =
          k * (n.z * along_z + plus * up + minus * down);
    }
  return slope;
}

std::vector<Complex> multipoles(const ExteriorField& field, double k, std::span<const Complex> mu,
                                std::size_t columns, std::size_t highest, const Vector3& centre,
                                double reference_radius) {
  const std::size_t terms = (highest + 1) * (highest + 1), n = field.unknowns();
  std::vector<Complex> c(terms * columns, 0.0);
  for (std::size_t t = 0; t < field.panels().size(); ++t) {
    const Panel& p = field.panels()[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto psi = regular_waves(highest + 1, k, p.point[i] - centre);
      const auto slope = regular_slopes(highest, k, psi, p.normal);
      for (std::size_t column = 0; column < columns; ++column) {
        Complex density = 0;
        for (std::size_t j = 0; j < 3; ++j)
          density += kHatAtPoint[i][j] *
                     mu[column * n + static_cast<std::size_t>(field.skin().triangle[t][j])];
        density *= p.area / 3;
        for (std::size_t q = 0; q < terms; ++q)
          c[column * terms + q] +=
              density * (std::conj(slope[q]) + Complex(0, k) * std::conj(psi[q]));
      }
    }
  }
  const auto h = spherical_hankel(highest, k * reference_radius);
  for (std::size_t column = 0; column < columns; ++column)
    for (std::size_t l = 0; l <= highest; ++l)
      for (std::size_t q = l * l; q < (l + 1) * (l + 1); ++q)
        c[column * terms + q] *= Complex(0, -k) * h[l];
  return c;
}

double radiated_power(std::span<const Complex> coefficients, double k, double reference_radius,
                      double air_density, double sound_speed) {
  const auto degrees = static_cast<std::size_t>(
      std::lround(std::sqrt(static_cast<double>(coefficients.size()))));
  const auto h = spherical_hankel(degrees - 1, k * reference_radius);
  double sum = 0;
  for (std::size_t l = 0; l < degrees; ++l)
    for (std::size_t q = l * l; q < (l + 1) * (l + 1); ++q)
      sum += std::norm(coefficients[q] / h[l]);
  return sum / (2 * air_density * sound_speed * k * k);
}

} // namespace tactus::fem
