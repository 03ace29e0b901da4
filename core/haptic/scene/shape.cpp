#include "core/dsp/elementary.hpp"
#include "core/haptic/scene/convex_crossing.hpp"
#include "core/haptic/scene/rounded_shape.hpp"

#include <limits>

namespace tactus::haptic {
namespace {

using Found = std::optional<Crossing>;

// Tolerance where a rim meets a face, so that rounding leaves no gap between them.
constexpr double kSeam_m = 1e-13;

Found enters(const Plane&, const Vec3& from, const Vec3& to) noexcept {
  if (!(from.z >= 0.0 && to.z < 0.0))
    return {};
  return Crossing{from.z / (from.z - to.z), {0, 0, 1}};
}

/// The smaller root of a s^2 + 2 b s + c = 0: the fraction s at which |from + s motion| falls to a
/// radius. Nothing if the motion begins inside the circle or does not reach it. The form without
/// cancellation, for a motion that begins at the surface.
std::optional<double> enters_circle(double a, double b, double c) noexcept {
  const double discriminant = b * b - a * c;
  if (!(c >= 0.0 && b < 0.0 && discriminant >= 0.0))
    return {};
  const double fraction = c / (-b + std::sqrt(discriminant));
  return fraction <= 1.0 ? std::optional(fraction) : std::nullopt;
}

Found enters(const Sphere& sphere, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 motion = to - from;
  const double distance = norm(from);
  const double outside = (distance - sphere.radius) * (distance + sphere.radius);
  const auto fraction = enters_circle(dot(motion, motion), dot(from, motion), outside);
  if (!fraction)
    return {};
  const Vec3 point = from + motion * *fraction;
  return Crossing{*fraction, point * (1.0 / norm(point))};
}

Found enters(const Box& box, const Vec3& from, const Vec3& to) noexcept {
  const Vec3 motion = to - from;
  double begin = -1.0, end = 1.0;
  Vec3 normal;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = box.half[axis], here = from[axis], w = motion[axis];
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
  const Vec3 motion = to - from;
  const auto radius_at = [&](double fraction) {
    return math::hypot(from.x + motion.x * fraction, from.y + motion.y * fraction);
  };
  if (std::abs(from.z) >= disk.half_thickness && motion.z * from.z < 0.0) {
    const double face = from.z > 0.0 ? disk.half_thickness : -disk.half_thickness;
    const double fraction = (face - from.z) / motion.z;
    if (fraction <= 1.0 && radius_at(fraction) < disk.radius)
      return Crossing{fraction, {0, 0, from.z > 0.0 ? 1.0 : -1.0}};
  }
  const double distance = math::hypot(from.x, from.y);
  const auto fraction = enters_circle(motion.x * motion.x + motion.y * motion.y,
                                      from.x * motion.x + from.y * motion.y,
                                      (distance - disk.radius) * (distance + disk.radius));
  if (!fraction || std::abs(from.z + motion.z * *fraction) > disk.half_thickness + kSeam_m)
    return {};
  const double x = from.x + motion.x * *fraction, y = from.y + motion.y * *fraction,
               r = math::hypot(x, y);
  return Crossing{*fraction, {x / r, y / r, 0}};
}

using Exit = std::optional<SurfacePoint>;

Exit exit_from(const Plane&, const Vec3& p) noexcept {
  return p.z < 0.0 ? Exit({{p.x, p.y, 0}, {0, 0, 1}}) : std::nullopt;
}
Exit exit_from(const Sphere& sphere, const Vec3& p) noexcept {
  const double distance = norm(p);
  if (!(distance < sphere.radius))
    return {};
  const Vec3 normal = distance > 0.0 ? p * (1.0 / distance) : Vec3{0, 1, 0};
  return SurfacePoint{normal * sphere.radius, normal};
}
Exit exit_from(const Box& box, const Vec3& p) noexcept {
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
Exit exit_from(const Disk& disk, const Vec3& p) noexcept {
  const double r = math::hypot(p.x, p.y), to_rim = disk.radius - r,
               to_face = disk.half_thickness - std::abs(p.z);
  if (!(to_rim > 0.0 && to_face > 0.0))
    return {};
  const double sign = p.z < 0.0 ? -1.0 : 1.0;
  if (to_face <= to_rim || r == 0.0)
    return SurfacePoint{{p.x, p.y, sign * disk.half_thickness}, {0, 0, sign}};
  const Vec3 normal{p.x / r, p.y / r, 0};
  return SurfacePoint{{normal.x * disk.radius, normal.y * disk.radius, p.z}, normal};
}

/// crossing() for each shape.
struct Entry {
  double radius;
  Vec3 from, to;
  WorkLimit& work;

  Found operator()(const Plane& plane) const noexcept {
    return enters(plane, from - Vec3{0, 0, radius}, to - Vec3{0, 0, radius});
  }
  Found operator()(const Sphere& sphere) const noexcept {
    return enters(Sphere{sphere.radius + radius}, from, to);
  }
  template <class Solid> Found operator()(const Solid& solid) const noexcept {
    if (radius == 0.0)
      return enters(solid, from, to);
    return convex_crossing(
        radius, from, to, 0.0, 1.0, [&](const Vec3& p) { return nearest_point(solid, p); }, work);
  }
  Found operator()(const MeshSurface& surface) const noexcept {
    return radius == 0.0 ? surface.mesh->crossing(from, to, work)
                         : surface.mesh->crossing(radius, from, to, work);
  }
};

/// nearest_exit() for each shape.
struct ExitSearch {
  double radius;
  Vec3 inside;
  WorkLimit& work;

  Exit operator()(const Plane& plane) const noexcept {
    Exit out = exit_from(plane, inside - Vec3{0, 0, radius});
    if (out)
      out->point.z += radius;
    return out;
  }
  Exit operator()(const Sphere& sphere) const noexcept {
    return exit_from(Sphere{sphere.radius + radius}, inside);
  }
  template <class Solid> Exit operator()(const Solid& solid) const noexcept {
    if (radius == 0.0)
      return exit_from(solid, inside);
    const Vec3 core = nearest_point(solid, inside), gap = inside - core;
    const double distance = norm(gap);
    if (distance >= radius)
      return {};
    if (distance > 0.0)
      return SurfacePoint{core + gap * (radius / distance), gap * (1.0 / distance)};
    Exit out = exit_from(solid, inside * (1.0 - 1e-12)); // also for a point on the surface
    if (out)
      out->point += out->normal * radius;
    return out;
  }
  Exit operator()(const MeshSurface& surface) const noexcept {
    if (radius == 0.0)
      return {};
    const auto nearest = surface.mesh->nearest(inside, radius, work);
    if (!nearest || work.exhausted())
      return {};
    const Vec3 normal = nearest->distance > 0.0
                            ? (inside - nearest->point) * (1.0 / nearest->distance)
                            : nearest->face_normal;
    return SurfacePoint{nearest->point + normal * radius, normal};
  }
};

} // namespace

std::optional<Crossing> crossing(const Shape& shape, double tool_radius, const Vec3& from,
                                 const Vec3& to, WorkLimit& work) noexcept {
  return std::visit(Entry{tool_radius, from, to, work}, shape);
}

std::optional<SurfacePoint> nearest_exit(const Shape& shape, double tool_radius, const Vec3& inside,
                                         WorkLimit& work) noexcept {
  return std::visit(ExitSearch{tool_radius, inside, work}, shape);
}

std::optional<SurfacePoint> nearest_on_curve(const Shape& shape, double tool_radius,
                                             const Vec3& normal, const Vec3& inside) noexcept {
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    return exit_from(Sphere{sphere->radius + tool_radius}, inside);
  const auto* box = std::get_if<Box>(&shape);
  if (box && tool_radius > 0.0)
    return nearest_on_rounding(*box, tool_radius, normal, inside);
  const auto* disk = std::get_if<Disk>(&shape);
  if (!disk)
    return {};
  const double r = math::hypot(inside.x, inside.y), radius = disk->radius + tool_radius;
  if (normal.z == 0.0 && r < radius && r > 0.0 && std::abs(inside.z) < disk->half_thickness) {
    const Vec3 outward{inside.x / r, inside.y / r, 0};
    return SurfacePoint{{outward.x * radius, outward.y * radius, inside.z}, outward};
  }
  return tool_radius > 0.0 ? nearest_on_rounding(*disk, tool_radius, normal, inside) : std::nullopt;
}

} // namespace tactus::haptic
