#include "core/haptic/scene/half_spaces.hpp"

#include "core/haptic/scene/pose.hpp"

namespace tactus::haptic {
namespace {

constexpr double kTolerance_m = 1e-13;
constexpr double kParallel = 1e-9; // sine of the angle below which two faces count as parallel

/// Finds the multipliers for which goal + sum multiplier_i normal_i lies on all of the one to three
/// faces. False if the normals of the faces are (nearly) dependent. Cramer's rule on the Gram
/// matrix of the normals.
bool solve_multipliers(std::span<const HalfSpace* const> active, const Vec3& goal,
                       std::array<double, 3>& multiplier) noexcept {
  std::array<double, 3> depth{};
  for (std::size_t i = 0; i < active.size(); ++i)
    depth[i] = active[i]->offset - dot(active[i]->normal, goal);
  if (active.size() == 1) {
    multiplier[0] = depth[0];
    return true;
  }
  const Vec3 a = active[0]->normal, b = active[1]->normal;
  const Vec3 line = cross(a, b);
  const double area = dot(line, line), cosine = dot(a, b);
  if (active.size() == 2) {
    if (area < kParallel * kParallel)
      return false;
    multiplier[0] = (depth[0] - cosine * depth[1]) / area;
    multiplier[1] = (depth[1] - cosine * depth[0]) / area;
    return true;
  }
  // Three faces meet in one point, x - goal = (d0 b x c + d1 c x a + d2 a x b) / (a . b x c); the
  // multipliers are the products of x - goal with the same cross products, divided by the same
  // volume.
  const Vec3 c = active[2]->normal;
  const Vec3 bc = cross(b, c), ca = cross(c, a);
  const double volume = dot(c, line);
  if (std::abs(volume) < kParallel)
    return false;
  const Vec3 offset = (bc * depth[0] + ca * depth[1] + line * depth[2]) * (1.0 / volume);
  multiplier = {dot(offset, bc) / volume, dot(offset, ca) / volume, dot(offset, line) / volume};
  return true;
}

} // namespace

std::optional<NearestPoint> nearest_point(std::span<const HalfSpace> faces,
                                          const Vec3& goal) noexcept {
  const std::size_t count = std::min(faces.size(), kMaxHalfSpaces);
  for (int active_count = 0; active_count <= 3; ++active_count)
    for (unsigned set = 0; set < 1u << count; ++set) {
      std::array<const HalfSpace*, 3> active{};
      std::array<std::size_t, 3> index{};
      std::size_t size = 0;
      for (std::size_t i = 0; i < count; ++i)
        if (set >> i & 1u) {
          if (size < 3)
            active[size] = &faces[i], index[size] = i;
          ++size;
        }
      if (size != static_cast<std::size_t>(active_count))
        continue;
      std::array<double, 3> multiplier{};
      if (size > 0 && !solve_multipliers({active.data(), size}, goal, multiplier))
        continue;
      NearestPoint nearest{goal, {}};
      bool feasible = true;
      for (std::size_t i = 0; i < size; ++i) {
        feasible = feasible && multiplier[i] >= -kTolerance_m;
        nearest.multiplier[index[i]] = std::max(multiplier[i], 0.0);
        nearest.point += active[i]->normal * multiplier[i];
      }
      for (std::size_t i = 0; i < count && feasible; ++i)
        feasible = dot(faces[i].normal, nearest.point) >= faces[i].offset - kTolerance_m;
      if (feasible)
        return nearest;
    }
  return std::nullopt;
}

} // namespace tactus::haptic
