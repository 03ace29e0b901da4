#include "fem/radiation/spherical_waves.hpp"

#include <algorithm>
#include <cblas.h>
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

RegularWaves::RegularWaves(std::size_t highest)
    : highest_(highest), width_(highest + 3), along_(width_ * (highest + 2)),
      across_(width_ * (2 * highest + 4)), real_(width_ * (highest + 3)), imaginary_(real_.size()) {
  const long last = static_cast<long>(highest) + 1;
  for (long l = 1; l <= last; ++l)
    for (long m = -l; m <= l; ++m) {
      const double a = static_cast<double>(l), b = static_cast<double>(m);
      if (m >= 0)
        along_[along(l, m)] = std::sqrt((a * a - b * b) / (4 * a * a - 1));
      across_[across(l, m)] = std::sqrt((a + b) * (a + b - 1) / (4 * a * a - 1));
    }
}

void RegularWaves::evaluate(double k, const Vector3& x, const Vector3& n, std::span<Complex> psi,
                            std::span<Complex> slope) {
  evaluate_values(k, x);
  const double half_x = .5 * n.x, half_y = .5 * n.y;
  for (std::size_t m = 0; m <= highest_; ++m) {
    const long order = static_cast<long>(m);
    const double sign = m % 2 ? -1 : 1;
    const double* z = &along_[along(0, order)];
    // Of B(l, m), B(l, -m), B(l + 1, m + 1) and B(l + 1, -m + 1).
    const double *low = &across_[across(0, order)], *low_back = &across_[across(0, -order)];
    const double *high = &across_[across(1, order + 1)],
                 *high_back = &across_[across(1, 1 - order)];
    const double *re = &real_[row(order)], *re_up = re + width_, *re_down = re - width_;
    const double *im = &imaginary_[row(order)], *im_up = im + width_, *im_down = im - width_;
    for (std::size_t l = m; l <= highest_; ++l) {
      // d/dx + j d/dy raises m, d/dx - j d/dy lowers it. A row holds l = -1 first.
      const double up = high[l] * re_up[l + 2] + low_back[l] * re_up[l];
      const double up_j = high[l] * im_up[l + 2] + low_back[l] * im_up[l];
      const double down = -high_back[l] * re_down[l + 2] - low[l] * re_down[l];
      const double down_j = -high_back[l] * im_down[l + 2] - low[l] * im_down[l];
      const double axial = z[l] * re[l] - z[l + 1] * re[l + 2];
      const double axial_j = z[l] * im[l] - z[l + 1] * im[l + 2];
      const double a = k * (n.z * axial + half_x * (up + down) + half_y * (up_j - down_j));
      const double b = k * (n.z * axial_j + half_x * (up_j + down_j) + half_y * (down - up));
      const std::size_t middle = l * l + l;
      psi[middle - m] = sign * Complex(re[l + 1], -im[l + 1]);
      psi[middle + m] = Complex(re[l + 1], im[l + 1]);
      slope[middle - m] = sign * Complex(a, -b);
      slope[middle + m] = Complex(a, b);
    }
  }
}

void RegularWaves::evaluate_values(double k, const Vector3& x) {
  const double r = length(x), cosine = r > 0 ? std::clamp(x.z / r, -1.0, 1.0) : 1;
  const double sine = std::sqrt(1 - cosine * cosine), azimuth = std::atan2(x.y, x.x);
  const auto j = spherical_bessel(highest_ + 1, k * r);
  double diagonal = std::sqrt(1 / (4 * std::numbers::pi));
  for (std::size_t m = 0; m <= highest_ + 1; ++m) {
    const double b = static_cast<double>(m);
    if (m > 0)
      diagonal *= -std::sqrt((2 * b + 1) / (2 * b)) * sine;
    const double turn = std::cos(b * azimuth), turn_j = std::sin(b * azimuth);
    const double* a = &along_[along(0, static_cast<long>(m))];
    double *re = &real_[row(static_cast<long>(m))], *im = &imaginary_[row(static_cast<long>(m))];
    double before = 0, now = diagonal;
    for (std::size_t l = m; l <= highest_ + 1; ++l) {
      re[l + 1] = j[l] * now * turn;
      im[l + 1] = j[l] * now * turn_j;
      if (l > highest_)
        break;
      const double next = (cosine * now - a[l] * before) / a[l + 1];
      before = now;
      now = next;
    }
  }
  for (std::size_t l = 0; l < width_; ++l) { // psi_l,-1 = -psi*_l1
    real_[row(-1) + l] = -real_[row(1) + l];
    imaginary_[row(-1) + l] = imaginary_[row(1) + l];
  }
}

std::vector<Complex> multipoles(const ExteriorField& field, double k, std::span<const Complex> mu,
                                std::size_t highest, const Vector3& centre,
                                double reference_radius) {
  constexpr std::size_t kPanelsAtOnce = 32;
  const std::size_t terms = (highest + 1) * (highest + 1), n = field.unknowns();
  const std::size_t columns = mu.size() / n;
  std::vector<Complex> c(terms * columns), psi(terms), slope(terms);
  std::vector<Complex> source(3 * kPanelsAtOnce * terms), density(3 * kPanelsAtOnce * columns);
  RegularWaves waves(highest);
  // The waves of unit layers at a few panels' points times the layers of all columns: a product of
  // matrices.
  for (std::size_t first = 0; first < field.panels().size(); first += kPanelsAtOnce) {
    const std::size_t last = std::min(first + kPanelsAtOnce, field.panels().size());
    const std::size_t points = 3 * (last - first);
    for (std::size_t t = first; t < last; ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const Panel& p = field.panels()[t];
        const std::size_t point = 3 * (t - first) + i;
        waves.evaluate(k, p.point[i] - centre, p.normal, psi, slope);
        for (std::size_t q = 0; q < terms; ++q) // conj(slope) + j k conj(psi)
          source[point * terms + q] =
              Complex(slope[q].real() + k * psi[q].imag(), k * psi[q].real() - slope[q].imag());
        for (std::size_t column = 0; column < columns; ++column) {
          Complex sum = 0;
          for (std::size_t j = 0; j < 3; ++j)
            sum += kHatAtPoint[i][j] *
                   mu[column * n + static_cast<std::size_t>(field.skin().triangle[t][j])];
          density[column * points + point] = p.area / 3 * sum;
        }
      }
    const Complex one = 1;
    const auto size = [](std::size_t value) { return static_cast<blasint>(value); };
    cblas_zgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, size(terms), size(columns), size(points),
                &one, source.data(), size(terms), density.data(), size(points), &one, c.data(),
                size(terms));
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
  const auto degrees =
      static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(coefficients.size()))));
  const auto h = spherical_hankel(degrees - 1, k * reference_radius);
  double sum = 0;
  for (std::size_t l = 0; l < degrees; ++l)
    for (std::size_t q = l * l; q < (l + 1) * (l + 1); ++q)
      sum += std::norm(coefficients[q] / h[l]);
  return sum / (2 * air_density * sound_speed * k * k);
}

} // namespace tactus::fem
