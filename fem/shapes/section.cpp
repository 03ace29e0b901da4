#include "fem/shapes/section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::fem {

void Section::add_mapped(std::span<const double> us, std::span<const double> vs,
                         const std::function<Meridian(double, double)>& map,
                         const std::function<std::array<int, 2>(int, int)>& number) {
  for (std::size_t i = 0; i + 1 < us.size(); ++i)
    for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
      const double u0 = us[i], u1 = us[i + 1], v0 = vs[j], v1 = vs[j + 1];
      const double um = .5 * (u0 + u1), vm = .5 * (v0 + v1);
      quads.push_back({map(u0, v0), map(u1, v0), map(u1, v1), map(u0, v1), map(um, v0), map(u1, vm),
                       map(um, v1), map(u0, vm)});
      interval.push_back(number(static_cast<int>(i), static_cast<int>(j)));
    }
}

namespace {

/// Interval sizes that grow from each concave end until they reach h; the rest is divided evenly.
struct Graded {
  std::vector<double> from_low, from_high;
  double left = 0, even = 0; ///< length and number of the even intervals
};

Graded grade(const Division& line) {
  const auto& [a, b, h, min_divisions, concave, smallest, ratio] = line;
  Graded g;
  g.left = b - a;
  const auto grow = [&](std::vector<double>& steps, double share) {
    double step = line.smallest, used = 0;
    while (step < line.h && used + step < share) {
      steps.push_back(step);
      used += step;
      step *= line.ratio;
    }
    g.left -= used;
  };
  const double share = .6 * (b - a) / (concave.low && concave.high ? 2 : 1);
  if (concave.low)
    grow(g.from_low, share);
  if (concave.high)
    grow(g.from_high, share);
  g.even = std::max<double>(std::ceil(g.left / h - 1e-9),
                            concave.low || concave.high ? 1 : min_divisions);
  return g;
}

} // namespace

double count_divisions(const Division& line) {
  const Graded g = grade(line);
  return g.even + static_cast<double>(g.from_low.size() + g.from_high.size());
}

std::vector<double> divide(const Division& line) {
  const Graded g = grade(line);
  const int even = static_cast<int>(g.even);
  std::vector<double> at{line.a};
  for (const double step : g.from_low)
    at.push_back(at.back() + step);
  const double begin = at.back();
  for (int i = 1; i <= even; ++i)
    at.push_back(begin + g.left * i / even);
  for (std::size_t i = g.from_high.size(); i-- > 0;)
    at.push_back(at.back() + g.from_high[i]);
  at.back() = line.b;
  return at;
}

namespace {

/// The breaks towards which a section is graded, and the division of each interval.
struct Cuts {
  explicit Cuts(const Rectangles& s) : shape(s), concave_r(s.r.size()), concave_z(s.z.size()) {
    for (std::size_t i = 1; i + 1 < s.r.size() && s.grade; ++i)
      for (std::size_t j = 1; j + 1 < s.z.size(); ++j)
        if (solid(i - 1, j - 1) + solid(i, j - 1) + solid(i - 1, j) + solid(i, j) == 3)
          concave_r[i] = concave_z[j] = true;
    for (const std::size_t i : s.singular_r)
      concave_r[i] = s.grade;
    for (const std::size_t j : s.singular_z)
      concave_z[j] = s.grade;
  }
  /// Indices outside the grid are empty.
  [[nodiscard]] bool solid(std::size_t i, std::size_t j) const {
    return i < shape.r.size() - 1 && j < shape.z.size() - 1 && shape.solid[i][j];
  }
  template <class Divide>
  auto along(const std::vector<double>& breaks, const std::vector<bool>& concave, std::size_t i,
             int min_divisions, Divide&& cut) const {
    double smallest = shape.h;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k)
      smallest = std::min(smallest, breaks[k + 1] - breaks[k]);
    return cut(Division{breaks[i],
                        breaks[i + 1],
                        shape.h,
                        min_divisions,
                        {concave[i], concave[i + 1]},
                        smallest / shape.grading,
                        3});
  }
  template <class Divide> auto along_r(std::size_t i, Divide&& cut) const {
    return along(shape.r, concave_r, i, shape.min_divisions_r, cut);
  }
  template <class Divide> auto along_z(std::size_t j, Divide&& cut) const {
    return along(shape.z, concave_z, j, shape.min_divisions_z, cut);
  }

  const Rectangles& shape;
  std::vector<bool> concave_r, concave_z;
};

} // namespace

namespace {

/// The index of the first line from a to b, and the lines in that range.
std::pair<std::size_t, std::vector<double>> lines_within(const std::vector<double>& lines, double a,
                                                         double b) {
  const double near = 1e-9 * (lines.back() - lines.front());
  const auto begin = std::lower_bound(lines.begin(), lines.end(), a - near);
  const auto end = std::upper_bound(lines.begin(), lines.end(), b + near);
  return {static_cast<std::size_t>(begin - lines.begin()), {begin, end}};
}

} // namespace

Section rectangles(const Rectangles& shape, const SweepGrid* given) {
  const Cuts cuts(shape);
  Section section;
  section.grid.kept = {shape.r, shape.z, {}};
  if (given) {
    section.grid.line = given->line;
  } else {
    const auto append = [](std::vector<double>& lines, const std::vector<double>& part) {
      lines.insert(lines.end(), part.begin() + (lines.empty() ? 0 : 1), part.end());
    };
    for (std::size_t i = 0; i + 1 < shape.r.size(); ++i)
      append(section.grid.line[0], cuts.along_r(i, divide));
    for (std::size_t j = 0; j + 1 < shape.z.size(); ++j)
      append(section.grid.line[1], cuts.along_z(j, divide));
  }
  const auto& [r, z, around] = section.grid.line;
  const std::size_t first_z = r.size() - 1;
  for (std::size_t i = 0; i + 1 < shape.r.size(); ++i) {
    const auto [u, us] = lines_within(r, shape.r[i], shape.r[i + 1]);
    for (std::size_t j = 0; j + 1 < shape.z.size(); ++j) {
      if (!cuts.solid(i, j))
        continue;
      const auto [v, vs] = lines_within(z, shape.z[j], shape.z[j + 1]);
      section.add_mapped(
          us, vs,
          [](double x, double y) {
            return Meridian{x, y};
          },
          [first_u = static_cast<int>(u), first_v = static_cast<int>(first_z + v)](int p, int q) {
            return std::array{first_u + p, first_v + q};
          });
    }
  }
  return section;
}

SectionSize size_of(const Rectangles& shape, const SweepGrid* given) {
  const Cuts cuts(shape);
  const std::size_t columns = shape.r.size() - 1, rows = shape.z.size() - 1;
  std::vector<double> across(columns), up(rows);
  const auto given_cells = [&](std::size_t direction, double a, double b) {
    return static_cast<double>(lines_within(given->line[direction], a, b).second.size() - 1);
  };
  for (std::size_t i = 0; i < columns; ++i)
    across[i] =
        given ? given_cells(0, shape.r[i], shape.r[i + 1]) : cuts.along_r(i, count_divisions);
  for (std::size_t j = 0; j < rows; ++j)
    up[j] = given ? given_cells(1, shape.z[j], shape.z[j + 1]) : cuts.along_z(j, count_divisions);
  // Blocks are the interiors of quads, and breaks are the lines between blocks. Index -1 wraps
  // around and is empty.
  SectionSize size;
  const bool axis = shape.r[0] == 0;
  for (std::size_t i = 0; i <= columns; ++i)
    for (std::size_t j = 0; j <= rows; ++j) {
      const int here = cuts.solid(i, j), left = cuts.solid(i - 1, j), below = cuts.solid(i, j - 1);
      const int corner = cuts.solid(i - 1, j - 1);
      const double n = i < columns ? across[i] : 0, m = j < rows ? up[j] : 0;
      if (here) {
        size.quads += n * m;
        size.corners += (n - 1) * (m - 1);
        size.sides += (n - 1) * m + n * (m - 1);
      }
      if (here || left) { // the vertical line at break i
        size.corners += m - 1;
        size.sides += m;
        if (axis && i == 0) {
          size.axis_quads += m;
          size.axis_corners += m - 1;
          size.axis_sides += m;
        } else if (here != left) {
          size.outer_sides += m;
        }
      }
      if (here || below) {
        size.corners += n - 1;
        size.sides += n;
        size.outer_sides += here != below ? n : 0;
      }
      if (here || left || below || corner) {
        size.corners += 1;
        size.axis_corners += axis && i == 0;
      }
    }
  return size;
}

Section shell(const Shell& s, const SweepGrid* given) {
  const auto point = [&](double u, double v) {
    constexpr double kStep = 1e-6;
    const Meridian p = s.middle(u);
    const Meridian a = s.middle(std::max(u - kStep, 0.0)), b = s.middle(std::min(u + kStep, 1.0));
    const double dr = b.r - a.r, dz = b.z - a.z, size = std::hypot(dr, dz);
    const double across = (v - .5) * s.thickness(u);
    const bool on_axis = std::abs(p.r) < 1e-9 * size / kStep;
    // The normal to the left of the curve; on the axis the normal is the axis itself.
    return on_axis ? Meridian{0, p.z + std::copysign(across, across * dr)}
                   : Meridian{p.r - across * dz / size, p.z + across * dr / size};
  };
  Section section;
  section.grid.kept = {{{0, 1}, {0, 1}, {}}};
  section.grid.line =
      given ? given->line
            : std::array<std::vector<double>, 3>{divide({0, 1, 1.0 / s.along, s.along}),
                                                 divide({0, 1, 1.0 / s.layers, s.layers}),
                                                 {}};
  const auto first_v = static_cast<int>(section.grid.line[0].size()) - 1;
  section.add_mapped(section.grid.line[0], section.grid.line[1], point, [&](int i, int j) {
    return std::array{i, first_v + j};
  });
  return section;
}

SectionSize size_of_shell(double n, double m, Ends on_axis) {
  SectionSize size{.quads = n * m,
                   .corners = (n + 1) * (m + 1),
                   .sides = n * (m + 1) + (n + 1) * m,
                   .outer_sides = 2 * n + 2 * m};
  for (const bool end : {on_axis.low, on_axis.high})
    if (end) {
      size.axis_quads += m;
      size.axis_corners += m + 1;
      size.axis_sides += m;
      size.outer_sides -= m;
    }
  return size;
}

Mesh revolve(const Section& section, int sectors) {
  Mesh mesh;
  double size = 0;
  for (const auto& quad : section.quads)
    for (const Meridian& p : quad)
      size = std::max({size, std::abs(p.r), std::abs(p.z)});
  const auto put = [&](const Meridian& p, int half_step) {
    const double angle = std::numbers::pi * (half_step % (2 * sectors)) / sectors;
    mesh.nodes.push_back({p.r * std::cos(angle), p.r * std::sin(angle), p.z});
    return static_cast<int>(mesh.nodes.size()) - 1;
  };
  const auto on_axis = [&](const Meridian& p) { return std::abs(p.r) < 1e-9 * size; };
  const auto around = static_cast<int>(section.grid.first_interval(2));
  for (std::size_t index = 0; index < section.quads.size(); ++index) {
    auto quad = section.quads[index];
    auto [along_first, along_second] = section.interval[index];
    int touching = 0;
    for (std::size_t c = 0; c < 4; ++c)
      touching += on_axis(quad[c]);
    if (touching == 1 || touching > 2)
      throw InputError("the section touches the axis only at a corner, expected along a side");
    if (touching == 2)
      while (!(on_axis(quad[3]) && on_axis(quad[0]))) {
        std::rotate(quad.begin(), quad.begin() + 1, quad.begin() + 4);
        std::rotate(quad.begin() + 4, quad.begin() + 5, quad.end());
        std::swap(along_first, along_second);
      }
    for (int k = 0; k < sectors; ++k) {
      const int a = 2 * k, m = a + 1, b = a + 2;
      const auto& q = quad;
      if (touching == 2) {
        const std::array<int, 15> nodes{put(q[0], a), put(q[1], a), put(q[1], b), put(q[3], a),
                                        put(q[2], a), put(q[2], b), put(q[4], a), put(q[1], m),
                                        put(q[4], b), put(q[6], a), put(q[2], m), put(q[6], b),
                                        put(q[7], a), put(q[5], a), put(q[5], b)};
        mesh.add(Shape::wedge15, nodes);
        mesh.elements.back().interval = {along_first, around, along_second};
      } else { // (r, z, angle) is left-handed, so the corners run backwards
        const std::array<int, 20> nodes{put(q[0], a), put(q[3], a), put(q[2], a), put(q[1], a),
                                        put(q[0], b), put(q[3], b), put(q[2], b), put(q[1], b),
                                        put(q[7], a), put(q[6], a), put(q[5], a), put(q[4], a),
                                        put(q[7], b), put(q[6], b), put(q[5], b), put(q[4], b),
                                        put(q[0], m), put(q[3], m), put(q[2], m), put(q[1], m)};
        mesh.add(Shape::hex20, nodes);
        mesh.elements.back().interval = {along_second, along_first, around};
      }
    }
  }
  merge_nodes(mesh, 1e-8 * size);
  return mesh;
}

} // namespace tactus::fem
