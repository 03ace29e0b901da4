#include "fem/mesh/weld.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/edge_uses.hpp"
#include "fem/mesh/manifold.hpp"

#include <limits>
#include <map>
#include <numeric>

namespace tactus::fem {
namespace {

/// Keeps the triangles for which keep(i) holds, with their groups.
template <class Keep> std::size_t keep_triangles(Triangles& t, Keep&& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (keep(i)) {
      t.triangles[kept] = t.triangles[i];
      if (!t.group.empty())
        t.group[kept] = t.group[i];
      ++kept;
    }
  const std::size_t gone = t.triangles.size() - kept;
  t.triangles.resize(kept);
  if (!t.group.empty())
    t.group.resize(kept);
  return gone;
}

void drop_degenerate(Triangles& t) {
  keep_triangles(t, [&](std::size_t i) {
    const auto& c = t.triangles[i];
    return c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
  });
}

std::vector<std::array<int, 2>> open_edges(const Triangles& t) {
  std::vector<std::array<int, 2>> open;
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    if ((last - first) % 2 == 1)
      open.push_back({first->a, first->b});
  });
  return open;
}

std::vector<int> corners_of(const std::vector<std::array<int, 2>>& edges) {
  std::vector<int> corners;
  for (const auto& edge : edges)
    corners.insert(corners.end(), edge.begin(), edge.end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

/// Joins corners of open edges within a distance, if that closes edges.
bool join_open_edges(Triangles& t, double tolerance) {
  const auto open = open_edges(t);
  if (open.empty())
    return false;
  const std::vector<int> corners = corners_of(open);
  std::vector<Vec3> points;
  points.reserve(corners.size());
  for (const int c : corners)
    points.push_back(t.points[at(c)]);
  const std::vector<int> to = coincident_points(points, tolerance);
  std::vector<int> name(t.points.size());
  std::iota(name.begin(), name.end(), 0);
  for (std::size_t i = 0; i < corners.size(); ++i)
    name[at(corners[i])] = corners[at(to[i])];
  for (const auto& [a, b] : open) // a short edge is a detail, not a gap
    if (name[at(a)] == name[at(b)])
      name[at(a)] = a, name[at(b)] = b;
  Triangles joined_corners = t;
  for (auto& c : joined_corners.triangles)
    for (int& v : c)
      v = name[at(v)];
  drop_degenerate(joined_corners);
  if (joined_corners.triangles.size() != t.triangles.size() ||
      open_edges(joined_corners).size() >= open.size())
    return false;
  t = std::move(joined_corners);
  return true;
}

/// Splits triangles that have a corner of an open edge on their own open edge. Returns their
/// number.
std::size_t split_at_junctions(Triangles& t, double tolerance) {
  const auto open = open_edges(t);
  std::vector<int> corners = corners_of(open);
  std::sort(corners.begin(), corners.end(),
            [&](int a, int b) { return t.points[at(a)].x < t.points[at(b)].x; });
  std::map<std::array<int, 2>, std::vector<std::pair<double, int>>> cuts;
  for (const auto& [a, b] : open) {
    const Vec3 p = t.points[at(a)], along = t.points[at(b)] - p;
    const double low = std::min(p.x, p.x + along.x) - tolerance, square = dot(along, along);
    auto c = std::lower_bound(corners.begin(), corners.end(), low,
                              [&](int v, double x) { return t.points[at(v)].x < x; });
    for (; c != corners.end() && t.points[at(*c)].x <= std::max(p.x, p.x + along.x) + tolerance;
         ++c) {
      const Vec3 offset = t.points[at(*c)] - p;
      const double share = dot(offset, along) / square;
      if (*c != a && *c != b && share > 0 && share < 1 &&
          length(offset - share * along) <= tolerance &&
          std::min(share, 1 - share) * std::sqrt(square) > tolerance)
        cuts[{a, b}].emplace_back(share, *c);
    }
  }
  std::size_t done = 0;
  const std::size_t count = t.triangles.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t.triangles[i][k], b = t.triangles[i][(k + 1) % 3];
      const int tip = t.triangles[i][(k + 2) % 3];
      const auto found = cuts.find({std::min(a, b), std::max(a, b)});
      if (found == cuts.end())
        continue;
      auto on_edge = found->second;
      std::erase_if(on_edge, [&](const auto& c) { return c.second == tip; });
      if (on_edge.empty())
        continue;
      std::sort(on_edge.begin(), on_edge.end());
      if (a > b)
        std::reverse(on_edge.begin(), on_edge.end());
      int from = a;
      t.triangles[i] = {from, on_edge[0].second, tip};
      for (std::size_t c = 0; c < on_edge.size(); ++c) {
        from = on_edge[c].second;
        t.triangles.push_back({from, c + 1 < on_edge.size() ? on_edge[c + 1].second : b, tip});
        if (!t.group.empty())
          t.group.push_back(t.group[i]);
      }
      ++done;
      break; // the next pass handles its other edges
    }
  return done;
}

/// Whether the triangles have opposite orientations.
bool is_wall(const Triangles& t, std::span<const std::size_t> copies) {
  return std::any_of(copies.begin(), copies.end(),
                     [&](std::size_t i) { return dot(t.normal(i), t.normal(copies[0])) < 0; });
}

/// Keeps one of the triangles with the same corners. But if the edges have an even number of
/// triangles without the copies, there are two cases. Copies with opposite orientations are a wall
/// between touching solids and are removed. Otherwise they are a face that a solid shares with a
/// solid around it, and all are kept.
std::size_t drop_duplicates(Triangles& t) {
  std::map<std::array<int, 3>, std::vector<std::size_t>> same;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    auto key = t.triangles[i];
    std::sort(key.begin(), key.end());
    same[key].push_back(i);
  }
  if (same.size() == t.triangles.size())
    return 0;
  std::vector<bool> keep(t.triangles.size(), true), twice(t.triangles.size(), false);
  for (const auto& [key, copies] : same)
    for (std::size_t c = 0; c < copies.size(); ++c) {
      keep[copies[c]] = c == 0;
      twice[copies[c]] = copies.size() > 1;
    }
  // Connected patches of duplicates are kept or dropped as a whole.
  std::vector<std::size_t> patch(t.triangles.size());
  std::iota(patch.begin(), patch.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (patch[i] != i)
      i = patch[i] = patch[patch[i]];
    return i;
  };
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    for (auto u = first; u != last; ++u)
      for (auto v = u + 1; v != last; ++v)
        if (twice[u->triangle] && twice[v->triangle])
          patch[root(u->triangle)] = root(v->triangle);
  });
  std::map<std::size_t, int> odd; // odd minus even edges of a patch, if one copy stays
  for_each_edge(uses, [&](auto first, auto last) {
    int stay = 0, once = 0;
    std::size_t of = 0;
    for (auto u = first; u != last; ++u) {
      stay += keep[u->triangle];
      if (twice[u->triangle] && keep[u->triangle]) {
        of = root(u->triangle);
        ++once;
      }
    }
    if (once == 1) // the patch ends here
      odd[of] += stay % 2 == 1 ? 1 : -1;
  });
  for (const auto& [key, copies] : same)
    if (const auto found = odd.find(root(copies[0]));
        twice[copies[0]] && found != odd.end() && found->second > 0) {
      const bool wall = is_wall(t, copies);
      for (const std::size_t i : copies)
        keep[i] = !wall;
    }
  return keep_triangles(t, [&](std::size_t i) { return keep[i]; });
}

/// Removes triangles with a free edge next to an edge with three or more triangles: such triangles
/// bound no volume.
std::size_t drop_fins(Triangles& t) {
  std::size_t dropped = 0;
  for (bool again = true; again;) {
    std::vector<int> free(t.triangles.size(), 0), overfull_edges(t.triangles.size(), 0);
    const auto uses = edge_uses(t);
    for_each_edge(uses, [&](auto first, auto last) {
      for (auto u = first; u != last; ++u) {
        free[u->triangle] += last - first == 1;
        overfull_edges[u->triangle] += last - first > 2;
      }
    });
    const std::size_t gone =
        keep_triangles(t, [&](std::size_t i) { return free[i] == 0 || overfull_edges[i] == 0; });
    dropped += gone;
    again = gone > 0;
  }
  return dropped;
}

} // namespace

Welded weld(Triangles& t) {
  Welded done;
  double far = 0;
  for (const Vec3& p : t.points)
    far = std::max({far, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  const double size = bounding_box(t.points).largest();
  if (!(size > 0))
    throw InputError("the surface has no extent");
  const std::size_t count = t.triangles.size();
  const Vec3 first = t.points[0];
  done.tolerance = std::min(4 * far * double{std::numeric_limits<float>::epsilon()}, 1e-3 * size);
  const std::vector<int> to = coincident_points(t.points, done.tolerance);
  for (auto& c : t.triangles)
    for (int& v : c)
      v = to[at(v)];
  drop_degenerate(t);
  for (const double share : {1e-6, 1e-5, 1e-4}) {
    const double tolerance = share * size;
    if (tolerance < done.tolerance)
      continue;
    if (join_open_edges(t, tolerance))
      done.tolerance = tolerance;
    for (int pass = 0; pass < 8; ++pass) {
      const std::size_t split = split_at_junctions(t, tolerance);
      done.split += split;
      if (split == 0)
        break;
    }
  }
  done.duplicates = drop_duplicates(t);
  done.fins = drop_fins(t);
  if (t.triangles.empty())
    throw InputError(
        format("the surface encloses no volume: each of its %zu triangles has a partner "
               "or a free edge, the first",
               count) +
        near_position(first) + ": give a sheet a thickness, or use --shrink-wrap SIZE");
  make_manifold(t);
  return done;
}

} // namespace tactus::fem
