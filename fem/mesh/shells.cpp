#include "fem/mesh/shells.hpp"

#include "fem/mesh/box_tree.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/distance.hpp"
#include "fem/mesh/edge_uses.hpp"

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace tactus::fem {
namespace {

std::vector<Box> shell_boxes(const Triangles& t) {
  std::vector<std::vector<Vec3>> corners(at(t.shells));
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      corners[at(t.shell[i])].push_back(t.corner(i, k));
  std::vector<Box> boxes;
  boxes.reserve(corners.size());
  for (const auto& c : corners)
    boxes.push_back(bounding_box(c));
  return boxes;
}

/// Solid angle of a triangle seen from the origin (van Oosterom & Strackee 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = length(a), lb = length(b), lc = length(c);
  return 2 * std::atan2(dot(a, cross(b, c)),
                        la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// Whether a point lies inside a shell: its triangles fill the whole sphere around the point.
bool inside(const Vec3& p, const Triangles& t, const std::vector<std::size_t>& shell) {
  double whole = 0;
  for (const std::size_t i : shell)
    whole += solid_angle(t.corner(i, 0) - p, t.corner(i, 1) - p, t.corner(i, 2) - p);
  return std::abs(whole) > 6.2831853; // 4 pi inside, 0 outside
}

bool near(const Triangles& t, std::size_t i, std::size_t j, double distance) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (distance_to_triangle(t.corner(i, k), t.corner(j, 0), t.corner(j, 1), t.corner(j, 2)) <=
            distance ||
        distance_to_triangle(t.corner(j, k), t.corner(i, 0), t.corner(i, 1), t.corner(i, 2)) <=
            distance)
      return true;
    for (std::size_t m = 0; m < 3; ++m)
      if (distance_of_edges(t.corner(i, k), t.corner(i, k + 1), t.corner(j, m),
                            t.corner(j, m + 1)) <= distance)
        return true;
  }
  return false;
}

} // namespace

void find_shells(Triangles& t) {
  std::vector<std::array<int, 3>> across(t.triangles.size(), {-1, -1, -1});
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first > 2)
      throw InputError("the surface crosses itself at " + triangle_location(t, first->triangle) +
                       ": an edge has " + std::to_string(last - first) +
                       " triangles, expected two; --shrink-wrap builds the outer skin");
    if (last - first == 2) {
      across[first[0].triangle][first[0].side] = static_cast<int>(first[1].triangle);
      across[first[1].triangle][first[1].side] = static_cast<int>(first[0].triangle);
    }
  });
  const auto runs = [&](std::size_t i, int a, int b) {
    for (std::size_t k = 0; k < 3; ++k)
      if (t.triangles[i][k] == a && t.triangles[i][(k + 1) % 3] == b)
        return true;
    return false;
  };
  t.shell.assign(t.triangles.size(), -1);
  t.shells = 0;
  std::vector<bool> flipped(t.triangles.size(), false);
  for (std::size_t seed = 0; seed < t.triangles.size(); ++seed) {
    if (t.shell[seed] >= 0)
      continue;
    std::vector<std::size_t> front{seed};
    t.shell[seed] = t.shells;
    while (!front.empty()) {
      const std::size_t i = front.back();
      front.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        if (across[i][k] < 0)
          continue;
        const std::size_t j = at(across[i][k]);
        const bool same = runs(j, t.triangles[i][k], t.triangles[i][(k + 1) % 3]);
        const bool flip = flipped[i] != same; // whether j is reversed relative to the file
        if (t.shell[j] < 0) {
          t.shell[j] = t.shells;
          flipped[j] = flip;
          front.push_back(j);
        } else if (flipped[j] != flip) {
          throw InputError("the surface has only one side at " + triangle_location(t, j) +
                           ": expected the skin of a solid");
        }
      }
    }
    ++t.shells;
  }
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (flipped[i])
      std::swap(t.triangles[i][0], t.triangles[i][1]);
  const std::vector<double> volumes = shell_volumes(t);
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (volumes[at(t.shell[i])] < 0)
      std::swap(t.triangles[i][0], t.triangles[i][1]);
}

std::vector<double> shell_volumes(const Triangles& t) {
  std::vector<double> volumes(at(t.shells), 0);
  std::vector<Vec3> origin(volumes.size());
  std::vector<bool> known(volumes.size(), false);
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const std::size_t s = at(t.shell[i]);
    if (!known[s]) {
      origin[s] = t.corner(i, 0);
      known[s] = true;
    }
    const Vec3 &a = t.corner(i, 0) - origin[s], &b = t.corner(i, 1) - origin[s],
               &c = t.corner(i, 2) - origin[s];
    volumes[s] += dot(a, cross(b, c)) / 6;
  }
  return volumes;
}

std::string open_edge_sentence(const Triangles& t) {
  std::size_t count = 0, example = 0;
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first == 1 && count++ == 0)
      example = first->triangle;
  });
  if (count == 0)
    return {};
  return "the surface is open at " + triangle_location(t, example) +
         ": an edge has one triangle, expected two (" + std::to_string(count) + " such edges)";
}

void close(Triangles& t) {
  find_shells(t);
  if (const std::string sentence = open_edge_sentence(t); !sentence.empty())
    throw InputError(sentence);
}

std::size_t drop_flat_shells(Triangles& t, double thickness) {
  const std::vector<double> volumes = shell_volumes(t);
  std::vector<double> area(volumes.size(), 0);
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    area[at(t.shell[i])] += .5 * length(t.normal(i));
  std::vector<int> name(volumes.size(), -1);
  int kept = 0;
  for (std::size_t s = 0; s < volumes.size(); ++s)
    if (std::abs(volumes[s]) > thickness * area[s])
      name[s] = kept++;
  const auto dropped = static_cast<std::size_t>(t.shells - kept);
  if (dropped == 0 || kept == 0)
    return 0;
  std::size_t to = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (const int s = name[at(t.shell[i])]; s >= 0) {
      t.triangles[to] = t.triangles[i];
      t.shell[to] = s;
      if (!t.group.empty())
        t.group[to] = t.group[i];
      ++to;
    }
  t.triangles.resize(to);
  t.shell.resize(to);
  if (!t.group.empty())
    t.group.resize(to);
  t.shells = kept;
  return dropped;
}

namespace {

/// Pairs of shells closer than a distance, in both orders; stops when there are `enough`.
std::set<std::array<int, 2>> touching_shells(const Triangles& t, double distance,
                                             std::size_t enough) {
  const std::vector<Box> boxes = triangle_boxes(t);
  const BoxTree tree(boxes);
  std::set<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i < boxes.size() && pairs.size() < enough; ++i)
    tree.for_each_near(boxes[i], distance, [&](std::size_t j) {
      const int s = t.shell[i], q = t.shell[j];
      if (j > i && s != q && !pairs.contains({s, q}) && near(t, i, j, distance)) {
        pairs.insert({s, q});
        pairs.insert({q, s});
      }
      return pairs.size() < enough;
    });
  return pairs;
}

/// The outer shell of each shell's body: the shell itself or, for a cavity, the innermost shell
/// around it.
std::vector<int> outer_shells(const std::vector<std::vector<int>>& around) {
  std::vector<int> outer(around.size(), -1);
  for (int s = 0; s < static_cast<int>(around.size()); ++s) {
    outer[at(s)] = s;
    if (around[at(s)].size() % 2 == 1)
      for (const int q : around[at(s)])
        if (around[at(q)].size() + 1 == around[at(s)].size())
          outer[at(s)] = q;
  }
  return outer;
}

} // namespace

std::vector<Triangles> separate_bodies(const Triangles& t) {
  const auto boxes = shell_boxes(t);
  const auto volumes = shell_volumes(t);
  std::vector<Vec3> sample(at(t.shells));
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    sample[at(t.shell[i])] = t.corner(i, 0);
  const auto fits = [&](int s, int q) {
    for (int k = 0; k < 3; ++k)
      if (boxes[at(s)].low[k] < boxes[at(q)].low[k] || boxes[at(s)].high[k] > boxes[at(q)].high[k])
        return false;
    return true;
  };
  std::vector<std::vector<std::size_t>> members(at(t.shells));
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    members[at(t.shell[i])].push_back(i);
  std::vector<std::vector<int>> around(at(t.shells));
  // A shell that touches the shell around it is not a cavity, since the wall would have no
  // thickness.
  std::optional<std::set<std::array<int, 2>>> touching;
  for (int s = 0; s < t.shells; ++s)
    for (int q = 0; q < t.shells; ++q)
      if (q != s && fits(s, q) && inside(sample[at(s)], t, members[at(q)])) {
        if (!touching)
          touching = touching_shells(t, 1e-9 * bounding_box(t.points).largest(),
                                     std::numeric_limits<std::size_t>::max());
        if (!touching->contains({s, q}))
          around[at(s)].push_back(q);
      }
  const std::vector<int> outer = outer_shells(around);
  std::vector<int> cavity_index(at(t.shells), 0), cavities(at(t.shells), 0);
  for (int s = 0; s < t.shells; ++s)
    if (outer[at(s)] != s)
      cavity_index[at(s)] = ++cavities[at(outer[at(s)])];
  std::vector<int> number(at(t.shells), -1);
  std::vector<Triangles> bodies;
  for (int s = 0; s < t.shells; ++s)
    if (outer[at(s)] == s) {
      number[at(s)] = static_cast<int>(bodies.size());
      bodies.emplace_back();
      bodies.back().shells = 1 + cavities[at(s)];
      bodies.back().groups = t.groups;
    }
  std::vector<int> name(t.points.size(), -1);
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const int s = t.shell[i];
    Triangles& body = bodies[at(number[at(outer[at(s)])])];
    auto corners = t.triangles[i];
    for (int& v : corners) { // since shells share no points
      int& known = name[at(v)];
      if (known < 0) {
        known = static_cast<int>(body.points.size());
        body.points.push_back(t.points[at(v)]);
      }
      v = known;
    }
    if ((volumes[at(s)] > 0) != (outer[at(s)] == s))
      std::swap(corners[0], corners[1]);
    body.triangles.push_back(corners);
    body.shell.push_back(cavity_index[at(s)]);
    if (!t.group.empty())
      body.group.push_back(t.group[i]);
  }
  return bodies;
}

bool shells_touch(const Triangles& t, double distance) {
  return t.shells > 1 && !touching_shells(t, distance, 1).empty();
}

} // namespace tactus::fem
