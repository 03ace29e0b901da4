#include "fem/mesh/manifold.hpp"

#include "fem/mesh/edge_uses.hpp"

#include <numbers>
#include <numeric>

namespace tactus::fem {
namespace {

constexpr double kSameAngle = 1e-6;

/// A use of an edge, with the angle of its triangle about the edge.
using AngledUse = std::pair<double, EdgeUse>;

/// Joins the triangles at an edge in pairs. Turning about the edge, a triangle that runs from b to
/// a begins a body and one that runs from a to b ends it, so they pair like brackets if the turn
/// starts outside all bodies. Among triangles at the same angle, those that begin a body come
/// first, so that the wall between two solids pairs with itself and becomes a separate flat piece.
template <class Join> void join_bodies(std::vector<AngledUse>& order, Join&& join) {
  std::stable_sort(order.begin(), order.end(),
                   [](const AngledUse& u, const AngledUse& v) { return u.first < v.first; });
  for (auto begin = order.begin(); begin != order.end();) {
    const auto end = std::find_if(begin, order.end(), [&](const AngledUse& u) {
      return u.first > begin->first + kSameAngle;
    });
    std::stable_partition(begin, end, [](const AngledUse& u) { return !u.second.forward; });
    begin = end;
  }
  const std::size_t count = order.size();
  std::ptrdiff_t depth = 0, lowest = 0;
  std::size_t start = 0;
  for (std::size_t i = 0; i < count; ++i) {
    depth += order[i].second.forward ? -1 : 1;
    if (depth < lowest) {
      lowest = depth;
      start = i + 1;
    }
  }
  if (depth != 0) { // the file's triangles disagree about the outside
    const std::size_t shift = order[0].second.forward ? 1 : 0;
    for (std::size_t i = 0; i < count; i += 2)
      join(order[(i + shift) % count].second, order[(i + shift + 1) % count].second);
    return;
  }
  std::vector<EdgeUse> begun;
  for (std::size_t i = 0; i < count; ++i) {
    const EdgeUse& use = order[(start + i) % count].second;
    if (use.forward) {
      join(begun.back(), use);
      begun.pop_back();
    } else {
      begun.push_back(use);
    }
  }
}

/// For each side of each triangle, the neighbour across that side, or -1 where the surface is open.
std::vector<std::array<int, 3>> neighbours(const Triangles& t) {
  std::vector<std::array<int, 3>> across(t.triangles.size(), {-1, -1, -1});
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    const auto join = [&](const EdgeUse& u, const EdgeUse& v) {
      across[u.triangle][u.side] = static_cast<int>(v.triangle);
      across[v.triangle][v.side] = static_cast<int>(u.triangle);
    };
    const auto count = last - first;
    if (count == 2)
      join(first[0], first[1]);
    if (count <= 2)
      return;
    if (count % 2 == 1)
      throw InputError("the outer surface cannot be separated from an inner wall at " +
                       triangle_location(t, first->triangle) + ": an edge has " +
                       std::to_string(count) +
                       " triangles, expected two; --shrink-wrap builds the outer skin");
    const Vec3 a = t.points[at(first->a)], along = t.points[at(first->b)] - a;
    const Vec3 axis = (1 / length(along)) * along;
    Vec3 x, y;
    std::vector<AngledUse> order;
    for (auto u = first; u != last; ++u) {
      const Vec3 tip = t.corner(u->triangle, u->side + 2) - a;
      const Vec3 out = tip - dot(tip, axis) * axis;
      if (u == first) {
        x = (1 / std::max(length(out), 1e-300)) * out;
        y = cross(axis, x);
      }
      order.emplace_back(u == first ? 0 : std::atan2(dot(out, y), dot(out, x)), *u);
      if (order.back().first < -kSameAngle)
        order.back().first += 2 * std::numbers::pi;
    }
    join_bodies(order, join);
  });
  return across;
}

/// Gives each fan of triangles around a point a separate copy of the point.
void split_fans(Triangles& t, const std::vector<std::array<int, 3>>& across) {
  std::vector<std::size_t> fan(3 * t.triangles.size());
  std::iota(fan.begin(), fan.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (fan[i] != i)
      i = fan[i] = fan[fan[i]];
    return i;
  };
  const auto corner_of = [&](std::size_t triangle, int point) {
    for (std::size_t k = 0; k < 3; ++k)
      if (t.triangles[triangle][k] == point)
        return 3 * triangle + k;
    return 3 * triangle;
  };
  for (std::size_t i = 0; i < across.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (across[i][k] >= 0)
        for (const int point : {t.triangles[i][k], t.triangles[i][(k + 1) % 3]})
          fan[root(corner_of(i, point))] = root(corner_of(at(across[i][k]), point));
  std::vector<int> name(fan.size(), -1);
  std::vector<Vec3> points;
  auto triangles = t.triangles;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      int& known = name[root(3 * i + k)];
      if (known < 0) {
        known = static_cast<int>(points.size());
        points.push_back(t.corner(i, k));
      }
      triangles[i][k] = known;
    }
  t.points = std::move(points);
  t.triangles = std::move(triangles);
}

/// If two pairs of neighbours still share both points of an edge, all pairs except the first get a
/// separate point in the edge's middle. Returns the number of added points.
std::size_t split_shared_edges(Triangles& t, const std::vector<std::array<int, 3>>& across) {
  std::size_t done = 0;
  std::vector<bool> affected(t.triangles.size(), false);
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first <= 2)
      return;
    const std::size_t kept = at(across[first->triangle][first->side]);
    for (auto u = first + 1; u != last; ++u) {
      const std::size_t i = u->triangle, j = at(across[i][u->side]);
      if (i == kept || i > j || affected[i] || affected[j])
        continue;
      const int middle = static_cast<int>(t.points.size());
      t.points.push_back(.5 * (t.points[at(u->a)] + t.points[at(u->b)]));
      for (const std::size_t half : {i, j}) {
        affected[half] = true;
        auto& c = t.triangles[half];
        const auto tip =
            std::find_if(c.begin(), c.end(), [&](int v) { return v != u->a && v != u->b; });
        std::rotate(c.begin(), tip, c.end());
        t.triangles.push_back({c[0], middle, c[2]});
        t.triangles[half][2] = middle;
        if (!t.group.empty())
          t.group.push_back(t.group[half]);
      }
      ++done;
    }
  });
  return done;
}

} // namespace

void make_manifold(Triangles& t) {
  split_fans(t, neighbours(t));
  for (int pass = 0; pass < 10; ++pass)
    if (split_shared_edges(t, neighbours(t)) == 0)
      break;
}

} // namespace tactus::fem
