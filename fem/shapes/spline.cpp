#include "fem/shapes/spline.hpp"

#include <algorithm>

namespace tactus::fem {

Spline::Spline(const std::vector<ProfilePoint>& points) {
  const std::size_t n = points.size();
  knots_.assign(n, 0.0);
  for (std::size_t i = 1; i < n; ++i) {
    const double step = std::hypot(points[i].r - points[i - 1].r, points[i].z - points[i - 1].z);
    if (!(step > 0))
      throw InputError("profile point " + std::to_string(i + 1) + " repeats the one before it");
    knots_[i] = knots_[i - 1] + step;
  }
  const double whole = knots_.back();
  for (double& k : knots_)
    k /= whole;
  for (const ProfilePoint& p : points) {
    value_[0].push_back(p.r);
    value_[1].push_back(p.z);
    value_[2].push_back(p.thickness);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    // The second derivatives follow from continuity of the first, by a tridiagonal system; they are
    // zero at both ends.
    const auto& y = value_[c];
    std::vector<double> diagonal(n, 1.0), right(n, 0.0), upper(n, 0.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double a = knots_[i] - knots_[i - 1], b = knots_[i + 1] - knots_[i];
      const double eliminate = i == 1 ? 0 : a / diagonal[i - 1];
      diagonal[i] = 2 * (a + b) - eliminate * upper[i - 1];
      upper[i] = b;
      right[i] = 6 * ((y[i + 1] - y[i]) / b - (y[i] - y[i - 1]) / a) - eliminate * right[i - 1];
    }
    curvature_[c].assign(n, 0.0);
    for (std::size_t i = n - 1; i-- > 1;)
      curvature_[c][i] = (right[i] - upper[i] * curvature_[c][i + 1]) / diagonal[i];
  }
}

ProfilePoint Spline::at(double u) const noexcept {
  u = std::clamp(u, 0.0, 1.0);
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, u);
  const auto i = static_cast<std::size_t>(after - knots_.begin()) - 1;
  const double h = knots_[i + 1] - knots_[i], a = (knots_[i + 1] - u) / h, b = 1 - a;
  const auto value = [&](std::size_t c) {
    return a * value_[c][i] + b * value_[c][i + 1] +
           ((a * a * a - a) * curvature_[c][i] + (b * b * b - b) * curvature_[c][i + 1]) * h * h /
               6;
  };
  return {value(0), value(1), value(2)};
}

} // namespace tactus::fem
