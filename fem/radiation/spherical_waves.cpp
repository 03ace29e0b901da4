#include "fem/radiation/spherical_waves.hpp"

#include "fem/vector_clones.hpp"

#include <algorithm>
#include <cblas.h>
#include <numbers>
#include <numeric>

namespace tactus::fem {
namespace {

constexpr std::size_t kVector = 8; // number of doubles in the widest vector

constexpr std::size_t whole_vectors(std::size_t count) {
  return (count + kVector - 1) / kVector * kVector;
}

/// Computes a row of Legendre functions and of psi from the two previous rows. `count` is a
/// multiple of the vector width.
TACTUS_VECTOR_CLONES void fill_row(std::size_t count, double cosine, double bessel,
                                   const double* __restrict along, const double* __restrict inverse,
                                   const double* __restrict turn, const double* __restrict turn_j,
                                   const double* __restrict last, const double* __restrict before,
                                   double* __restrict p, double* __restrict re,
                                   double* __restrict im) {
  for (std::size_t m = 0; m < count; ++m) {
    p[m] = (cosine * last[m] - along[m] * before[m]) * inverse[m];
    re[m] = bessel * p[m] * turn[m];
    im[m] = bessel * p[m] * turn_j[m];
  }
}

/// psi of a degree l, of l - 1 (low) and of l + 1 (high) at m = 0, and the factors of the slope.
struct SlopeRows {
  const double *re, *im, *low, *low_j, *high, *high_j;
  const double *along, *along_high;                      ///< A_lm, A_l+1,m
  const double *across, *back, *across_high, *back_high; ///< B_lm, B_l,-m, B_l+1,m, B_l+1,-m
};

TACTUS_VECTOR_CLONES void fill_slopes(std::size_t count, const SlopeRows& rows, const Vec3& kn,
                                      double* __restrict psi, double* __restrict psi_j,
                                      double* __restrict slope, double* __restrict slope_j) {
  const SlopeRows f = rows;
  const double half_x = .5 * kn.x, half_y = .5 * kn.y, z = kn.z;
  for (std::size_t m = 0; m < count; ++m) {
    // d/dx + j d/dy raises m, d/dx - j d/dy lowers it.
    const double *high = f.high + m, *high_j = f.high_j + m, *low = f.low + m, *low_j = f.low_j + m;
    const double up = f.across_high[m + 1] * high[1] + f.back[m] * low[1];
    const double up_j = f.across_high[m + 1] * high_j[1] + f.back[m] * low_j[1];
    const double down = -*(f.back_high + m - 1) * *(high - 1) - f.across[m] * *(low - 1);
    const double down_j = -*(f.back_high + m - 1) * *(high_j - 1) - f.across[m] * *(low_j - 1);
    const double axial = f.along[m] * *low - f.along_high[m] * *high;
    const double axial_j = f.along[m] * *low_j - f.along_high[m] * *high_j;
    psi[m] = f.re[m];
    psi_j[m] = f.im[m];
    slope[m] = z * axial + half_x * (up + down) + half_y * (up_j - down_j);
    slope_j[m] = z * axial_j + half_x * (up_j + down_j) + half_y * (down - up);
  }
}

/// Adds the values at three points of a panel to the hat functions of its corners, by kHatAtPoint.
TACTUS_VECTOR_CLONES void add_to_hats(std::size_t count, double weight, const double* __restrict a,
                                      const double* __restrict b, const double* __restrict c,
                                      double* __restrict to_a, double* __restrict to_b,
                                      double* __restrict to_c) {
  const double half = .5 * weight, sixth = weight / 6;
  for (std::size_t q = 0; q < count; ++q) {
    const double all = sixth * (a[q] + b[q] + c[q]);
    to_a[q] += half * a[q] + all;
    to_b[q] += half * b[q] + all;
    to_c[q] += half * c[q] + all;
  }
}

/// Sorts the panels' numbers into groups of at most `most` that lie close together: it halves
/// groups across the longest side of the box around their middles.
void group_panels(const ExteriorField& field, std::span<std::size_t> panels, std::size_t most,
                  std::vector<std::span<const std::size_t>>& groups) {
  if (panels.size() <= most) {
    groups.emplace_back(panels);
    return;
  }
  std::vector<Vec3> middles;
  for (const std::size_t t : panels)
    middles.push_back(field.panels()[t].middle);
  const Box box = bounding_box(middles);
  const Vec3 size = box.high - box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::size_t half = panels.size() / 2;
  std::nth_element(panels.begin(), panels.begin() + static_cast<std::ptrdiff_t>(half), panels.end(),
                   [&](std::size_t a, std::size_t b) {
                     const double at = field.panels()[a].middle[axis];
                     const double other = field.panels()[b].middle[axis];
                     return at < other || (at == other && a < b);
                   });
  group_panels(field, panels.first(half), most, groups);
  group_panels(field, panels.subspan(half), most, groups);
}

} // namespace

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
  // Scales by j_0 or j_1, whichever is not near a zero.
  const double j0 = std::sin(x) / x, j1 = (std::sin(x) / x - std::cos(x)) / x;
  const double scale = highest == 0 || std::abs(j0) > std::abs(j1) ? j0 / j[0] : j1 / j[1];
  for (double& value : j)
    value *= scale;
  return j;
}

std::vector<Complex> spherical_hankel(std::size_t highest, double x) {
  std::vector<Complex> h(highest + 1);
  const Complex wave = math::polar(1.0, -x);
  h[0] = Complex(0, 1) * wave / x;
  if (highest > 0)
    h[1] = wave * Complex(-1 / x, 1 / (x * x));
  for (std::size_t l = 1; l < highest; ++l)
    h[l + 1] = (2.0 * static_cast<double>(l) + 1) / x * h[l] - h[l - 1];
  return h;
}

RegularWaves::RegularWaves(std::size_t highest)
    : highest_(highest), width_(kBefore + whole_vectors(highest + 2) + kVector), start_{0} {
  for (std::size_t l = 0; l <= highest; ++l)
    start_.push_back(start_.back() + whole_vectors(l + 1));
  for (std::vector<double>* table : {&along_, &inverse_, &across_, &across_back_})
    table->assign(width_ * (highest + 2), 0.0);
  for (std::size_t l = 1; l <= highest + 1; ++l) {
    const double a = static_cast<double>(l), scale = 1 / (4 * a * a - 1);
    for (std::size_t m = 0; m <= l; ++m) {
      const double b = static_cast<double>(m);
      along_[at(l) + m] = std::sqrt((a * a - b * b) * scale);
      if (m < l)
        inverse_[at(l) + m] = 1 / along_[at(l) + m];
      across_[at(l) + m] = std::sqrt((a + b) * (a + b - 1) * scale);
      if (m < l)
        across_back_[at(l) + m] = std::sqrt((a - b) * (a - b - 1) * scale);
    }
    across_back_[at(l) - 1] = std::sqrt((a + 1) * a * scale);
  }
  turn_.assign(width_, 0.0);
  turn_j_ = turn_;
  for (Row& row : rows_)
    row.legendre = row.re = row.im = turn_;
}

void RegularWaves::evaluate(double k, const Vec3& x, const Vec3& n, const Planes& planes) {
  const double r = length(x), across = std::hypot(x.x, x.y);
  const double cosine = r > 0 ? x.z / r : 1, sine = r > 0 ? across / r : 0;
  const Complex turn = across > 0 ? Complex(x.x, x.y) / across : 1;
  Complex power = 1;
  for (std::size_t m = 0; m <= highest_ + 1; ++m, power *= turn) {
    turn_[kBefore + m] = power.real();
    turn_j_[kBefore + m] = power.imag();
  }
  const auto j = spherical_bessel(highest_ + 1, k * r);
  double diagonal = std::sqrt(1 / (4 * std::numbers::pi));
  for (Row& row : rows_) // degree -1, and entries with m > l
    for (std::vector<double>* values : {&row.legendre, &row.re, &row.im})
      std::fill(values->begin(), values->end(), 0.0);
  for (std::size_t l = 0; l <= highest_ + 1; ++l) {
    const double b = static_cast<double>(l);
    if (l > 0)
      diagonal *= -std::sqrt((2 * b + 1) / (2 * b)) * sine;
    next_row(l, cosine, j[l], diagonal);
    if (l > 0)
      write(l - 1, k, n, planes);
  }
}

void RegularWaves::next_row(std::size_t l, double cosine, double bessel, double diagonal) {
  Row& row = rows_[l % 4];
  if (l > 0)
    fill_row(whole_vectors(l), cosine, bessel, &along_[at(l - 1)], &inverse_[at(l)],
             &turn_[kBefore], &turn_j_[kBefore], &rows_[(l + 3) % 4].legendre[kBefore],
             &rows_[(l + 2) % 4].legendre[kBefore], &row.legendre[kBefore], &row.re[kBefore],
             &row.im[kBefore]);
  row.legendre[kBefore + l] = diagonal;
  row.re[kBefore + l] = bessel * diagonal * turn_[kBefore + l];
  row.im[kBefore + l] = bessel * diagonal * turn_j_[kBefore + l];
  row.re[kBefore - 1] = -row.re[kBefore + 1]; // psi_l,-1 = -psi*_l1
  row.im[kBefore - 1] = row.im[kBefore + 1];
}

void RegularWaves::write(std::size_t l, double k, const Vec3& n, const Planes& planes) const {
  const Row &row = rows_[l % 4], &low = rows_[(l + 3) % 4], &high = rows_[(l + 1) % 4];
  const SlopeRows rows{&row.re[kBefore],     &row.im[kBefore],    &low.re[kBefore],
                       &low.im[kBefore],     &high.re[kBefore],   &high.im[kBefore],
                       &along_[at(l)],       &along_[at(l + 1)],  &across_[at(l)],
                       &across_back_[at(l)], &across_[at(l + 1)], &across_back_[at(l + 1)]};
  fill_slopes(whole_vectors(l + 1), rows, k * n, &planes.psi[start_[l]], &planes.psi_j[start_[l]],
              &planes.slope[start_[l]], &planes.slope_j[start_[l]]);
}

namespace {

/// Sums over the surface of the waves times the layers: for each column of mu a real and an
/// imaginary column of four planes, psi, psi_j, slope and slope_j.
class SurfaceSums {
public:
  SurfaceSums(const ExteriorField& field, double k, std::size_t highest, const Vec3& centre,
              std::size_t columns)
      : waves(highest), sums(4 * waves.size() * 2 * columns), field_(field), k_(k), centre_(centre),
        local_(field.unknowns(), kNone) {
    for (std::vector<double>& values : at_point_)
      values.resize(4 * waves.size());
  }

  /// Adds a group of panels: computes the waves of unit layers at its vertices, then multiplies
  /// matrices.
  void add(std::span<const std::size_t> panels, std::span<const Complex> mu) {
    vertices_.clear();
    for (const std::size_t t : panels)
      for (const int v : field_.skin().triangle[t])
        if (std::size_t& number = local_[static_cast<std::size_t>(v)]; number == kNone) {
          number = vertices_.size();
          vertices_.push_back(static_cast<std::size_t>(v));
        }
    const std::size_t rows = 4 * waves.size(), n = field_.unknowns(), columns = mu.size() / n;
    source_.assign(rows * vertices_.size(), 0.0);
    for (const std::size_t t : panels)
      add_panel(t);
    layers_.resize(vertices_.size() * 2 * columns);
    for (std::size_t c = 0; c < columns; ++c)
      for (std::size_t v = 0; v < vertices_.size(); ++v) {
        const Complex value = mu[c * n + vertices_[v]];
        layers_[2 * c * vertices_.size() + v] = value.real();
        layers_[(2 * c + 1) * vertices_.size() + v] = value.imag();
      }
    const auto size = [](std::size_t value) { return static_cast<blasint>(value); };
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, size(rows), size(2 * columns),
                size(vertices_.size()), 1, source_.data(), size(rows), layers_.data(),
                size(vertices_.size()), 1, sums.data(), size(rows));
    for (const std::size_t v : vertices_)
      local_[v] = kNone;
  }

  RegularWaves waves;
  std::vector<double> sums;

private:
  static constexpr std::size_t kNone = ~std::size_t{0};

  void add_panel(std::size_t t) {
    const Panel& p = field_.panels()[t];
    const std::size_t size = waves.size(), rows = 4 * size;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::span all(at_point_[i]);
      waves.evaluate(k_, p.point[i] - centre_, p.normal,
                     {all.first(size), all.subspan(size, size), all.subspan(2 * size, size),
                      all.subspan(3 * size)});
    }
    const auto of = [&](std::size_t corner) {
      return &source_[rows * local_[static_cast<std::size_t>(field_.skin().triangle[t][corner])]];
    };
    add_to_hats(rows, p.area / 3, at_point_[0].data(), at_point_[1].data(), at_point_[2].data(),
                of(0), of(1), of(2));
  }

  const ExteriorField& field_;
  double k_;
  Vec3 centre_;
  std::vector<std::size_t> local_, vertices_; ///< a vertex's number in the group, and the inverse
  std::array<std::vector<double>, 3> at_point_;
  std::vector<double> source_, layers_;
};

} // namespace

std::vector<Complex> multipoles(const ExteriorField& field, double k, std::span<const Complex> mu,
                                std::size_t highest, const Vec3& centre, double reference_radius) {
  constexpr std::size_t kPanelsAtOnce = 64; // so few that their waves stay in the processor's cache
  const std::size_t terms = (highest + 1) * (highest + 1), columns = mu.size() / field.unknowns();
  std::vector<std::size_t> panels(field.panels().size());
  std::iota(panels.begin(), panels.end(), std::size_t{0});
  std::vector<std::span<const std::size_t>> groups;
  group_panels(field, panels, kPanelsAtOnce, groups);
  SurfaceSums surface(field, k, highest, centre, columns);
  for (const auto& group : groups)
    surface.add(group, mu);
  const auto h = spherical_hankel(highest, k * reference_radius);
  const std::size_t size = surface.waves.size();
  std::vector<Complex> c(terms * columns);
  for (std::size_t column = 0; column < columns; ++column) {
    const double *re = &surface.sums[8 * size * column], *im = re + 4 * size;
    for (std::size_t l = 0; l <= highest; ++l)
      for (std::size_t m = 0; m <= l; ++m) {
        const std::size_t at = surface.waves.start(l) + m;
        const auto sum = [&](std::size_t plane) {
          return Complex(re[plane * size + at], im[plane * size + at]);
        };
        // From conj(slope) + j k conj(psi). For -m it is multiplied by (-1)^m, without the
        // conjugates.
        const Complex j(0, 1), even = sum(2) + j * k * sum(0), odd = k * sum(1) - j * sum(3);
        Complex* to = &c[column * terms + l * l + l];
        const Complex scale = Complex(0, -k) * h[l];
        to[m] = scale * (even + odd);
        *(to - m) = scale * (even - odd) * (m % 2 ? -1.0 : 1.0);
      }
  }
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
      sum += math::norm(coefficients[q] / h[l]);
  return sum / (2 * air_density * sound_speed * k * k);
}

} // namespace tactus::fem
