#include "fem/radiation/panel_pairs.hpp"

#include "fem/vector_clones.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::fem {
namespace {

using Lane = PanelPairs::Lane;

/// Converts values at three points of both panels to hat functions. Multiplies by kHatAtPoint,
/// which is 1/6 everywhere plus 1/2 on its diagonal, from the left and from the right.
TACTUS_VECTOR_CLONES void to_hat_functions(std::array<Lane, 9>& m, std::size_t count) {
  for (std::size_t u = 0; u < count; ++u) {
    std::array<double, 3> row, column;
    for (std::size_t i = 0; i < 3; ++i) {
      row[i] = (m[3 * i][u] + m[3 * i + 1][u] + m[3 * i + 2][u]) / 12;
      column[i] = (m[i][u] + m[i + 3][u] + m[i + 6][u]) / 12;
    }
    const double all = (row[0] + row[1] + row[2]) / 3;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        m[3 * i + j][u] = .25 * m[3 * i + j][u] + row[i] + column[j] + all;
  }
}

void copy_lane(const std::vector<double>& of, std::size_t first, std::size_t count, Lane& lane) {
  std::copy_n(of.begin() + static_cast<std::ptrdiff_t>(first), count, lane.begin());
}

/// Arrays of panels: areas, normals, and the points with one index.
struct Others {
  Lane area, nx, ny, nz, px, py, pz, close;
};

/// Computes the integrands at one point of a panel and one point of each other panel, times the
/// weights.
TACTUS_VECTOR_CLONES void evaluate_pairs(const Others& q, std::size_t count, const Vec3& from,
                                         const Vec3& n, double weight, double k, std::size_t at,
                                         PanelPairs& out) {
  // Local arrays, which cannot alias, so that compilers vectorise the loop below.
  Lane value_re, value_im, slope_re, slope_im, back_re, back_im;
  for (std::size_t u = 0; u < count; ++u) {
    const double x = from.x - q.px[u], y = from.y - q.py[u], z = from.z - q.pz[u];
    const double square = x * x + y * y + z * z, r = std::sqrt(square), kr = k * r;
    double c, s;
    cosine_and_sine(kr, c, s);
    const double over = weight * q.area[u] / r, cubed = over / square;
    value_re[u] = over * (c - q.close[u]);
    value_im[u] = -over * s;
    // (1 + j k r) exp(-j k r)/r^3
    const double steep = cubed * (c + kr * s - q.close[u]), steep_im = cubed * (kr * c - s);
    const double along = -(x * n.x + y * n.y + z * n.z);
    const double back = x * q.nx[u] + y * q.ny[u] + z * q.nz[u];
    slope_re[u] = along * steep;
    slope_im[u] = along * steep_im;
    back_re[u] = back * steep;
    back_im[u] = back * steep_im;
  }
  out.value.re[at] = value_re;
  out.value.im[at] = value_im;
  out.slope.re[at] = slope_re;
  out.slope.im[at] = slope_im;
  out.slope_back.re[at] = back_re;
  out.slope_back.im[at] = back_im;
}

/// The lanes that all pairs (a, b) of the same panels share, and k^2 n.n'.
struct Shared {
  Lane turn, total_re, total_im;
};

TACTUS_VECTOR_CLONES void combine(const PanelPairs& pairs, std::size_t ab, const Lane& curls,
                                  const Shared& shared, std::size_t count, double k,
                                  PanelPairs::Integrals& there, PanelPairs::Integrals& back) {
  Lane there_re, there_im, back_re, back_im; // local, as in evaluate_pairs
  for (std::size_t u = 0; u < count; ++u) {
    const double re = shared.turn[u] * pairs.value.re[ab][u] - curls[u] * shared.total_re[u];
    const double im = shared.turn[u] * pairs.value.im[ab][u] - curls[u] * shared.total_im[u];
    // eta times a slope: j k (x + j y) = -k y + j k x
    there_re[u] = re - k * pairs.slope.im[ab][u];
    there_im[u] = im + k * pairs.slope.re[ab][u];
    back_re[u] = re - k * pairs.slope_back.im[ab][u];
    back_im[u] = im + k * pairs.slope_back.re[ab][u];
  }
  there.re[ab] = there_re;
  there.im[ab] = there_im;
  back.re[ab] = back_re;
  back.im[ab] = back_im;
}

TACTUS_VECTOR_CLONES void add_up(const std::array<Lane, 9>& lanes, std::size_t count, Lane& sum) {
  for (std::size_t u = 0; u < count; ++u) {
    double all = 0;
    for (std::size_t ab = 0; ab < 9; ++ab)
      all += lanes[ab][u];
    sum[u] = all;
  }
}

/// Computes scale times the dot products of one vector with several others.
TACTUS_VECTOR_CLONES void dots(const Vec3& with, const double* x, const double* y, const double* z,
                               double scale, std::size_t count, Lane& out) {
  for (std::size_t u = 0; u < count; ++u)
    out[u] = scale * (with.x * x[u] + with.y * y[u] + with.z * z[u]);
}

} // namespace

PanelArrays::PanelArrays(std::span<const Panel> panels) {
  for (const Panel& p : panels) {
    area.push_back(p.area);
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      normal[a].push_back(p.normal[axis]);
      for (std::size_t i = 0; i < 3; ++i) {
        point[i][a].push_back(p.point[i][axis]);
        curl[i][a].push_back(p.curl[i][axis]);
      }
    }
  }
}

void PanelPairs::integrate(const Panel& p, const PanelArrays& others, std::size_t first,
                           std::size_t count, double k) {
  const double weight = p.area / (36 * std::numbers::pi); // contains 1/(4 pi) and the factor 1/3 of
                                                          // both points
  Others q;
  q.close = near;
  copy_lane(others.area, first, count, q.area);
  copy_lane(others.normal[0], first, count, q.nx);
  copy_lane(others.normal[1], first, count, q.ny);
  copy_lane(others.normal[2], first, count, q.nz);
  for (std::size_t j = 0; j < 3; ++j) {
    copy_lane(others.point[j][0], first, count, q.px);
    copy_lane(others.point[j][1], first, count, q.py);
    copy_lane(others.point[j][2], first, count, q.pz);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 from = p.point[i];
      const std::size_t ij = 3 * i + j;
      evaluate_pairs(q, count, from, p.normal, weight, k, ij, *this);
      for (std::size_t u = 0; u < count; ++u)
        if (q.px[u] == from.x && q.py[u] == from.y && q.pz[u] == from.z) { // the limits for r -> 0
          for (Integrals* one : {&value, &slope, &slope_back})
            one->re[ij][u] = one->im[ij][u] = 0;
          value.im[ij][u] = -k * weight * q.area[u];
        }
    }
  }
  for (Integrals* one : {&value, &slope, &slope_back}) {
    to_hat_functions(one->re, count);
    to_hat_functions(one->im, count);
  }
}

void PanelPairs::to_galerkin(const Panel& p, const PanelArrays& others, std::size_t first,
                             std::size_t count, double k, Integrals& there, Integrals& back) const {
  const auto dot_lane = [&](const Vec3& with, const PanelArrays::Vectors& of, double scale,
                            Lane& out) {
    dots(with, &of[0][first], &of[1][first], &of[2][first], scale, count, out);
  };
  Shared shared;
  add_up(value.re, count, shared.total_re);
  add_up(value.im, count, shared.total_im);
  dot_lane(p.normal, others.normal, k * k, shared.turn);
  Lane curls;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      dot_lane(p.curl[a], others.curl[b], 1, curls);
      combine(*this, 3 * a + b, curls, shared, count, k, there, back);
    }
}

} // namespace tactus::fem
