#include "core/haptic/network/shapes.hpp"

#include <algorithm>

namespace tactus::haptic {
namespace {

NetworkLink link_between(std::size_t a, std::size_t b, double stiffness, double rest_length,
                         double damping) {
  NetworkLink link;
  link.a = static_cast<std::uint16_t>(a);
  link.b = static_cast<std::uint16_t>(b);
  link.stiffness_n_per_m = stiffness;
  link.rest_length_m = rest_length;
  link.damping_n_s_per_m = link.transverse_damping_n_s_per_m = damping;
  return link;
}

bool is_corner(int nx, int ny, int i, int j) noexcept {
  return (i == 0 || i == nx + 1) && (j == 0 || j == ny + 1);
}

} // namespace

NetworkPart make_string(const NetworkString& string) {
  NetworkPart part;
  const int segments = string.count + 1;
  const double spacing = norm(string.to - string.from) / segments;
  const double min_stiffness = string.tension_n / spacing;
  const double stiffness = std::max(string.stiffness_n_per_m, min_stiffness);
  const double rest_length =
      stiffness > min_stiffness ? spacing - string.tension_n / stiffness : 0.0;
  for (int i = 0; i <= segments; ++i) {
    const double share = static_cast<double>(i) / segments;
    part.masses.push_back({0, string.mass_kg / string.count,
                           string.from + (string.to - string.from) * share,
                           i == 0 || i == segments});
    if (i > 0)
      part.links.push_back(link_between(static_cast<std::size_t>(i - 1),
                                        static_cast<std::size_t>(i), stiffness, rest_length,
                                        string.damping_n_s_per_m));
  }
  return part;
}

std::size_t membrane_index(int nx, int ny, int i, int j) noexcept {
  if (j == 0)
    return static_cast<std::size_t>(i - 1);
  const int before = nx + (j - 1) * (nx + 2);
  return static_cast<std::size_t>(before + (j == ny + 1 ? i - 1 : i));
}

NetworkPart make_membrane(const NetworkMembrane& membrane) {
  const Vec3 extent = membrane.to - membrane.from;
  int first = -1, second = -1;
  for (int axis = 0; axis < 3; ++axis)
    if (extent[axis] != 0)
      (first < 0 ? first : second) = axis;
  NetworkPart part;
  if (first < 0 || second < 0 || (extent.x != 0 && extent.y != 0 && extent.z != 0))
    return part;
  const int nx = membrane.nx, ny = membrane.ny;
  const double dx = std::abs(extent[first]) / (nx + 1), dy = std::abs(extent[second]) / (ny + 1);
  for (int j = 0; j <= ny + 1; ++j)
    for (int i = 0; i <= nx + 1; ++i) {
      if (is_corner(nx, ny, i, j))
        continue;
      Vec3 position = membrane.from;
      position[first] += extent[first] * i / (nx + 1);
      position[second] += extent[second] * j / (ny + 1);
      const bool rim = i == 0 || i == nx + 1 || j == 0 || j == ny + 1;
      part.masses.push_back({0, membrane.mass_kg / (nx * ny), position, rim});
      const std::size_t index = part.masses.size() - 1;
      const double damping = membrane.damping_n_s_per_m;
      if (i > 0 && j > 0 && j <= ny)
        part.links.push_back(link_between(membrane_index(nx, ny, i - 1, j), index,
                                          membrane.tension_n_per_m * dy / dx, 0, damping));
      if (j > 0 && i > 0 && i <= nx)
        part.links.push_back(link_between(membrane_index(nx, ny, i, j - 1), index,
                                          membrane.tension_n_per_m * dx / dy, 0, damping));
    }
  return part;
}

} // namespace tactus::haptic
