#include "fem/mesh/prism.hpp"

#include <algorithm>
#include <cmath>
#include <gmsh.h>
#include <unordered_map>

namespace tactus::fem {
namespace {

constexpr double kParallel = 1e-6; ///< sine of an angle below which directions are one
constexpr double kEqual = 1e-6;    ///< relative difference of lengths, areas, volumes

struct FlatFace {
  int tag;
  Vector3 normal, point;
  double area;
};

double mass_of(int dimension, int tag) {
  double mass = 0;
  gmsh::model::occ::getMass(dimension, tag, mass);
  return std::abs(mass);
}

/// Normals of a face at 3 x 3 of its parameters.
std::vector<Vector3> normals_of(int face, Vector3* point) {
  std::vector<double> low, high, at, xyz, normals;
  gmsh::model::getParametrizationBounds(2, face, low, high);
  for (const double u : {.1, .5, .9})
    for (const double v : {.1, .5, .9}) {
      at.push_back(low[0] + u * (high[0] - low[0]));
      at.push_back(low[1] + v * (high[1] - low[1]));
    }
  gmsh::model::getNormal(face, at, normals);
  gmsh::model::getValue(2, face, {at[0], at[1]}, xyz);
  *point = {xyz[0], xyz[1], xyz[2]};
  std::vector<Vector3> out;
  for (std::size_t i = 0; i + 2 < normals.size(); i += 3)
    out.push_back({normals[i], normals[i + 1], normals[i + 2]});
  return out;
}

/// The prism along a direction, if the faces are those of one.
std::optional<Prism> along(const Vector3& direction, const std::vector<FlatFace>& flat,
                           const std::vector<std::vector<Vector3>>& curved, double volume) {
  std::vector<const FlatFace*> ends;
  for (const FlatFace& f : flat) {
    if (length(cross(f.normal, direction)) < kParallel)
      ends.push_back(&f);
    else if (std::abs(dot(f.normal, direction)) > kParallel)
      return {};
  }
  for (const auto& normals : curved)
    for (const Vector3& n : normals)
      if (!(std::abs(dot(n, direction)) < 1e3 * kParallel))
        return {};
  if (ends.size() < 2)
    return {};
  const auto level = [&](const FlatFace* f) { return dot(f->point, direction); };
  const auto [lowest, highest] =
      std::minmax_element(ends.begin(), ends.end(), [&](const FlatFace* a, const FlatFace* b) {
        return level(a) < level(b);
      });
  const double low = level(*lowest), height = level(*highest) - low;
  Prism prism{0, {}, direction, height};
  double below = 0, above = 0;
  for (const FlatFace* f : ends) {
    const double share = (level(f) - low) / height;
    if (std::abs(share) < kEqual) {
      prism.base.push_back(f->tag);
      below += f->area;
    } else if (std::abs(share - 1) < kEqual) {
      above += f->area;
    } else {
      return {}; // a step
    }
  }
  const auto equal = [](double a, double b) { return std::abs(a - b) < 10 * kEqual * b; };
  if (!(height > 0) || !equal(below, above) || !equal(volume, below * height))
    return {};
  return prism;
}

} // namespace

std::optional<Prism> find_prism() {
  gmsh::vectorpair volumes, faces;
  gmsh::model::getEntities(volumes, 3);
  if (volumes.size() != 1)
    return {};
  gmsh::model::getBoundary(volumes, faces, true, false);
  std::vector<FlatFace> flat;
  std::vector<std::vector<Vector3>> curved;
  for (const auto& [dimension, tag] : faces) {
    std::string type;
    gmsh::model::getType(2, tag, type);
    Vector3 point;
    auto normals = normals_of(tag, &point);
    if (type == "Plane")
      flat.push_back({tag, normals[4], point, mass_of(2, tag)});
    else
      curved.push_back(std::move(normals));
  }
  std::optional<Prism> best;
  std::vector<Vector3> tried;
  for (const FlatFace& f : flat) {
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vector3& d) { return length(cross(d, f.normal)) < kParallel; }))
      continue;
    tried.push_back(f.normal);
    auto prism = along(f.normal, flat, curved, mass_of(3, volumes[0].second));
    if (prism && (!best || prism->height < (1 - kEqual) * best->height))
      best = std::move(prism);
  }
  if (best)
    best->volume = volumes[0].second;
  return best;
}

namespace {

/// A triangle or quadrilateral of the base: corners counter-clockwise about the direction, then the
/// middles of the sides that follow each.
struct Cell {
  std::size_t corners;
  std::array<int, 8> node;
  /// The middle of the side from corner c.
  [[nodiscard]] int side(std::size_t c) const { return node[corners + c]; }
};

/// gmsh's mesh of the base, points in the model's unit.
struct BaseMesh {
  std::vector<Vector3> points;
  std::vector<Cell> cells;
  [[nodiscard]] const Vector3& at(int n) const { return points[static_cast<std::size_t>(n)]; }
};

BaseMesh mesh_base(const Prism& prism, const SweepChoice& choice) {
  gmsh::vectorpair faces, others;
  gmsh::model::getEntities(faces, 2);
  for (const auto& face : faces)
    if (std::find(prism.base.begin(), prism.base.end(), face.second) == prism.base.end())
      others.push_back(face);
  gmsh::model::occ::remove({{3, prism.volume}});
  gmsh::model::occ::remove(others, true);
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.RecombineAll", choice.quadrilaterals ? 1 : 0);
  gmsh::option::setNumber("Mesh.RecombinationAlgorithm", 1); // Blossom: the best pairs of triangles
  gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 1);
  gmsh::model::mesh::generate(2);
  gmsh::option::setNumber("Mesh.SecondOrderLinear", choice.curved ? 0 : 1);
  gmsh::model::mesh::setOrder(2);
  BaseMesh mesh;
  std::unordered_map<std::size_t, int> number;
  std::unordered_map<std::size_t, std::size_t> position;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i)
    position[tags[i]] = 3 * i;
  for (const int face : prism.base)
    for (const auto& [type, corners] : {std::pair{9, 3}, {16, 4}}) { // gmsh's, of second order
      std::vector<std::size_t> elements, nodes;
      gmsh::model::mesh::getElementsByType(type, elements, nodes, face);
      const auto all = 2 * static_cast<std::size_t>(corners);
      for (std::size_t first = 0; first + all <= nodes.size(); first += all) {
        Cell cell{static_cast<std::size_t>(corners), {}};
        for (std::size_t c = 0; c < all; ++c) {
          const std::size_t tag = nodes[first + c];
          const auto [at, is_new] = number.try_emplace(tag, static_cast<int>(mesh.points.size()));
          if (is_new) {
            const double* p = &xyz[position.at(tag)];
            mesh.points.push_back({p[0], p[1], p[2]});
          }
          cell.node[c] = at->second;
        }
        mesh.cells.push_back(cell);
      }
    }
  return mesh;
}

/// Tangents along both reference axes at a point of a cell, the derivative of its 6 or 8 shape
/// functions (those of the element's lower face).
std::array<Vector3, 2> tangents(const BaseMesh& mesh, const Cell& cell, const Vector3& at) {
  const Shape shape = cell.corners == 3 ? Shape::wedge15 : Shape::hex20;
  const std::size_t corners = cell.corners;
  ShapeValues values;
  evaluate(shape, {at.x, at.y, -1}, values);
  std::array<Vector3, 2> out;
  for (std::size_t c = 0; c < corners; ++c)
    for (const auto& [node, function] :
         {std::pair{cell.node[c], c}, {cell.side(c), 2 * corners + c}}) {
      out[0] += values.derivative[function].x * mesh.at(node);
      out[1] += values.derivative[function].y * mesh.at(node);
    }
  return out;
}

/// Turns cells counter-clockwise about the direction; straightens the sides of those that curve so
/// much that they fold.
void mend(BaseMesh& mesh, const Vector3& direction) {
  const auto folds = [&](const Cell& cell, double limit) {
    const auto places = reference_nodes(cell.corners == 3 ? Shape::wedge15 : Shape::hex20);
    double largest = 0, smallest = 1e300;
    for (std::size_t c = 0; c < cell.corners; ++c)
      for (const std::size_t node : {c, 2 * cell.corners + c}) {
        const auto [r, s] = tangents(mesh, cell, places[node]);
        const double area = dot(cross(r, s), direction);
        largest = std::max(largest, area);
        smallest = std::min(smallest, area);
      }
    return !(smallest > limit * largest);
  };
  for (Cell& cell : mesh.cells) {
    double area = 0;
    for (std::size_t c = 0; c < cell.corners; ++c)
      area +=
          dot(cross(mesh.at(cell.node[c]), mesh.at(cell.node[(c + 1) % cell.corners])), direction);
    if (area > 0)
      continue;
    std::reverse(cell.node.begin() + 1, cell.node.begin() + static_cast<int>(cell.corners));
    std::reverse(cell.node.begin() + static_cast<int>(cell.corners),
                 cell.node.begin() + 2 * static_cast<int>(cell.corners));
  }
  for (int round = 0; round < 4; ++round) { // a side straightened may fold its other cell
    bool any = false;
    for (const Cell& cell : mesh.cells)
      if (folds(cell, .05)) {
        for (std::size_t c = 0; c < cell.corners; ++c)
          mesh.points[static_cast<std::size_t>(cell.side(c))] =
              .5 * (mesh.at(cell.node[c]) + mesh.at(cell.node[(c + 1) % cell.corners]));
        any = true;
      }
    if (!any)
      break;
  }
}

} // namespace

Mesh sweep(const Prism& prism, std::span<const double> levels, const SweepChoice& choice) {
  BaseMesh base = mesh_base(prism, choice);
  mend(base, prism.direction);
  std::vector<std::uint8_t> is_corner(base.points.size(), 0);
  for (const Cell& cell : base.cells)
    for (std::size_t c = 0; c < cell.corners; ++c)
      is_corner[static_cast<std::size_t>(cell.node[c])] = 1;
  Mesh mesh;
  const std::size_t layers = levels.size() - 1, count = base.points.size();
  // Node numbers of the base's points at levels and half way between, where corners alone have one.
  std::vector<int> number((2 * layers + 1) * count, -1);
  for (std::size_t step = 0; step <= 2 * layers; ++step) {
    const double share =
        step % 2 == 0 ? levels[step / 2] : .5 * (levels[step / 2] + levels[step / 2 + 1]);
    for (std::size_t p = 0; p < count; ++p)
      if (step % 2 == 0 || is_corner[p]) {
        number[step * count + p] = static_cast<int>(mesh.nodes.size());
        mesh.nodes.push_back(choice.unit *
                             (base.points[p] + share * prism.height * prism.direction));
      }
  }
  const auto columns = static_cast<int>(base.cells.size());
  for (std::size_t layer = 0; layer < layers; ++layer)
    for (int column = 0; column < columns; ++column) {
      const Cell& cell = base.cells[static_cast<std::size_t>(column)];
      const auto at = [&](std::size_t step, int point) {
        return number[(2 * layer + step) * count + static_cast<std::size_t>(point)];
      };
      std::array<int, 20> nodes{};
      const std::size_t n = cell.corners;
      for (std::size_t c = 0; c < n; ++c) {
        nodes[c] = at(0, cell.node[c]);
        nodes[n + c] = at(2, cell.node[c]);
        nodes[2 * n + c] = at(0, cell.side(c));
        nodes[3 * n + c] = at(2, cell.side(c));
        nodes[4 * n + c] = at(1, cell.node[c]);
      }
      mesh.add(n == 3 ? Shape::wedge15 : Shape::hex20, std::span(nodes).first(5 * n));
      mesh.elements.back().interval = {column, column, columns + static_cast<int>(layer)};
    }
  return mesh;
}

std::vector<double> even_levels(double height, double h) {
  const double count = std::max(1.0, std::ceil(height / h - 1e-9));
  std::vector<double> levels;
  for (double i = 0; i <= count; ++i)
    levels.push_back(i / count);
  return levels;
}

} // namespace tactus::fem
