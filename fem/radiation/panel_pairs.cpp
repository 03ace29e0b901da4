#include "fem/radiation/panel_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::fem {
namespace {

/// From values at three points of both panels to hat functions: kHatAtPoint, which is 1/6
/// everywhere and 1/2 more on its diagonal, from the left and from the right.
void to_hat_functions(std::array<PanelPairs::Lane, 9>& m, std::size_t count) {
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
  // Local arrays, which compilers see not to overlap: the loop below is vectorised.
  const auto copy = [&](const std::vector<double>& of, Lane& lane) {
    std::copy_n(of.begin() + static_cast<std::ptrdiff_t>(first), count, lane.begin());
  };
  const double weight = p.area / (36 * std::numbers::pi); // of 1/(4 pi) and the points' thirds
  const Vector3 n = p.normal;
  Lane area, nx, ny, nz;
  const Lane close = near;
  copy(others.area, area);
  copy(others.normal[0], nx);
  copy(others.normal[1], ny);
  copy(others.normal[2], nz);
  for (std::size_t j = 0; j < 3; ++j) {
    Lane px, py, pz, value_re, value_im, slope_re, slope_im, back_re, back_im;
    copy(others.point[j][0], px);
    copy(others.point[j][1], py);
    copy(others.point[j][2], pz);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 from = p.point[i];
      for (std::size_t u = 0; u < count; ++u) {
        const double x = from.x - px[u], y = from.y - py[u], z = from.z - pz[u];
        const double square = x * x + y * y + z * z, r = std::sqrt(square), kr = k * r;
        double c, s;
        cosine_and_sine(kr, c, s);
        const double over = weight * area[u] / r, cubed = over / square;
        value_re[u] = over * (c - close[u]);
        value_im[u] = -over * s;
        // (1 + j k r) exp(-j k r)/r^3
        const double steep = cubed * (c + kr * s - close[u]), steep_im = cubed * (kr * c - s);
        const double along = -(x * n.x + y * n.y + z * n.z);
        const double back = x * nx[u] + y * ny[u] + z * nz[u];
        slope_re[u] = along * steep;
        slope_im[u] = along * steep_im;
        back_re[u] = back * steep;
        back_im[u] = back * steep_im;
      }
      for (std::size_t u = 0; u < count; ++u)
        if (px[u] == from.x && py[u] == from.y && pz[u] == from.z) { // the limits for r -> 0
          value_re[u] = slope_re[u] = slope_im[u] = back_re[u] = back_im[u] = 0;
          value_im[u] = -k * weight * area[u];
        }
      const std::size_t at = 3 * i + j;
      value.re[at] = value_re;
      value.im[at] = value_im;
      slope.re[at] = slope_re;
      slope.im[at] = slope_im;
      slope_back.re[at] = back_re;
      slope_back.im[at] = back_im;
    }
  }
  for (Integrals* one : {&value, &slope, &slope_back}) {
    to_hat_functions(one->re, count);
    to_hat_functions(one->im, count);
  }
}

} // namespace tactus::fem
