#include "fem/mesh/remesh.hpp"

#include "fem/mesh/triangle_rings.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

namespace tactus::fem {
namespace {

using Edge = std::pair<int, int>;

constexpr double kFeature = 30 * std::numbers::pi / 180; ///< sharper edges are kept
constexpr double kCorner = 45 * std::numbers::pi / 180;  ///< a line of such edges that turns more
                                                         ///< has a corner

class Remesher : TriangleRings {
public:
  Remesher(const Triangles& surface, const std::function<double(const Vec3&)>& edge,
           double deviation)
      : TriangleRings(surface.triangles, surface.points.size()), point_(surface.points),
        shell_(surface.shell), plane_(surface.points.size()), corner_(surface.points.size(), false),
        edge_(edge), max_deviation_(deviation) {
    for (std::size_t v = 0; v < point_.size(); ++v)
      for (const int t : around_[v])
        add_plane(static_cast<int>(v), triangle_[at(t)]);
    find_features();
  }

  Triangles run() {
    collapse_short();
    for (int round = 0; round < 6; ++round) {
      split_long();
      flip_edges();
      collapse_short();
      flip_edges();
      smooth_flat();
    }
    Triangles out;
    int shells = 0;
    for (std::size_t t = 0; t < triangle_.size(); ++t)
      if (alive(t)) {
        out.triangles.push_back(triangle_[t]);
        out.shell.push_back(shell_[t]);
        shells = std::max(shells, shell_[t] + 1);
      }
    out.points = used_points(out.triangles, point_);
    out.shells = shells;
    return out;
  }

private:
  using Plane = std::pair<Vec3, double>;

  static Edge sorted(int a, int b) { return std::minmax(a, b); }
  const Vec3& point(int v) const { return point_[at(v)]; }
  Vec3 normal(const Corners& t) const { // its length is twice the area
    return cross(point(t[1]) - point(t[0]), point(t[2]) - point(t[0]));
  }
  double span(int a, int b) const { return length(point(b) - point(a)); }
  /// The target length of an edge.
  double edge_at(int a, int b) const { return edge_(.5 * (point(a) + point(b))); }

  double quality(const Corners& t) const {
    return fem::quality(point(t[0]), point(t[1]), point(t[2]));
  }

  /// The triangle that runs from a to b, or -1.
  int beside(int a, int b) const {
    // Searches at the corner with fewer triangles, since the centre of a fan may have thousands.
    for (const int t : around_[at(around_[at(a)].size() < around_[at(b)].size() ? a : b)])
      for (std::size_t k = 0; k < 3; ++k)
        if (triangle_[at(t)][k] == a && triangle_[at(t)][(k + 1) % 3] == b)
          return t;
    return -1;
  }
  int third(int t, int a, int b) const {
    for (const int v : triangle_[at(t)])
      if (v != a && v != b)
        return v;
    return -1;
  }
  void add_plane(int v, const Corners& t) {
    const Vec3 n = normal(t);
    const double size = length(n);
    if (size > 0)
      plane_[at(v)].push_back({(1 / size) * n, dot((1 / size) * n, point(t[0]))});
  }
  /// The largest distance of a position from the planes of v and of the vertices merged into it, m.
  double deviation(int v, const Vec3& position) const {
    double max_distance = 0;
    for (const auto& [n, level] : plane_[at(v)])
      max_distance = std::max(max_distance, std::abs(dot(n, position) - level));
    return max_distance;
  }

  /// Whether a normal is close to that of one of the planes of v.
  bool faces_as_before(int v, const Vec3& n) const {
    return std::any_of(plane_[at(v)].begin(), plane_[at(v)].end(),
                       [&](const Plane& p) { return dot(p.first, n) > .8 * length(n); });
  }

  void find_features() {
    for (const auto& [a, b] : edges()) {
      const int left = beside(a, b), right = beside(b, a);
      const Vec3 n = normal(triangle_[at(left)]), m = normal(triangle_[at(right)]);
      if (dot(n, m) < std::cos(kFeature) * length(n) * length(m))
        feature_.insert({a, b});
    }
    std::vector<std::vector<int>> along(point_.size());
    for (const auto& [a, b] : feature_) {
      along[at(a)].push_back(b);
      along[at(b)].push_back(a);
    }
    for (std::size_t v = 0; v < along.size(); ++v) {
      if (along[v].size() == 2) {
        const Vec3 in = point_[v] - point(along[v][0]), out = point(along[v][1]) - point_[v];
        corner_[v] = dot(in, out) < std::cos(kCorner) * length(in) * length(out);
      } else {
        corner_[v] = !along[v].empty();
      }
    }
  }
  bool on_feature(int v) const {
    for (const int w : neighbours(v))
      if (feature_.contains(sorted(v, w)))
        return true;
    return false;
  }

  std::vector<Edge> edges() const {
    std::vector<Edge> all;
    for (const auto& t : triangle_)
      if (t[0] >= 0)
        for (std::size_t k = 0; k < 3; ++k)
          if (t[k] < t[(k + 1) % 3])
            all.emplace_back(t[k], t[(k + 1) % 3]);
    return all;
  }
  /// Edges shorter or longer than a multiple of the target length there, the most extreme first.
  std::vector<Edge> edges_by_length(double limit, bool longer) const {
    std::vector<std::tuple<double, int, int>> found;
    for (const auto& [a, b] : edges())
      if (const double size = span(a, b) / edge_at(a, b); longer ? size > limit : size < limit)
        found.emplace_back(longer ? -size : size, a, b);
    std::sort(found.begin(), found.end());
    std::vector<Edge> out;
    out.reserve(found.size());
    for (const auto& [size, a, b] : found)
      out.emplace_back(a, b);
    return out;
  }

  void replace(int t, const Corners& corners) {
    for (const int v : triangle_[at(t)])
      if (v >= 0)
        std::erase(around_[at(v)], t);
    triangle_[at(t)] = corners;
    for (const int v : corners)
      if (v >= 0)
        around_[at(v)].push_back(t);
  }

  void split_long() {
    for (int pass = 0; pass < 20; ++pass) {
      const auto all = edges_by_length(4. / 3, true);
      if (all.empty())
        return;
      for (const auto& [a, b] : all)
        split(a, b);
    }
  }
  void split(int a, int b) {
    const int left = beside(a, b), right = beside(b, a);
    if (left < 0 || right < 0)
      return;
    const int m = static_cast<int>(point_.size());
    point_.push_back(.5 * (point(a) + point(b)));
    around_.emplace_back();
    plane_.emplace_back();
    corner_.push_back(false);
    add_plane(m, triangle_[at(left)]);
    add_plane(m, triangle_[at(right)]);
    if (feature_.erase(sorted(a, b)) > 0) {
      feature_.insert(sorted(a, m));
      feature_.insert(sorted(m, b));
    }
    for (const auto& [t, from, to] : {std::tuple(left, a, b), {right, b, a}}) {
      const int c = third(t, a, b), new_triangle = static_cast<int>(triangle_.size());
      triangle_.push_back({-1, -1, -1});
      shell_.push_back(shell_[at(t)]);
      replace(t, {from, m, c});
      replace(new_triangle, {m, to, c});
    }
  }

  void collapse_short() {
    for (int pass = 0; pass < 12; ++pass) {
      std::size_t done = 0;
      for (const auto& [a, b] : edges_by_length(.8, false))
        done += collapse(a, b) || collapse(b, a);
      if (done == 0)
        return;
    }
  }
  bool collapse(int from, int onto) {
    const bool along = feature_.contains(sorted(from, onto));
    if (corner_[at(from)] || (!along && on_feature(from)))
      return false;
    if (deviation(from, point(onto)) > max_deviation_ || !can_merge(from, onto))
      return false;
    for (const int t : around_[at(from)]) {
      Corners corners = triangle_[at(t)];
      if (has(corners, onto))
        continue;
      const Vec3 before = normal(corners);
      const double shape = quality(corners);
      std::replace(corners.begin(), corners.end(), from, onto);
      const Vec3 after = normal(corners);
      for (const int v : corners)
        if (v != onto && span(v, onto) > 4. / 3 * edge_at(v, onto) && span(v, onto) > span(v, from))
          return false;
      if (shape > .02 ? dot(before, after) <= .8 * length(before) * length(after)
                      : !faces_as_before(from, after)) // a sliver's own normal is unreliable
        return false;
      if (quality(corners) < std::min(.2, .8 * shape))
        return false;
    }
    const auto ring = neighbours(from);
    for (const int t : std::vector<int>(around_[at(from)])) {
      Corners corners = triangle_[at(t)];
      if (has(corners, onto)) {
        replace(t, {-1, -1, -1});
        continue;
      }
      std::replace(corners.begin(), corners.end(), from, onto);
      replace(t, corners);
    }
    for (const int w : ring)
      if (feature_.erase(sorted(from, w)) > 0 && w != onto)
        feature_.insert(sorted(onto, w));
    plane_[at(onto)].insert(plane_[at(onto)].end(), plane_[at(from)].begin(),
                            plane_[at(from)].end());
    plane_[at(from)].clear();
    thin_out(plane_[at(onto)]);
    return true;
  }
  /// Keeps one of the planes that are equal up to rounding. If there are very many, as on a fine
  /// round surface, also keeps only one of those that differ little (2.5 degrees at most), so that
  /// the time does not grow with their number.
  void thin_out(std::vector<Plane>& planes) const {
    double cosine_tolerance = 1e-6, level = 1e-2 * max_deviation_;
    for (int round = 0; round < 4; ++round) {
      std::vector<Plane> kept;
      for (const Plane& p : planes)
        if (std::none_of(kept.begin(), kept.end(), [&](const Plane& q) {
              return dot(p.first, q.first) > 1 - cosine_tolerance &&
                     std::abs(p.second - q.second) < level;
            }))
          kept.push_back(p);
      planes = std::move(kept);
      if (planes.size() <= 32)
        return;
      cosine_tolerance *= 10;
      level = std::min(2 * level, .1 * max_deviation_);
    }
  }

  /// Flips edges between coplanar neighbours if that improves the worse of the two triangles.
  void flip_edges() {
    for (int pass = 0; pass < 10; ++pass) {
      std::size_t done = 0;
      for (const auto& [a, b] : edges())
        done += flip_edge(a, b);
      if (done == 0)
        return;
    }
  }
  bool flip_edge(int a, int b) {
    if (feature_.contains(sorted(a, b)))
      return false;
    const int left = beside(a, b), right = beside(b, a);
    if (left < 0 || right < 0)
      return false;
    const int c = third(left, a, b), d = third(right, a, b);
    if (c == d || beside(c, d) >= 0 || beside(d, c) >= 0)
      return false;
    const Corners first{c, d, b}, second{d, c, a};
    const double now = std::min(quality(triangle_[at(left)]), quality(triangle_[at(right)]));
    if (std::min(quality(first), quality(second)) < now + 1e-3)
      return false;
    const Vec3 whole = normal(triangle_[at(left)]) + normal(triangle_[at(right)]);
    const double size = length(whole);
    if (!(size > 0))
      return false;
    const double bend = std::abs(dot(whole, point(d) - point(c))) +
                        std::abs(dot(whole, point(b) - point(a))) +
                        std::abs(dot(whole, point(c) - point(a)));
    const Vec3 n = normal(first), m = normal(second);
    if (bend > max_deviation_ * size || dot(n, whole) <= .9 * length(n) * size ||
        dot(m, whole) <= .9 * length(m) * size)
      return false;
    replace(left, first);
    replace(right, second);
    return true;
  }

  /// Moves points whose triangles are coplanar to the centre of their neighbours.
  void smooth_flat() {
    for (int pass = 0; pass < 3; ++pass)
      for (int v = 0; v < static_cast<int>(point_.size()); ++v) {
        if (around_[at(v)].empty() || on_feature(v))
          continue;
        Vec3 whole, middle;
        for (const int t : around_[at(v)])
          whole += normal(triangle_[at(t)]);
        const double size = length(whole);
        const auto ring = neighbours(v);
        for (const int w : ring)
          middle += (1. / static_cast<double>(ring.size())) * point(w);
        double worst = 1, bend = 0;
        for (const int t : around_[at(v)])
          worst = std::min(worst, quality(triangle_[at(t)]));
        for (const int w : ring)
          bend = std::max(bend, std::abs(dot(whole, point(w) - point(v))));
        if (!(size > 0) || bend > 1e-3 * max_deviation_ * size)
          continue;
        const Vec3 before = point(v);
        point_[at(v)] = middle - (dot(whole, middle - before) / (size * size)) * whole;
        for (const int t : around_[at(v)])
          if (quality(triangle_[at(t)]) < worst || dot(normal(triangle_[at(t)]), whole) <= 0) {
            point_[at(v)] = before;
            break;
          }
      }
  }

  std::vector<Vec3> point_;
  std::vector<int> shell_;
  std::vector<std::vector<Plane>> plane_; ///< unit normals and levels of a point's planes
  std::vector<bool> corner_;
  std::set<Edge> feature_;
  const std::function<double(const Vec3&)>& edge_;
  double max_deviation_;
};

} // namespace

Triangles remeshed(const Triangles& surface, const std::function<double(const Vec3&)>& edge,
                   double deviation) {
  return Remesher(surface, edge, deviation).run();
}

} // namespace tactus::fem
