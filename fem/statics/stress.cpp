#include "fem/statics/stress.hpp"

#include "fem/small_dense.hpp"
#include "fem/statics/gradient.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactus::fem {
namespace {

Eigenpairs3 principal_pairs(const Stress& s) noexcept {
  return symmetric_eigenpairs({{{s[0], s[5], s[4]}, {s[5], s[1], s[3]}, {s[4], s[3], s[2]}}});
}

/// The superconvergent points of an element's stress (Barlow 1976), and the extrapolation of values
/// from these points to its nodes, by the polynomial with as many terms as there are points.
struct Smoothing {
  Tabulated points;
  std::vector<double> to_nodes; ///< [node][point]

  Smoothing(Shape shape, std::vector<QuadraturePoint> at) : points(shape, at) {
    // to_nodes follows from the condition that the terms' values at the points, multiplied by it,
    // equal the terms' values at the nodes.
    const auto terms = [](const Vec3& p) {
      return std::array{1., p.x, p.y, p.z, p.z * p.x, p.z * p.y, p.x * p.y, p.x * p.y * p.z};
    };
    const std::size_t count = at.size();
    std::vector<double> here;
    for (const QuadraturePoint& point : at) {
      const auto values = terms(point.at);
      here.insert(here.end(), values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
    }
    for (const Vec3& node : reference_nodes(shape)) {
      const auto values = terms(node);
      to_nodes.insert(to_nodes.end(), values.begin(),
                      values.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (!solve_regular(here, to_nodes, count))
      throw std::logic_error("the stress points of an element do not determine its polynomial");
  }
};

std::vector<QuadraturePoint> best_points(Shape shape) {
  const double g = 1 / std::sqrt(3.0);
  std::vector<QuadraturePoint> points;
  switch (shape) {
  case Shape::tet4:
  case Shape::hex8:
  case Shape::wedge6:
  case Shape::pyramid5:
    return {{centroid_of(shape), 1}};
  case Shape::tet10: {
    const auto four = stiffness_points(shape);
    return {four.begin(), four.end()};
  }
  case Shape::hex20:
    for (const double x : {-g, g})
      for (const double y : {-g, g})
        for (const double z : {-g, g})
          points.push_back({{x, y, z}, 1});
    return points;
  case Shape::wedge15:
    for (const double z : {-g, g})
      for (const auto& [x, y] : {std::array{1. / 6, 1. / 6}, {2. / 3, 1. / 6}, {1. / 6, 2. / 3}})
        points.push_back({{x, y, z}, 1});
    return points;
  }
  return points;
}

const Smoothing& smoothing(Shape shape) {
  static const auto all = for_shapes([](Shape s) { return Smoothing(s, best_points(s)); });
  return all[static_cast<std::size_t>(shape)];
}

Stress stress_with(const Mesh& mesh, const Element& e, const ElasticLaw& law,
                   const ElementField& own, const ShapeValues& values) {
  PointGradients at;
  gradients(mesh, e, values, at);
  return stress_of(law, field_gradient(at, own, static_cast<std::size_t>(node_count(e.shape))));
}

} // namespace

double von_mises(const Stress& s) noexcept {
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  return std::sqrt(.5 * (xy * xy + yz * yz + zx * zx) +
                   3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

std::array<double, 3> principal(const Stress& s) {
  const auto v = principal_pairs(s).values;
  return {v[2], v[1], v[0]};
}

double max_shear(const Stress& s) {
  const auto p = principal(s);
  return .5 * (p[0] - p[2]);
}

Stress von_mises_slope(const Stress& s) noexcept {
  const double value = von_mises(s);
  if (!(value > 0))
    return {};
  const double mean = (s[0] + s[1] + s[2]) / 3;
  // d vM / d s_xy of the symmetric pair, in which both halves change together.
  return {1.5 * (s[0] - mean) / value,
          1.5 * (s[1] - mean) / value,
          1.5 * (s[2] - mean) / value,
          3 * s[3] / value,
          3 * s[4] / value,
          3 * s[5] / value};
}

Stress max_shear_slope(const Stress& s) {
  const Eigenpairs3 pairs = principal_pairs(s);
  const Vec3 n = pairs.vectors[2], m = pairs.vectors[0];
  const auto pair = [&](int i, int j) { return n[i] * n[j] - m[i] * m[j]; };
  return {.5 * pair(0, 0), .5 * pair(1, 1), .5 * pair(2, 2), pair(1, 2), pair(0, 2), pair(0, 1)};
}

Vec3 centroid_of(Shape shape) noexcept {
  Vec3 sum;
  const int corners = corner_count(shape);
  for (int c = 0; c < corners; ++c)
    sum += reference_nodes(shape)[static_cast<std::size_t>(c)];
  return (1.0 / corners) * sum;
}

const ShapeValues& at_centroid(Shape shape) {
  static const auto all = for_shapes([](Shape s) {
    ShapeValues values;
    evaluate(s, centroid_of(s), values);
    return values;
  });
  return all[static_cast<std::size_t>(shape)];
}

Stress stress_at(const Mesh& mesh, const Element& e, const ElasticLaw& law,
                 std::span<const double> displacement, const Vec3& reference) {
  ShapeValues values;
  evaluate(e.shape, reference, values);
  return stress_with(mesh, e, law, gather(displacement, mesh.nodes_of(e)), values);
}

std::vector<Stress> element_stress(const Mesh& mesh, std::span<const Material> materials,
                                   std::span<const double> displacement) {
  const auto laws = elastic_laws(mesh, materials);
  std::vector<Stress> stress;
  stress.reserve(mesh.elements.size());
  for (const Element& e : mesh.elements)
    stress.push_back(stress_with(mesh, e, laws[static_cast<std::size_t>(e.region)],
                                 gather(displacement, mesh.nodes_of(e)), at_centroid(e.shape)));
  return stress;
}

std::vector<std::vector<StressSample>> best_stress(const Mesh& mesh,
                                                   std::span<const Material> materials,
                                                   std::span<const double> displacement) {
  const auto laws = elastic_laws(mesh, materials);
  std::vector<std::vector<StressSample>> samples;
  samples.reserve(mesh.elements.size());
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    const ElementField own = gather(displacement, nodes);
    auto& points = samples.emplace_back();
    for (const ShapeValues& values : smoothing(e.shape).points.values) {
      Vec3 at;
      for (std::size_t a = 0; a < nodes.size(); ++a)
        at += values.value[a] * mesh.nodes[static_cast<std::size_t>(nodes[a])];
      points.push_back(
          {at, stress_with(mesh, e, laws[static_cast<std::size_t>(e.region)], own, values)});
    }
  }
  return samples;
}

std::span<const double> shares_of_best_points(Shape shape, std::size_t node) {
  const Smoothing& smooth = smoothing(shape);
  const std::size_t points = smooth.points.values.size();
  return std::span(smooth.to_nodes).subspan(node * points, points);
}

std::vector<double> element_volumes(const Mesh& mesh) {
  std::vector<double> volumes;
  for (const Element& e : mesh.elements)
    volumes.push_back(volume_of(mesh, e));
  return volumes;
}

} // namespace tactus::fem
