#include "core/haptic/scene/convex_crossing.hpp"
#include "core/haptic/scene/triangle_mesh.hpp"

/// TriangleMesh's queries: crossing of a point and of a sphere, nearest point.
namespace tactus::haptic {
namespace {

/// motion . (a x b), six times the signed volume of the tetrahedron that the origin, a motion from
/// the origin and the edge a b form. Exchanging a and b gives exactly the negative, whatever the
/// rounding.
double signed_volume(const Vec3& motion, const Vec3& a, const Vec3& b) noexcept {
  return motion.x * (a.y * b.z - a.z * b.y) + motion.y * (a.z * b.x - a.x * b.z) +
         motion.z * (a.x * b.y - a.y * b.x);
}

/// The point of a triangle nearest to p, by its Voronoi regions (Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.5).
Vec3 nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0)
    return a;
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3)
    return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
    return a + ab * (d1 / (d1 - d3));
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6)
    return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
    return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double sum = va + vb + vc;
  return a + ab * (vb / sum) + ac * (vc / sum);
}

} // namespace

TriangleMesh::Approach TriangleMesh::Plate::approach(const Vec3& p, const Vec3& motion,
                                                     double length) const noexcept {
  // Single precision makes the axis slightly longer or shorter than 1. The relative error of the
  // distance from the centre and of the slope (relative to the length of the motion) is below
  // kRounding.
  constexpr double kRounding = 3e-7;
  const Vec3 n{axis[0], axis[1], axis[2]}, from_centre = p - Vec3{centre[0], centre[1], centre[2]};
  const double height = dot(from_centre, n);
  const Vec3 lateral = from_centre - n * height;
  const double squared = dot(lateral, lateral), above = std::abs(height) - half_thickness;
  const double rise = height < 0.0 ? -dot(motion, n) : dot(motion, n), slack = kRounding * length;
  const auto shortened = [&](double distance) {
    return distance - kRounding * (distance + half_thickness + radius);
  };
  if (squared <= static_cast<double>(radius) * radius)
    return {shortened(above), rise - slack};
  const double distance = std::sqrt(squared), outside = distance - radius;
  const double drift = dot(motion, lateral) / distance;
  if (above <= 0.0)
    return {shortened(outside), drift - slack};
  const double gap = std::sqrt(above * above + outside * outside);
  return {shortened(gap), (above * rise + outside * drift) / gap - slack};
}

/// Visits the triangles of all leaves that a sphere (radius 0: a point) may reach on a straight
/// motion before the fraction `limit`, which the visitor lowers as it finds contacts. The nearer
/// child comes first, so that most of the tree is skipped.
template <class Visit>
void TriangleMesh::traverse(const Vec3& from, const Vec3& to, double radius, const double& limit,
                            WorkLimit& work, const Visit& visit) const noexcept {
  if (nodes_.empty())
    return;
  const Segment segment(from, to);
  const Vec3 motion = to - from;
  const double length = std::sqrt(dot(motion, motion));
  struct PendingNode {
    std::uint32_t node;
    double entry;    ///< lower bound of the fraction
    double distance; ///< m, of a sphere, from the point where the motion begins
  };
  const auto make_pending = [&](std::uint32_t node, double parent_entry) {
    PendingNode pending{node, parent_entry, 0.0};
    if (radius == 0.0) {
      pending.entry = segment.entry(nodes_[node].bounds(), 0.0, limit);
      return pending;
    }
    // The first steps of convex_crossing() with the plate.
    constexpr int kSteps = 3;
    constexpr double kSlack_m = 1e-12; // far above the tolerance and the rounding of
                                       // convex_crossing()
    for (int step = 0; step < kSteps && pending.entry <= limit; ++step) {
      work.spend(kStepWork);
      const Approach at = plates_[node].approach(from + motion * pending.entry, motion, length);
      const double gap = at.distance - (radius + kSlack_m);
      if (step == 0)
        pending.distance = at.distance;
      if (gap <= 0.0)
        break;
      pending.entry = at.slope < 0.0 ? pending.entry + gap / -at.slope : Segment::kNever;
    }
    if (pending.entry > limit)
      pending.entry = Segment::kNever;
    return pending;
  };
  // A sphere may overlap many plates at once, all entered at 0: the nearest of these is visited
  // first.
  const auto visited_later = [](const PendingNode& a, const PendingNode& b) {
    return a.entry > b.entry || (a.entry == b.entry && a.distance > b.distance);
  };
  std::array<PendingNode, kMaxDepth + 2> stack;
  std::size_t count = 0;
  work.spend(kNodeWork);
  stack[count++] = make_pending(0, 0.0);
  while (count > 0) {
    const PendingNode next = stack[--count];
    if (next.entry > limit)
      continue;
    const Node& node = nodes_[next.node];
    if (node.count > 0) {
      for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
        if (!work.spend(kTriangleWork))
          return;
        else
          visit(t, next.entry);
      continue;
    }
    if (!work.spend(kNodeWork))
      return;
    PendingNode near = make_pending(node.first, next.entry),
                far = make_pending(node.first + 1, next.entry);
    if (visited_later(near, far))
      std::swap(near, far);
    if (far.entry != Segment::kNever)
      stack[count++] = far;
    if (near.entry != Segment::kNever)
      stack[count++] = near;
  }
}

std::optional<Crossing> TriangleMesh::crossing(const Vec3& from, const Vec3& to,
                                               WorkLimit& work) const noexcept {
  const Vec3 motion = to - from;
  double fraction = 1.0;
  std::optional<Crossing> first;
  std::uint32_t triangle = 0;
  traverse(from, to, 0.0, fraction, work, [&](std::uint32_t t, double) {
    const Corners at = corners_of(t);
    const Vec3 a = at.a - from, b = at.b - from, c = at.c - from;
    const double u = signed_volume(motion, a, b), v = signed_volume(motion, b, c),
                 w = signed_volume(motion, c, a);
    if (!((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)))
      return;
    Vec3 normal = cross(b - a, c - a);
    const double slope = dot(motion, normal), height = dot(a, normal);
    if (slope == 0.0) // motion along the surface
      return;
    const double crossing_fraction = height / slope;
    if (!(crossing_fraction >= 0.0 && crossing_fraction <= fraction) ||
        (first && crossing_fraction == fraction && t < triangle))
      return;
    if (slope > 0.0)
      normal = -normal;
    fraction = crossing_fraction;
    triangle = t;
    first = Crossing{crossing_fraction, normal * (1.0 / norm(normal))};
  });
  return first;
}

std::optional<Crossing> TriangleMesh::crossing(double radius, const Vec3& from, const Vec3& to,
                                               WorkLimit& work) const noexcept {
  double fraction = 1.0;
  std::optional<Crossing> first;
  std::uint32_t triangle = 0;
  traverse(from, to, radius, fraction, work, [&](std::uint32_t t, double entry) {
    const Corners at = corners_of(t);
    const auto found = convex_crossing(
        radius, from, to, entry, fraction,
        [&](const Vec3& p) { return nearest_on_triangle(p, at.a, at.b, at.c); }, work);
    if (!found || (first && found->fraction == fraction && t < triangle))
      return;
    fraction = found->fraction;
    triangle = t;
    first = found;
  });
  return first;
}

std::optional<TriangleMesh::Nearest> TriangleMesh::nearest(const Vec3& p, double limit,
                                                           WorkLimit& work) const noexcept {
  std::optional<Nearest> best;
  if (nodes_.empty())
    return best;
  double squared_limit = limit * limit;
  struct PendingNode {
    std::uint32_t node;
    double squared;
  };
  std::array<PendingNode, kMaxDepth + 2> stack;
  std::size_t count = 0;
  stack[count++] = {0, squared_distance(bounds_, p)};
  while (count > 0) {
    const PendingNode next = stack[--count];
    if (next.squared >= squared_limit)
      continue;
    const Node& node = nodes_[next.node];
    if (!work.spend(kNodeWork + kTriangleWork * static_cast<int>(node.count)))
      return best;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      const Corners at = corners_of(t);
      const Vec3 point = nearest_on_triangle(p, at.a, at.b, at.c);
      const double squared = dot(p - point, p - point);
      if (squared >= squared_limit)
        continue;
      squared_limit = squared;
      const Vec3 area = cross(at.b - at.a, at.c - at.a);
      best = Nearest{point, std::sqrt(squared), area * (1.0 / norm(area))};
    }
    if (node.count > 0)
      continue;
    PendingNode near{node.first, 0}, far{node.first + 1, 0};
    near.squared = squared_distance(nodes_[near.node].bounds(), p);
    far.squared = squared_distance(nodes_[far.node].bounds(), p);
    if (far.squared < near.squared)
      std::swap(near, far);
    stack[count++] = far;
    stack[count++] = near;
  }
  return best;
}

} // namespace tactus::haptic
