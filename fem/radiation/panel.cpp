#include "fem/radiation/panel.hpp"

#include <algorithm>

namespace tactus::fem {

Panel::Panel(const std::array<Vec3, 3>& corners) : corner(corners) {
  const Vec3 n = cross(corner[1] - corner[0], corner[2] - corner[0]);
  area = length(n) / 2;
  normal = (.5 / area) * n;
  middle = (1. / 3) * (corner[0] + corner[1] + corner[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    radius = std::max(radius, length(corner[k] - middle));
    curl[k] = (.5 / area) * (corner[(k + 2) % 3] - corner[(k + 1) % 3]);
    for (std::size_t j = 0; j < 3; ++j)
      point[k] += kHatAtPoint[k][j] * corner[j];
  }
}

StaticIntegrals static_integrals(const Panel& panel, const Vec3& x) {
  const double height = dot(x - panel.corner[0], panel.normal), far = std::abs(height);
  const Vec3 foot = x - height * panel.normal;
  double whole = 0, angle = 0;
  Vec3 moment, slope_moment; // ∫ (y - foot)/R dS and ∫ (y - foot) h/R^3 dS
  const double tiny = 1e-12 * panel.radius;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = panel.corner[k], &b = panel.corner[(k + 1) % 3];
    const Vec3 along = (1 / length(b - a)) * (b - a), out = cross(along, panel.normal);
    const double t = dot(a - foot, out), s0 = dot(a - foot, along), s1 = dot(b - foot, along);
    const double r0 = length(a - x), r1 = length(b - x), q = t * t + height * height;
    double log = 0, turn = 0;
    if (q > tiny * tiny) { // otherwise x lies on the edge's line, and both integrals have weight
                           // zero
      // Uses the form without cancellation, since (r1 + s1)(r1 - s1) = q.
      const double top = s1 >= 0 ? r1 + s1 : q / (r1 - s1);
      const double low = s0 >= 0 ? r0 + s0 : q / (r0 - s0);
      log = std::log(top / low);
      turn = std::atan(t * s1 / (q + far * r1)) - std::atan(t * s0 / (q + far * r0));
    }
    whole += t * log - far * turn;
    angle += turn;
    moment += .5 * (q * log + s1 * r1 - s0 * r0) * out;
    slope_moment += (-height * log) * out;
  }
  if (height < 0)
    angle = -angle;
  else if (far < tiny)
    angle = 0;
  StaticIntegrals result;
  for (std::size_t a = 0; a < 3; ++a) {
    // phi_a(y) = phi_a(foot) + gradient . (y - foot); gradient = normal x curl
    const Vec3 gradient = cross(panel.normal, panel.curl[a]);
    const double at_foot = 1. / 3 + dot(gradient, foot - panel.middle);
    result.potential[a] = at_foot * whole + dot(gradient, moment);
    result.slope[a] = at_foot * angle + dot(gradient, slope_moment);
  }
  return result;
}

} // namespace tactus::fem
