#include "fem/mesh/simplify.hpp"

#include "fem/mesh/box_tree.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/distance.hpp"
#include "fem/mesh/triangle_rings.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <queue>
#include <set>

namespace tactus::fem {
namespace {

/// Area-weighted sum of squared distances to planes, as a symmetric form in a point, and the area.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Vec3 linear;
  double constant = 0, area = 0;

  void add(const Vec3& n, double level, double weight) {
    xx += weight * n.x * n.x, xy += weight * n.x * n.y, xz += weight * n.x * n.z;
    yy += weight * n.y * n.y, yz += weight * n.y * n.z, zz += weight * n.z * n.z;
    linear += (weight * level) * n;
    constant += weight * level * level;
    area += weight;
  }
  void add(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
    linear += q.linear;
    constant += q.constant;
    area += q.area;
  }
  [[nodiscard]] double at(const Vec3& p) const {
    const double square = xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z +
                          2 * (xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z);
    return std::max(square - 2 * dot(linear, p) + constant, 0.);
  }
};

class Simplifier : TriangleRings {
public:
  /// Points marked in `kept` and their triangles are not moved.
  Simplifier(const Triangles& surface, const std::function<double(const Vec3&)>& edge,
             double deviation, const std::vector<bool>& kept)
      : TriangleRings(surface.triangles, surface.points.size()), surface_(surface),
        quadric_(surface.points.size()), version_(surface.points.size(), 0), kept_(kept),
        edge_(edge), deviation_(deviation) {
    for (std::size_t t = 0; t < triangle_.size(); ++t) {
      const Vec3 n = normal(triangle_[t]);
      const double size = length(n);
      for (const int v : triangle_[t])
        if (size > 0) // relative to the point itself, to avoid cancellation at large coordinates
          quadric_[at(v)].add((1 / size) * n, dot((1 / size) * n, relative(triangle_[t][0])),
                              size / 2);
    }
  }

  Triangles run() {
    for (const Corners& c : triangle_)
      for (std::size_t k = 0; k < 3; ++k)
        if (c[k] < c[(k + 1) % 3])
          push_candidate(c[k], c[(k + 1) % 3]);
    while (!queue_.empty()) {
      const Candidate c = queue_.top();
      queue_.pop();
      if (version_[at(c.from)] != c.from_version || version_[at(c.onto)] != c.onto_version)
        continue;
      if (collapse(c.from, c.onto))
        for (const int w : neighbours(c.onto))
          push_candidate(c.onto, w);
    }
    return compact();
  }

private:
  struct Candidate {
    double cost;
    int from, onto, from_version, onto_version;
    bool operator<(const Candidate& b) const { // reversed, since the queue has the largest on top
      return cost != b.cost ? cost > b.cost : from != b.from ? from > b.from : onto > b.onto;
    }
  };

  const Vec3& point(int v) const { return surface_.points[at(v)]; }
  Vec3 relative(int v) const { return point(v) - surface_.points[0]; }
  Vec3 normal(const Corners& t) const {
    return cross(point(t[1]) - point(t[0]), point(t[2]) - point(t[0]));
  }
  double span(int a, int b) const { return length(point(b) - point(a)); }
  double target_edge(int a, int b) const { return edge_(.5 * (point(a) + point(b))); }
  double quality(const Corners& t) const {
    return fem::quality(point(t[0]), point(t[1]), point(t[2]));
  }

  /// Puts both collapses of an edge into the queue, the cheaper one first.
  void push_candidate(int a, int b) {
    const double size = span(a, b), target = target_edge(a, b);
    if (size > .8 * target)
      return;
    for (const auto& [from, onto] : {std::pair(a, b), std::pair(b, a)}) {
      if (kept_[at(from)])
        continue;
      Quadric sum = quadric_[at(from)];
      sum.add(quadric_[at(onto)]);
      const double error = sum.at(relative(onto));
      if (error > .06 * deviation_ * deviation_ * sum.area)
        continue;
      // In flat parts the shortest edges collapse first, so that triangles stay even.
      queue_.push({error + 1e-3 * deviation_ * deviation_ * size * size, from, onto,
                   version_[at(from)], version_[at(onto)]});
    }
  }

  bool collapse(int from, int onto) {
    if (!can_merge(from, onto, 28))
      return false;
    for (const int t : around_[at(from)]) {
      Corners corners = triangle_[at(t)];
      if (has(corners, onto))
        continue;
      const Vec3 before = normal(corners);
      const double shape = quality(corners);
      std::replace(corners.begin(), corners.end(), from, onto);
      const Vec3 after = normal(corners);
      if (dot(before, after) <= .7 * length(before) * length(after) ||
          quality(corners) < std::min(.2, .8 * shape))
        return false;
      for (const int v : corners)
        if (v != onto && span(v, onto) > 4. / 3 * target_edge(v, onto) &&
            span(v, onto) > span(v, from))
          return false;
    }
    merge(from, onto);
    quadric_[at(onto)].add(quadric_[at(from)]);
    ++version_[at(from)];
    ++version_[at(onto)];
    return true;
  }

  Triangles compact() const {
    Triangles out;
    out.groups = surface_.groups;
    out.shells = surface_.shells;
    for (std::size_t t = 0; t < triangle_.size(); ++t) {
      if (!alive(t))
        continue;
      out.triangles.push_back(triangle_[t]);
      out.shell.push_back(surface_.shell[t]);
      if (!surface_.group.empty())
        out.group.push_back(surface_.group[t]);
    }
    out.points = used_points(out.triangles, surface_.points);
    return out;
  }

  const Triangles& surface_;
  std::vector<Quadric> quadric_;
  std::vector<int> version_;
  const std::vector<bool>& kept_;
  std::priority_queue<Candidate> queue_;
  const std::function<double(const Vec3&)>& edge_;
  double deviation_;
};

/// Marks the points of a surface around given positions. One of several positions within a quarter
/// of the distance stands for all.
class Marker {
public:
  explicit Marker(const std::vector<Vec3>& points) : marked(points.size(), false) {
    std::vector<Box> boxes;
    boxes.reserve(points.size());
    for (const Vec3& p : points)
      boxes.push_back({p, p});
    tree_.emplace(std::move(boxes));
  }
  void mark(const Vec3& p, double distance) {
    const auto cell = [&](double x) { return std::floor(4 * x / distance); };
    if (done_.insert({distance, cell(p.x), cell(p.y), cell(p.z)}).second)
      tree_->for_each_near({p, p}, distance, [&](std::size_t i) {
        marked[i] = true;
        return true;
      });
  }

  std::vector<bool> marked;

private:
  std::optional<BoxTree> tree_;
  std::set<std::array<double, 4>> done_;
};

} // namespace

Triangles simplified(const Triangles& surface, const std::function<double(const Vec3&)>& edge,
                     double deviation) {
  Marker kept(surface.points);
  for (double reach = 1; reach < 20; reach *= 2) {
    Triangles made = Simplifier(surface, edge, deviation, kept.marked).run();
    bool sound = true;
    for (const auto& pair : crossings(made, 1000))
      for (const std::size_t i : pair)
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3 p = made.corner(i, k);
          sound = false;
          kept.mark(p, reach * edge(p));
        }
    const BoxTree faces(triangle_boxes(made));
    for (std::size_t v = 0; v < surface.points.size(); ++v) {
      const Vec3& p = surface.points[v];
      if (kept.marked[v])
        continue; // its neighbourhood is marked already
      bool near = false;
      faces.for_each_near({p, p}, deviation, [&](std::size_t i) {
        near = distance_to_triangle(p, made.corner(i, 0), made.corner(i, 1), made.corner(i, 2)) <=
               deviation;
        return !near;
      });
      if (!near) {
        kept.mark(p, .5 * reach * edge(p));
        sound = false;
      }
    }
    if (sound)
      return made;
  }
  return surface;
}

} // namespace tactus::fem
