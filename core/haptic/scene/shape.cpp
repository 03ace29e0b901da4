#include "core/haptic/scene/shape.hpp"

#include <limits>

namespace tactus::haptic {
namespace {

using Found = std::optional<Crossing>;

// Where a rim meets a face, rounding must not leave a slit between them.
constexpr double kSeam_m = 1e-13;

Found enters(const Plane&, const Vec3& from, const Vec3& to) noexcept {
  if (!(from.z >= 0.0 && to.z < 0.0))
    return {};
  return Crossing{from.z / (from.z - to.z), {0, 0, 1}};
}

/// Share at which |from + s way| first falls to the radius, over the chosen axes; nothing when
/// the way begins inside or never gets there. a s^2 + 2 b s + c = 0, in the form that keeps its
/// digits when the way begins at the surface.
std::optional<double> enters_circle(double a, double b, double c) noexcept {
  const double discriminant = b * b - a * c;
  if (!(c >= 0.0 && b < 0.0 && discriminant >= 0.0))
    return {};
  const double share = c / (-b + std::sqrt(discriminant));
  return share <= 1.0 ? std::optional(share) : std::nullopt;
}

Found enters(const Sphere& sphere, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 way = to - from;
  const double distance = norm(from);
  const double outside = (distance - sphere.radius) * (distance + sphere.radius);
  const auto share = enters_circle(dot(way, way), dot(from, way), outside);
  if (!share)
    return {};
  const Vec3 point = from + way * *share;
  return Crossing{*share, point * (1.0 / norm(point))};
}

Found enters(const Box& box, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 way = to - from;
  double begin = -1.0, end = 1.0;
  Vec3 normal;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = box.half[axis], here = from[axis], w = way[axis];
    if (w == 0.0) {
      if (std::abs(here) >= half)
        return {};
      continue;
    }
    const double face = w < 0.0 ? half : -half;
    const double in = (face - here) / w, out = (-face - here) / w;
    if (in > begin) {
      begin = in;
      normal = {};
      normal[axis] = w < 0.0 ? 1.0 : -1.0;
    }
    end = std::min(end, out);
  }
  return begin >= 0.0 && begin < end ? Found(Crossing{begin, normal}) : std::nullopt;
}

Found enters(const Disk& disk, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 way = to - from;
  const auto radius_at = [&](double share) {
    return std::hypot(from.x + way.x * share, from.y + way.y * share);
  };
  if (std::abs(from.z) >= disk.half_thickness && way.z * from.z < 0.0) {
    const double face = from.z > 0.0 ? disk.half_thickness : -disk.half_thickness;
    const double share = (face - from.z) / way.z;
    if (share <= 1.0 && radius_at(share) < disk.radius)
      return Crossing{share, {0, 0, from.z > 0.0 ? 1.0 : -1.0}};
  }
  const double distance = std::hypot(from.x, from.y);
  const auto share = enters_circle(way.x * way.x + way.y * way.y, from.x * way.x + from.y * way.y,
                                   (distance - disk.radius) * (distance + disk.radius));
  if (!share || std::abs(from.z + way.z * *share) > disk.half_thickness + kSeam_m)
    return {};
  const double x = from.x + way.x * *share, y = from.y + way.y * *share, r = std::hypot(x, y);
  return Crossing{*share, {x / r, y / r, 0}};
}

Found enters(const MeshSurface& surface, const Vec3& from, const Vec3& to) noexcept {
  return surface.mesh->crossing(from, to);
}

using Way = std::optional<SurfacePoint>;

Way way_out(const Plane&, const Vec3& p) noexcept {
  return p.z < 0.0 ? Way({{p.x, p.y, 0}, {0, 0, 1}}) : std::nullopt;
}
Way way_out(const Sphere& sphere, const Vec3& p) noexcept {
  const double distance = norm(p);
  if (!(distance < sphere.radius))
    return {};
  const Vec3 normal = distance > 0.0 ? p * (1.0 / distance) : Vec3{0, 1, 0};
  return SurfacePoint{normal * sphere.radius, normal};
}
Way way_out(const Box& box, const Vec3& p) noexcept {
  int nearest = 0;
  double depth = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double here = box.half[axis] - std::abs(p[axis]);
    if (!(here > 0.0))
      return {};
    if (here < depth)
      depth = here, nearest = axis;
  }
  SurfacePoint out{p, {}};
  const double sign = p[nearest] < 0.0 ? -1.0 : 1.0;
  out.point[nearest] = sign * box.half[nearest];
  out.normal[nearest] = sign;
  return out;
}
Way way_out(const Disk& disk, const Vec3& p) noexcept {
  const double r = std::hypot(p.x, p.y), to_rim = disk.radius - r,
               to_face = disk.half_thickness - std::abs(p.z);
  if (!(to_rim > 0.0 && to_face > 0.0))
    return {};
  const double sign = p.z < 0.0 ? -1.0 : 1.0;
  if (to_face <= to_rim || r == 0.0)
    return SurfacePoint{{p.x, p.y, sign * disk.half_thickness}, {0, 0, sign}};
  const Vec3 normal{p.x / r, p.y / r, 0};
  return SurfacePoint{{normal.x * disk.radius, normal.y * disk.radius, p.z}, normal};
}
Way way_out(const MeshSurface&, const Vec3&) noexcept { return {}; }

double away(const Plane&, const Vec3& p) noexcept { return p.z; }
double away(const Sphere& sphere, const Vec3& p) noexcept { return norm(p) - sphere.radius; }
double away_from_box(const Vec3& low, const Vec3& high, const Vec3& p) noexcept {
  double farthest = -std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    farthest = std::max({farthest, low[axis] - p[axis], p[axis] - high[axis]});
  return farthest;
}
double away(const Box& box, const Vec3& p) noexcept {
  return away_from_box(-box.half, box.half, p);
}
double away(const Disk& disk, const Vec3& p) noexcept {
  return std::max(std::hypot(p.x, p.y) - disk.radius, std::abs(p.z) - disk.half_thickness);
}
double away(const MeshSurface& surface, const Vec3& p) noexcept {
  return away_from_box(surface.mesh->low(), surface.mesh->high(), p);
}

} // namespace

std::optional<Crossing> crossing(const Shape& shape, const Vec3& from, const Vec3& to) noexcept {
  return std::visit([&](const auto& s) { return enters(s, from, to); }, shape);
}

std::optional<SurfacePoint> nearest_way_out(const Shape& shape, const Vec3& inside) noexcept {
  return std::visit([&](const auto& s) { return way_out(s, inside); }, shape);
}

std::optional<SurfacePoint> nearest_on_curve(const Shape& shape, const Vec3& normal,
                                             const Vec3& inside) noexcept {
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    return way_out(*sphere, inside);
  const auto* disk = std::get_if<Disk>(&shape);
  const double r = std::hypot(inside.x, inside.y);
  if (!disk || normal.z != 0.0 || !(r < disk->radius && r > 0.0) ||
      std::abs(inside.z) >= disk->half_thickness)
    return {};
  const Vec3 outward{inside.x / r, inside.y / r, 0};
  return SurfacePoint{{outward.x * disk->radius, outward.y * disk->radius, inside.z}, outward};
}

double at_least_away(const Shape& shape, const Vec3& point) noexcept {
  return std::visit([&](const auto& s) { return away(s, point); }, shape);
}

} // namespace tactus::haptic
