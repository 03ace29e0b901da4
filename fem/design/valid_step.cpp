#include "fem/design/valid_step.hpp"

#include "fem/element/tabulated.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace tactus::fem {
namespace {

/// Determinant over the product of edge lengths, for the straight element with this constant
/// Jacobian.
double scaled(Shape shape, const Jacobian& j) {
  const Vec3 &a = j.row[0], &b = j.row[1], &c = j.row[2];
  const double ab = length(b - a), ac = length(c - a), bc = length(c - b);
  const double la = length(a), lb = length(b), lc = length(c);
  double edges = la * lb * lc, ideal = 1;
  if (corner_count(shape) == 4) {
    edges = std::max({edges, la * ab * ac, lb * ab * bc, lc * ac * bc});
    ideal = std::numbers::sqrt2;
  } else if (corner_count(shape) == 6) {
    edges = std::max({la * lb, la * ab, lb * ab}) * lc;
    ideal = 2 / std::numbers::sqrt3;
  }
  return edges > 0 ? ideal * j.determinant / edges : 0;
}

const Tabulated& at_corners(Shape shape) {
  static const auto all = for_shapes([](Shape s) {
    std::vector<QuadraturePoint> corners;
    for (const Vec3& p : reference_nodes(s).first(static_cast<std::size_t>(corner_count(s))))
      corners.push_back({p, 1});
    return Tabulated(s, corners);
  });
  return all[static_cast<std::size_t>(shape)];
}

} // namespace

double scaled_jacobian(const Mesh& mesh, const Element& e) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Tabulated* table : {&at_corners(e.shape), &at_stiffness_points(e.shape)})
    for (const ShapeValues& values : table->values)
      smallest = std::min(smallest, scaled(e.shape, jacobian(mesh, e, values)));
  return smallest;
}

ValidStep valid_step(const Mesh& mesh, std::span<const Vec3> target, double min_quality) {
  if (target.size() != mesh.nodes.size())
    throw InputError("a step has " + std::to_string(target.size()) + " nodes, the mesh has " +
                     std::to_string(mesh.nodes.size()));
  std::vector<std::size_t> moving;
  for (std::size_t k = 0; k < mesh.elements.size(); ++k) {
    const auto nodes = mesh.nodes_of(mesh.elements[k]);
    if (std::any_of(nodes.begin(), nodes.end(), [&](int n) {
          return target[static_cast<std::size_t>(n)] != mesh.nodes[static_cast<std::size_t>(n)];
        }))
      moving.push_back(k);
  }
  Mesh trial = mesh;
  struct Quality {
    double jacobian, volume; // scaled Jacobian; volume relative to the element's own
    [[nodiscard]] bool satisfies(double min_jacobian, double min_volume) const {
      return jacobian >= min_jacobian && volume >= min_volume;
    }
  };
  const auto quality_at = [&](std::size_t k, double fraction) -> Quality {
    const Element& e = trial.elements[k];
    for (const int n : mesh.nodes_of(mesh.elements[k])) {
      const auto node = static_cast<std::size_t>(n);
      trial.nodes[node] = mesh.nodes[node] + fraction * (target[node] - mesh.nodes[node]);
    }
    // An element that is inverted at the start may shrink.
    const double own = volume_of(mesh, e);
    return {scaled_jacobian(trial, e), own > 0 ? volume_of(trial, e) / own : 1};
  };
  ValidStep step;
  // A shorter step may invalidate an element that the longer one left valid, so the elements are
  // checked again until all are valid.
  for (bool agreed = false; !agreed;) {
    agreed = true;
    step.scaled_jacobian = 1;
    for (const std::size_t k : moving) {
      Quality quality = quality_at(k, step.fraction);
      if (!quality.satisfies(min_quality, min_quality) && step.fraction > 0) {
        const double limit =
            std::min(min_quality, (1 - 1e-9) * scaled_jacobian(mesh, mesh.elements[k]));
        double good = 0, bad = step.fraction;
        if (!quality.satisfies(limit, min_quality)) {
          while (bad - good > 1e-3) {
            const double middle = .5 * (good + bad);
            (quality_at(k, middle).satisfies(limit, min_quality) ? good : bad) = middle;
          }
          agreed = false;
          step.fraction = good;
          step.element = k;
          quality = quality_at(k, good);
        }
      }
      step.scaled_jacobian = std::min(step.scaled_jacobian, quality.jacobian);
    }
  }
  return step;
}

} // namespace tactus::fem
