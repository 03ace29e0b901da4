#include "fem/mesh/mesh_size.hpp"

#include "fem/mesh/mesh.hpp"
#include "fem/mesh/surface.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// Sides, longest first, of the block with a body's volume and skin area, the longest at least
/// `largest`. For a curled shell it is the block of the flattened shell.
std::array<double, 3> equivalent_block(double volume, double skin, double largest) {
  const auto others = [&](double a) { // b c and b + c
    return std::array{volume / a, (skin / 2 - volume / a) / a};
  };
  const auto [product, sum] = others(largest);
  const double root = sum * sum - 4 * product;
  if (!(root > 0)) // more compact than any block
    return {largest, std::sqrt(product), std::sqrt(product)};
  const double b = (sum + std::sqrt(root)) / 2;
  if (b <= largest)
    return {largest, b, product / b};
  // For a square plate S = 2 a^2 + 4 V / a; this finds the larger root a.
  double a = std::sqrt(skin / 2);
  for (int i = 0; i < 60; ++i)
    a = std::sqrt(std::max(skin / 2 - 2 * volume / a, 0.0) + 1e-300);
  return {a, a, volume / (a * a)};
}

} // namespace

namespace {

void set_cells(MeshSize& size, double skin) {
  size.cells = equivalent_block(size.volume, skin, std::max({size.box.x, size.box.y, size.box.z}));
  const double scale = std::cbrt(size.nodes / 4 / (size.cells[0] * size.cells[1] * size.cells[2]));
  for (double& c : size.cells)
    c *= scale;
}

/// Node pairs of tet10 by inclusion and exclusion (10 * 11 / 2 = 55 per tetrahedron, 21 per shared
/// face, 6 per inner edge, 1 per inner corner). Euler's formula gives the number of edges.
double pairs_of_tet10(double tetrahedra, double faces, double nodes) {
  const double corners = std::max(0.0, (nodes - tetrahedra - faces / 2) / 2),
               edges = nodes - corners;
  return 55 * tetrahedra - 21 * (2 * tetrahedra - faces / 2) + 6 * (edges - 1.5 * faces) -
         (corners - faces / 2);
}

/// A plane across a tet10 mesh contains this fraction of the nodes on a plane across a hex20 mesh
/// with the same total number of nodes.
constexpr double kTet10OnPlanes = .65;

} // namespace

MeshSize size_of(const Mesh& mesh) {
  MeshSize size;
  size.elements = static_cast<double>(mesh.elements.size());
  size.nodes = static_cast<double>(mesh.nodes.size());
  double tetrahedra = 0;
  for (const Element& e : mesh.elements)
    tetrahedra += e.shape == Shape::tet10 || e.shape == Shape::tet4;
  const Surface surface = surface_of(mesh);
  size.skin_triangles = static_cast<double>(surface.triangles.size());
  const double share = tetrahedra / size.elements;
  size.nodes_on_planes = 1 - (1 - kTet10OnPlanes) * share;
  size.node_pairs = share * pairs_of_tet10(size.elements, size.skin_triangles / 4, size.nodes) +
                    (1 - share) * 28 * size.nodes;
  double skin = 0;
  for (const auto& t : surface.triangles) {
    const auto at = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(surface.node[static_cast<std::size_t>(t[k])])];
    };
    skin += .5 * length(cross(at(1) - at(0), at(2) - at(0)));
  }
  size.volume = volume(mesh);
  size.box = bounding_box(mesh.nodes).size();
  set_cells(size, skin);
  return size;
}

MeshSize predict_tetrahedra(double volume, double skin_area, const Vec3& box, double h,
                            double faces) {
  MeshSize size;
  size.volume = volume;
  size.skin_area = skin_area;
  size.h = h;
  size.box = box;
  if (!(faces > 0))
    faces = 2.5 * skin_area / (h * h);
  // In walls thinner than h, there is a prism of three tetrahedra for every two faces.
  size.elements = std::cbrt(std::pow(5 * volume / (h * h * h), 3) + std::pow(1.53 * faces, 3));
  size.nodes = 1.33 * size.elements + faces;
  size.node_pairs = pairs_of_tet10(size.elements, faces, size.nodes);
  size.skin_triangles = 4 * faces;
  size.nodes_on_planes = kTet10OnPlanes;
  size.nodes_made = 10 * size.elements;
  set_cells(size, skin_area);
  return size;
}

MeshSize predict_swept_size(double volume, double skin_area, const Vec3& box, double height,
                            double h, double layers) {
  MeshSize size;
  size.volume = volume;
  size.skin_area = skin_area;
  size.box = box;
  size.height = height;
  const double base = volume / height, side = (skin_area - 2 * base) / height;
  const double triangles = 2.4 * base / (h * h) + side / h; // the base's rim
  size.elements = triangles * layers;
  size.nodes = 2 * triangles * (layers + 1) + .5 * triangles * layers;
  size.node_pairs = 25 * size.nodes;
  size.skin_triangles = 8 * triangles + 12 * side / h * layers;
  size.nodes_made = size.nodes;
  set_cells(size, skin_area);
  return size;
}

MeshSize scaled(const MeshSize& size, double elements) {
  const double ratio = elements / size.elements, side = std::cbrt(ratio);
  MeshSize other = size;
  for (double* count : {&other.elements, &other.nodes, &other.node_pairs, &other.nodes_made})
    *count *= ratio;
  other.skin_triangles *= side * side;
  for (double& cells : other.cells)
    cells *= side;
  other.h /= side;
  return other;
}

MeshSize resized_tetrahedra(const MeshSize& size, double h) {
  const auto even = [&](double at) {
    return predict_tetrahedra(size.volume, size.skin_area, size.box, at);
  };
  const double faces = even(h).skin_triangles / 4;
  return predict_tetrahedra(size.volume, size.skin_area, size.box, h,
                            faces * size.skin_triangles / even(size.h).skin_triangles);
}

} // namespace tactus::fem
