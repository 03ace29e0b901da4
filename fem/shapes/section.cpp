#include "fem/shapes/section.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {

void Section::add_mapped(std::span<const double> us, std::span<const double> vs,
                         const std::function<Meridian(double, double)>& map) {
  for (std::size_t i = 0; i + 1 < us.size(); ++i)
    for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
      const double u0 = us[i], u1 = us[i + 1], v0 = vs[j], v1 = vs[j + 1];
      const double um = .5 * (u0 + u1), vm = .5 * (v0 + v1);
      quads.push_back({map(u0, v0), map(u1, v0), map(u1, v1), map(u0, v1), map(um, v0), map(u1, vm),
                       map(um, v1), map(u0, vm)});
    }
}

std::vector<double> divide(double a, double b, double h, int at_least, Ends concave,
                           double smallest, double ratio) {
  // Sizes from each concave end grow until they reach h; what remains is divided evenly.
  std::vector<double> from_low, from_high;
  double left = b - a;
  const auto grow = [&](std::vector<double>& steps, double share) {
    double step = smallest, used = 0;
    while (step < h && used + step < share) {
      steps.push_back(step);
      used += step;
      step *= ratio;
    }
    left -= used;
  };
  const double share = .6 * (b - a) / (concave.low && concave.high ? 2 : 1);
  if (concave.low)
    grow(from_low, share);
  if (concave.high)
    grow(from_high, share);
  const int even = std::max(static_cast<int>(std::ceil(left / h - 1e-9)),
                            concave.low || concave.high ? 1 : at_least);
  std::vector<double> at{a};
  for (const double step : from_low)
    at.push_back(at.back() + step);
  const double begin = at.back();
  for (int i = 1; i <= even; ++i)
    at.push_back(begin + left * i / even);
  for (std::size_t i = from_high.size(); i-- > 0;)
    at.push_back(at.back() + from_high[i]);
  at.back() = b;
  return at;
}

Section rectangles(const Rectangles& shape) {
  const std::size_t columns = shape.r.size() - 1, rows = shape.z.size() - 1;
  std::vector<bool> concave_r(shape.r.size()), concave_z(shape.z.size());
  const auto solid = [&](std::size_t i, std::size_t j) {
    return static_cast<bool>(shape.solid[i][j]);
  };
  for (std::size_t i = 1; i < columns && shape.grade; ++i)
    for (std::size_t j = 1; j < rows; ++j)
      if (solid(i - 1, j - 1) + solid(i, j - 1) + solid(i - 1, j) + solid(i, j) == 3)
        concave_r[i] = concave_z[j] = true;
  for (const std::size_t i : shape.singular_r)
    concave_r[i] = shape.grade;
  for (const std::size_t j : shape.singular_z)
    concave_z[j] = shape.grade;
  const auto cuts = [&](const std::vector<double>& breaks, const std::vector<bool>& concave,
                        std::size_t i, int at_least) {
    double smallest = shape.h;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k)
      smallest = std::min(smallest, breaks[k + 1] - breaks[k]);
    return divide(breaks[i], breaks[i + 1], shape.h, at_least, {concave[i], concave[i + 1]},
                  smallest / 27, 3);
  };
  Section section;
  for (std::size_t i = 0; i < columns; ++i) {
    const auto us = cuts(shape.r, concave_r, i, 2);
    for (std::size_t j = 0; j < rows; ++j)
      if (solid(i, j))
        section.add_mapped(us, cuts(shape.z, concave_z, j, shape.least_z), [](double u, double v) {
          return Meridian{u, v};
        });
  }
  return section;
}

Section shell(const Shell& s) {
  const auto point = [&](double u, double v) {
    constexpr double kStep = 1e-6;
    const Meridian p = s.middle(u);
    const Meridian a = s.middle(std::max(u - kStep, 0.0)), b = s.middle(std::min(u + kStep, 1.0));
    const double dr = b.r - a.r, dz = b.z - a.z, size = std::hypot(dr, dz);
    const double across = (v - .5) * s.thickness(u);
    const bool on_axis = std::abs(p.r) < 1e-9 * size / kStep;
    // The normal to the left of the curve; on the axis it is the axis itself.
    return on_axis ? Meridian{0, p.z + std::copysign(across, across * dr)}
                   : Meridian{p.r - across * dz / size, p.z + across * dr / size};
  };
  Section section;
  section.add_mapped(divide(0, 1, 1.0 / s.along, s.along), divide(0, 1, 1.0 / s.layers, s.layers),
                     point);
  return section;
}

Section ball(double radius, double h) {
  const double core = .55 * radius;
  const int cells = std::max(2, static_cast<int>(std::ceil(core / h)));
  const int around = std::max(2, static_cast<int>(std::ceil((radius - core) / h)));
  const auto us = divide(0, 1, 1.0 / cells, cells), vs = divide(-1, 1, 1.0 / cells, 2 * cells);
  const auto ws = divide(0, 1, 1.0 / around, around);
  // The core bulges a little, so that its corners and sides meet the outer blocks at mild angles.
  const auto inner = [&](double u, double v) {
    const double bulge = 1 - .18 * u * u * v * v;
    return Meridian{core * u * bulge, core * v * bulge};
  };
  const auto blend = [](const Meridian& a, const Meridian& b, double w) {
    return Meridian{(1 - w) * a.r + w * b.r, (1 - w) * a.z + w * b.z};
  };
  const auto on_sphere = [&](double angle) { // from the top
    return Meridian{radius * std::sin(angle), radius * std::cos(angle)};
  };
  constexpr double kQuarter = std::numbers::pi / 4;
  Section section;
  section.add_mapped(us, vs, inner);
  section.add_mapped(ws, vs, [&](double w, double v) {
    return blend(inner(1, v), on_sphere(kQuarter * (2 - v)), w);
  });
  section.add_mapped(us, ws, [&](double u, double w) {
    Meridian p = blend(inner(u, 1), on_sphere(kQuarter * u), w);
    return u == 0 ? Meridian{0, p.z} : p;
  });
  section.add_mapped(us, ws, [&](double u, double w) {
    Meridian p = blend(inner(u, -1), on_sphere(kQuarter * (4 - u)), 1 - w);
    return u == 0 ? Meridian{0, p.z} : p;
  });
  return section;
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
  for (auto quad : section.quads) {
    int touching = 0;
    for (std::size_t c = 0; c < 4; ++c)
      touching += on_axis(quad[c]);
    if (touching == 1 || touching > 2)
      throw Refusal("the section touches the axis with a corner alone, expected with a side");
    if (touching == 2)
      while (!(on_axis(quad[3]) && on_axis(quad[0]))) {
        std::rotate(quad.begin(), quad.begin() + 1, quad.begin() + 4);
        std::rotate(quad.begin() + 4, quad.begin() + 5, quad.end());
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
      } else { // (r, z, angle) is left-handed: the corners run backwards
        const std::array<int, 20> nodes{put(q[0], a), put(q[3], a), put(q[2], a), put(q[1], a),
                                        put(q[0], b), put(q[3], b), put(q[2], b), put(q[1], b),
                                        put(q[7], a), put(q[6], a), put(q[5], a), put(q[4], a),
                                        put(q[7], b), put(q[6], b), put(q[5], b), put(q[4], b),
                                        put(q[0], m), put(q[3], m), put(q[2], m), put(q[1], m)};
        mesh.add(Shape::hex20, nodes);
      }
    }
  }
  merge_nodes(mesh, 1e-8 * size);
  return mesh;
}

} // namespace tactus::fem
