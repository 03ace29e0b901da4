#include "fem/mesh/sweep.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/gmsh_model.hpp"

#include <algorithm>
#include <cmath>
#include <gmsh.h>
#include <unordered_map>

namespace tactus::fem {
namespace {

/// A triangle or quadrilateral of the base: corners counter-clockwise about the direction, then the
/// mid-edge nodes that follow each corner.
struct Cell {
  std::size_t corners;
  std::array<int, 8> node;
  /// The middle of the side from corner c.
  [[nodiscard]] int side(std::size_t c) const { return node[corners + c]; }
};

/// gmsh's mesh of the base, points in the model's unit.
struct BaseMesh {
  std::vector<Vec3> points;
  std::vector<Cell> cells;
  [[nodiscard]] const Vec3& at(int n) const { return points[static_cast<std::size_t>(n)]; }
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
  gmsh::option::setNumber("Mesh.RecombinationAlgorithm", 1); // Blossom, which finds the best pairs
                                                             // of triangles
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
    for (const auto& [type, corners] : {std::pair{9, 3}, {16, 4}}) { // gmsh's types of second order
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
std::array<Vec3, 2> tangents(const BaseMesh& mesh, const Cell& cell, const Vec3& at) {
  const Shape shape = cell.corners == 3 ? Shape::wedge15 : Shape::hex20;
  const std::size_t corners = cell.corners;
  ShapeValues values;
  evaluate(shape, {at.x, at.y, -1}, values);
  std::array<Vec3, 2> out;
  for (std::size_t c = 0; c < corners; ++c)
    for (const auto& [node, function] :
         {std::pair{cell.node[c], c}, {cell.side(c), 2 * corners + c}}) {
      out[0] += values.derivative[function].x * mesh.at(node);
      out[1] += values.derivative[function].y * mesh.at(node);
    }
  return out;
}

/// Orients cells counter-clockwise about the direction; straightens curved edges that fold a cell.
void repair_columns(BaseMesh& mesh, const Vec3& direction) {
  const auto folds = [&](const Cell& cell, double limit) {
    const auto reference = reference_nodes(cell.corners == 3 ? Shape::wedge15 : Shape::hex20);
    double largest = 0, smallest = 1e300;
    for (std::size_t c = 0; c < cell.corners; ++c)
      for (const std::size_t node : {c, 2 * cell.corners + c}) {
        const auto [r, s] = tangents(mesh, cell, reference[node]);
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
  for (int round = 0; round < 4; ++round) { // a straightened edge may fold the other cell
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
  repair_columns(base, prism.direction);
  std::vector<std::uint8_t> is_corner(base.points.size(), 0);
  for (const Cell& cell : base.cells)
    for (std::size_t c = 0; c < cell.corners; ++c)
      is_corner[static_cast<std::size_t>(cell.node[c])] = 1;
  Mesh mesh;
  const std::size_t layers = levels.size() - 1, count = base.points.size();
  // Node numbers of the base's points at levels and half-way between them, where only corners have
  // one.
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

namespace {

constexpr double kMaxSweptVolumeChange = .01; ///< difference between mesh and solid

/// Equally spaced levels as fractions of the height.
std::vector<double> even_levels(double height, double h) {
  const double count = std::max(1.0, std::ceil(height / h - 1e-9));
  std::vector<double> levels;
  for (double i = 0; i <= count; ++i)
    levels.push_back(i / count);
  return levels;
}

} // namespace

std::optional<Mesh> swept_mesh(const LoadChoice& choice, double unit, bool quadrilaterals) {
  const std::optional<Prism> prism = find_prism();
  if (!prism || (choice.sizes && choice.sizes->levels.empty()))
    return {};
  const double solid = unit * unit * unit * prism->solid, skin = unit * unit * prism->skin,
               height = unit * prism->height;
  const Vec3 box = unit * prism->box;
  std::vector<double> levels;
  const auto predict_size = [&](const MeshSize& size) {
    if (choice.on_prediction)
      choice.on_prediction(size, choice.notify);
  };
  if (choice.sizes) {
    levels = choice.sizes->levels;
    predict_size(scaled(predict_swept_size(solid, skin, box, height, choice.sizes->largest(), 1),
                        choice.sizes->elements));
    set_sizes(*choice.sizes, unit);
  } else {
    const double h = choice.size_for(solid, skin, std::max({box.x, box.y, box.z}));
    levels = even_levels(height, h);
    predict_size(
        predict_swept_size(solid, skin, box, height, h, static_cast<double>(levels.size() - 1)));
    gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
    gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", choice.swept_elements_per_turn);
    set_sizes(h / unit, {});
    gmsh::option::setNumber("Mesh.CharacteristicLengthMin", choice.swept_smallest * h / unit);
  }
  Mesh mesh = sweep(*prism, levels,
                    {.quadrilaterals = quadrilaterals, .curved = choice.curved, .unit = unit});
  check(mesh);
  if (const double change = volume(mesh) / solid - 1; std::abs(change) > kMaxSweptVolumeChange)
    throw InputError(
        format("the swept mesh's volume differs by %+.2f %% from the solid's", 100 * change));
  return mesh;
}

} // namespace tactus::fem
