#pragma once
#include "fem/shapes/shapes.hpp"

namespace tactus::fem {

/// A natural cubic spline through profile points, as a function of the share of the chord length.
class Spline {
public:
  explicit Spline(const std::vector<ProfilePoint>& points);
  [[nodiscard]] ProfilePoint at(double u) const noexcept; ///< 0 <= u <= 1

private:
  std::vector<double> knots_;
  std::array<std::vector<double>, 3> value_, curvature_; ///< r, z, thickness
};

} // namespace tactus::fem
