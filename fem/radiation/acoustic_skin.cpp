#include "fem/radiation/acoustic_skin.hpp"

#include "fem/mesh/triangle_rings.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>

namespace tactus::fem {
namespace {

Vec3 double_area(const AcousticSkin& s, const std::array<int, 3>& t) {
  const Vec3& a = s.vertex[static_cast<std::size_t>(t[0])];
  return cross(s.vertex[static_cast<std::size_t>(t[1])] - a,
               s.vertex[static_cast<std::size_t>(t[2])] - a);
}

/// Removes vertices that no triangle uses.
AcousticSkin compact(AcousticSkin s) {
  s.vertex = used_points(s.triangle, s.vertex);
  return s;
}

AcousticSkin refined(const AcousticSkin& s) {
  AcousticSkin out{s.vertex, {}};
  std::map<std::pair<int, int>, int> middle;
  const auto mid = [&](int a, int b) {
    const auto [at, added] =
        middle.try_emplace(std::minmax(a, b), static_cast<int>(out.vertex.size()));
    if (added)
      out.vertex.push_back(
          .5 * (s.vertex[static_cast<std::size_t>(a)] + s.vertex[static_cast<std::size_t>(b)]));
    return at->second;
  };
  for (const auto& [a, b, c] : s.triangle) {
    const int ab = mid(a, b), bc = mid(b, c), ca = mid(c, a);
    out.triangle.insert(out.triangle.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return out;
}

} // namespace

AcousticSkin outer_skin(const Mesh& mesh) {
  const Surface skin = surface_of(mesh);
  AcousticSkin all;
  for (const int node : skin.node)
    all.vertex.push_back(mesh.nodes[static_cast<std::size_t>(node)]);
  all.triangle = skin.triangles;
  std::vector<int> part(all.vertex.size());
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](int v) {
    while (part[static_cast<std::size_t>(v)] != v)
      v = part[static_cast<std::size_t>(v)] =
          part[static_cast<std::size_t>(part[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const auto& t : all.triangle)
    for (const int v : t)
      part[static_cast<std::size_t>(root(v))] = root(t[0]);
  std::vector<double> enclosed(all.vertex.size(), 0);
  for (const auto& t : all.triangle)
    enclosed[static_cast<std::size_t>(root(t[0]))] +=
        dot(all.vertex[static_cast<std::size_t>(t[0])], double_area(all, t)) / 6;
  std::erase_if(all.triangle,
                [&](const auto& t) { return enclosed[static_cast<std::size_t>(root(t[0]))] <= 0; });
  return all;
}

namespace {

/// Symmetric 4 x 4 sums of squared distances to planes.
struct Quadric {
  std::array<double, 10> q{};
  void add(const Vec3& n, double d) {
    const std::array<double, 4> p{n.x, n.y, n.z, d};
    for (std::size_t i = 0, at = 0; i < 4; ++i)
      for (std::size_t j = i; j < 4; ++j)
        q[at++] += p[i] * p[j];
  }
  [[nodiscard]] double operator()(const Vec3& v) const {
    const std::array<double, 4> p{v.x, v.y, v.z, 1};
    double sum = 0;
    for (std::size_t i = 0, at = 0; i < 4; ++i)
      for (std::size_t j = i; j < 4; ++j)
        sum += (i == j ? 1 : 2) * q[at++] * p[i] * p[j];
    return std::max(sum, 0.0);
  }
};

/// The ends of all edges at which the skin turns outwards by more than 40 degrees. There the
/// velocity of the air is infinite: the pressure is proportional to r^(2/3) at a right angle.
std::vector<std::array<int, 2>> sharp_edges(const AcousticSkin& s) {
  std::map<std::pair<int, int>, std::size_t> owner;
  for (std::size_t t = 0; t < s.triangle.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      owner[{s.triangle[t][k], s.triangle[t][(k + 1) % 3]}] = t;
  const double limit = std::cos(40 * std::numbers::pi / 180);
  std::vector<std::array<int, 2>> sharp;
  for (const auto& [edge, t] : owner) {
    const auto back = owner.find({edge.second, edge.first});
    if (edge.first > edge.second || back == owner.end())
      continue;
    const Vec3 n = double_area(s, s.triangle[t]), m = double_area(s, s.triangle[back->second]);
    Vec3 middle;
    for (const int v : s.triangle[back->second])
      middle += (1. / 3) * s.vertex[static_cast<std::size_t>(v)];
    const bool outwards = dot(middle - s.vertex[static_cast<std::size_t>(edge.first)], n) < 0;
    if (outwards && dot(n, m) < limit * length(n) * length(m))
      sharp.push_back({edge.first, edge.second});
  }
  return sharp;
}

/// A fourth coordinate that makes distances away from sharp edges longer, so that triangles of
/// equal size in four dimensions are flat beside such edges. At a distance d below `reach`, an edge
/// across of length h becomes about h sqrt(d/reach) long.
std::vector<double> edge_depth(const AcousticSkin& s, double reach) {
  std::vector<double> depth(s.vertex.size(), 2 * reach);
  const auto edges = sharp_edges(s);
  for (std::size_t v = 0; v < depth.size(); ++v) {
    double nearest = reach;
    for (const auto& edge : edges) {
      const Vec3& a = s.vertex[static_cast<std::size_t>(edge[0])];
      const Vec3 along = s.vertex[static_cast<std::size_t>(edge[1])] - a, offset = s.vertex[v] - a;
      const double at = std::clamp(dot(offset, along) / dot(along, along), 0.0, 1.0);
      nearest = std::min(nearest, length(offset - at * along));
    }
    depth[v] = 2 * std::sqrt(reach * nearest);
  }
  return depth;
}

class Collapse : TriangleRings {
public:
  Collapse(AcousticSkin skin, std::size_t triangles)
      : TriangleRings(skin.triangle, skin.vertex.size()), skin_(std::move(skin)),
        target_triangles_(triangles), quadric_(skin_.vertex.size()), count_(triangle_.size()) {
    double area = 0;
    for (const auto& t : triangle_)
      area += length(double_area(skin_, t)) / 2;
    depth_ = edge_depth(skin_, kGradedEdges * even_edge(area));
    for (const Corners& t : triangle_) {
      const Vec3 n = double_area(skin_, t);
      const double size = length(n);
      for (const int v : t)
        if (size > 0)
          quadric_[at(v)].add((1 / size) * n, -dot((1 / size) * n, vertex(t[0])));
    }
  }

  AcousticSkin coarse() {
    // Works in rounds with a growing cost limit, which is fast and deterministic and keeps the
    // sizes even.
    double area = 0; // in four dimensions
    for (const auto& t : triangle_)
      area += shape_of(t).first;
    // Edge of equilateral triangles, with a margin for places where no other collapse is possible.
    longest_ = 1.4 * even_edge(area);
    double limit = 1e-4 * area / static_cast<double>(target_triangles_);
    for (int round = 0; round < 80 && count_ > target_triangles_;
         ++round, limit *= 1.35, longest_ *= 1.01) {
      std::vector<std::tuple<double, int, int>> edges;
      for (std::size_t t = 0; t < triangle_.size(); ++t)
        if (alive(t))
          for (std::size_t k = 0; k < 3; ++k) {
            const int a = triangle_[t][k], b = triangle_[t][(k + 1) % 3];
            for (const auto& [from, onto] : {std::pair(a, b), std::pair(b, a)})
              if (const double c = cost(from, onto); c < limit)
                edges.emplace_back(c, from, onto);
          }
      std::sort(edges.begin(), edges.end());
      for (const auto& [c, from, onto] : edges)
        if (count_ > target_triangles_ && std::abs(cost(from, onto) - c) <= 1e-9 * c)
          collapse(from, onto);
    }
    AcousticSkin out{skin_.vertex, {}};
    for (std::size_t t = 0; t < triangle_.size(); ++t)
      if (alive(t))
        out.triangle.push_back(triangle_[t]);
    return compact(std::move(out));
  }

private:
  const Vec3& vertex(int v) const { return skin_.vertex[at(v)]; }
  /// Edge of equilateral triangles, `target_triangles_` of which cover an area.
  double even_edge(double area) const {
    return std::sqrt(4 / std::sqrt(3.0) * area / static_cast<double>(target_triangles_));
  }
  /// The squared distance in four dimensions.
  double separation(int a, int b) const {
    const Vec3 offset = vertex(b) - vertex(a);
    const double down = depth_[at(b)] - depth_[at(a)];
    return dot(offset, offset) + down * down;
  }
  /// Area in four dimensions (Heron), and 1 for an equilateral triangle there, 0 for a line.
  std::pair<double, double> shape_of(const std::array<int, 3>& t) const {
    const double a = separation(t[0], t[1]), b = separation(t[1], t[2]), c = separation(t[2], t[0]);
    const double sum = a + b + c;
    const double area = std::sqrt(std::max(sum * sum - 2 * (a * a + b * b + c * c), 0.0)) / 4;
    return {area, sum > 0 ? 4 * std::sqrt(3.0) * area / sum : 0};
  }
  double cost(int from, int onto) const {
    return quadric_[at(from)](vertex(onto)) + .05 * separation(from, onto);
  }
  bool collapse(int from, int onto) {
    if (!can_merge(from, onto, 24))
      return false;
    for (const int t : around_[at(from)]) {
      Corners corners = triangle_[at(t)];
      if (has(corners, onto))
        continue;
      const Vec3 before = double_area(skin_, corners);
      const double shape = shape_of(corners).second;
      std::replace(corners.begin(), corners.end(), from, onto);
      const Vec3 after = double_area(skin_, corners);
      for (const int v : corners)
        if (v != onto && separation(v, onto) > longest_ * longest_)
          return false;
      if (dot(before, after) <= .7 * length(before) * length(after) ||
          shape_of(corners).second < std::min(.35, .8 * shape))
        return false;
    }
    count_ -= merge(from, onto);
    for (std::size_t i = 0; i < 10; ++i)
      quadric_[at(onto)].q[i] += quadric_[at(from)].q[i];
    return true;
  }

  static constexpr double kGradedEdges = 1;

  AcousticSkin skin_;
  std::size_t target_triangles_;
  std::vector<double> depth_; ///< m, the fourth coordinate
  std::vector<Quadric> quadric_;
  std::size_t count_;  ///< number of triangles left
  double longest_ = 0; ///< m, longest edge that a collapse may make
};

} // namespace

AcousticSkin with_triangles(const AcousticSkin& skin, std::size_t triangles) {
  AcousticSkin out = compact(skin);
  while (4 * out.triangle.size() <= triangles)
    out = refined(out);
  if (const std::size_t now = out.triangle.size(); now != triangles)
    if (2 * now <= triangles || (now <= 4 * triangles && !sharp_edges(out).empty()))
      out = refined(out); // will be coarsened again, but less beside sharp edges
  return out.triangle.size() > triangles ? Collapse(std::move(out), triangles).coarse() : out;
}

std::array<double, 3> nearest_on_triangle(const std::array<Vec3, 3>& c, const Vec3& p) {
  const Vec3 ab = c[1] - c[0], ac = c[2] - c[0], ap = p - c[0], n = cross(ab, ac);
  const double area = dot(n, n);
  const double v = dot(cross(ap, ac), n) / area, w = dot(cross(ab, ap), n) / area;
  if (v >= 0 && w >= 0 && v + w <= 1)
    return {1 - v - w, v, w};
  std::array<double, 3> best{};
  double min_distance_squared = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const Vec3 edge = c[next] - c[k];
    const double s = std::clamp(dot(p - c[k], edge) / dot(edge, edge), 0.0, 1.0);
    const Vec3 off = p - c[k] - s * edge;
    if (dot(off, off) < min_distance_squared) {
      min_distance_squared = dot(off, off);
      best = {};
      best[k] = 1 - s;
      best[next] = s;
    }
  }
  return best;
}

FlowTransfer::FlowTransfer(const AcousticSkin& fine, const AcousticSkin& coarse)
    : fine_(fine.triangle), count_(coarse.vertex.size()) {
  std::vector<Vec3> middle, normal;
  std::vector<double> radius;
  for (const auto& t : coarse.triangle) {
    Vec3 sum;
    for (const int v : t)
      sum += coarse.vertex[static_cast<std::size_t>(v)];
    middle.push_back((1. / 3) * sum);
    const Vec3 n = double_area(coarse, t);
    normal.push_back((1 / length(n)) * n);
    double r = 0;
    for (const int v : t)
      r = std::max(r, length(coarse.vertex[static_cast<std::size_t>(v)] - middle.back()));
    radius.push_back(r);
  }
  for (const auto& t : fine.triangle) {
    const Vec3 twice = double_area(fine, t);
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 p;
      for (std::size_t j = 0; j < 3; ++j)
        p += (j == k ? 2. / 3 : 1. / 6) * fine.vertex[static_cast<std::size_t>(t[j])];
      Share share{};
      double min_distance_squared = std::numeric_limits<double>::infinity();
      for (std::size_t u = 0; u < coarse.triangle.size(); ++u) {
        if (dot(normal[u], twice) <= 0) // skips the other side of a thin wall, which is near but
                                        // wrong
          continue;
        const double away = length(p - middle[u]) - radius[u];
        if (away > 0 && away * away >= min_distance_squared)
          continue;
        std::array<Vec3, 3> corner;
        for (std::size_t j = 0; j < 3; ++j)
          corner[j] = coarse.vertex[static_cast<std::size_t>(coarse.triangle[u][j])];
        const auto weight = nearest_on_triangle(corner, p);
        const Vec3 off =
            p - (weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2]);
        if (dot(off, off) < min_distance_squared) {
          min_distance_squared = dot(off, off);
          share = {coarse.triangle[u], weight, (1. / 6) * twice};
        }
      }
      shares_.push_back(share);
    }
  }
}

std::vector<double> FlowTransfer::operator()(std::span<const Vec3> velocity) const {
  std::vector<double> flow(count_, 0.0);
  for (std::size_t s = 0; s < shares_.size(); ++s) {
    const auto& t = fine_[s / 3];
    Vec3 v;
    for (std::size_t j = 0; j < 3; ++j)
      v += (j == s % 3 ? 2. / 3 : 1. / 6) * velocity[static_cast<std::size_t>(t[j])];
    const double through = dot(v, shares_[s].area);
    for (std::size_t j = 0; j < 3; ++j)
      flow[static_cast<std::size_t>(shares_[s].to[j])] += shares_[s].weight[j] * through;
  }
  return flow;
}

} // namespace tactus::fem
