#include "fem/statics/face_points.hpp"

#include <string>

namespace tactus::fem {
namespace {

struct Point1D {
  double at, weight;
};
constexpr std::array<Point1D, 3> kGauss3{
    {{-.7745966692414834, 5. / 9}, {0, 8. / 9}, {.7745966692414834, 5. / 9}}};
constexpr std::array<Point1D, 4> kGauss4{{{-.8611363115940526, .3478548451374539},
                                          {-.3399810435848563, .6521451548625461},
                                          {.3399810435848563, .6521451548625461},
                                          {.8611363115940526, .3478548451374539}}};

/// The element's shape functions on a face: N and their slopes along the face's two directions.
struct FaceTable {
  struct At {
    std::array<double, 8> value{}, slope_u{}, slope_v{};
    double weight = 0;
  };
  std::size_t nodes = 0;
  std::vector<At> points;
};

FaceTable tabulate(Shape shape, const Face& face) {
  FaceTable table;
  const auto reference = reference_nodes(shape);
  const auto corner = [&](std::size_t i) {
    return reference[static_cast<std::size_t>(face.node[i])];
  };
  table.nodes = static_cast<std::size_t>(face.corners) * (is_linear(shape) ? 1 : 2);
  const bool triangle = face.corners == 3;
  // Both kinds of face are origin + u along + v across in reference coordinates.
  const Vec3 along = corner(1) - corner(0);
  const Vec3 across = corner(triangle ? 2 : 3) - corner(0);
  const auto add = [&](double u, double v, double weight) {
    ShapeValues values;
    evaluate(shape, corner(0) + u * along + v * across, values);
    FaceTable::At& at = table.points.emplace_back();
    at.weight = weight;
    for (std::size_t a = 0; a < table.nodes; ++a) {
      const auto own = static_cast<std::size_t>(face.node[a]);
      at.value[a] = values.value[own];
      at.slope_u[a] = dot(values.derivative[own], along);
      at.slope_v[a] = dot(values.derivative[own], across);
    }
  };
  if (triangle) {
    for (const Point1D& p : kGauss4)
      for (const Point1D& q : kGauss4) {
        const double u = .5 * (1 + p.at), v = .5 * (1 + q.at) * (1 - u);
        add(u, v, .25 * p.weight * q.weight * (1 - u));
      }
  } else {
    for (const Point1D& p : kGauss3)
      for (const Point1D& q : kGauss3)
        add(.5 * (1 + p.at), .5 * (1 + q.at), .25 * p.weight * q.weight);
  }
  return table;
}

const FaceTable& table_of(Shape shape, std::size_t face) {
  static const auto tables = for_shapes([](Shape s) {
    std::vector<FaceTable> all;
    for (const Face& f : faces(s))
      all.push_back(tabulate(s, f));
    return all;
  });
  return tables[static_cast<std::size_t>(shape)][face];
}

} // namespace

FaceNodes face_nodes(const Mesh& mesh, const MeshFace& f) {
  const Element& e = mesh.elements[static_cast<std::size_t>(f.element)];
  const auto nodes = mesh.nodes_of(e);
  const Face& face = faces(e.shape)[static_cast<std::size_t>(f.face)];
  FaceNodes found;
  found.count = static_cast<std::size_t>(face.corners) * (is_linear(e.shape) ? 1 : 2);
  for (std::size_t a = 0; a < found.count; ++a)
    found.node[a] = static_cast<std::size_t>(nodes[static_cast<std::size_t>(face.node[a])]);
  return found;
}

std::span<const FacePoint> face_points(const Mesh& mesh, const MeshFace& f) {
  thread_local std::vector<FacePoint> points;
  const FaceNodes nodes = face_nodes(mesh, f);
  const FaceTable& table = table_of(mesh.elements[static_cast<std::size_t>(f.element)].shape,
                                    static_cast<std::size_t>(f.face));
  points.clear();
  for (const FaceTable::At& at : table.points) {
    Vec3 u, v;
    for (std::size_t a = 0; a < nodes.count; ++a) {
      u += at.slope_u[a] * mesh.nodes[nodes.node[a]];
      v += at.slope_v[a] * mesh.nodes[nodes.node[a]];
    }
    points.push_back({at.value, at.weight * cross(u, v)});
  }
  return points;
}

void check_faces(const Mesh& mesh, std::span<const MeshFace> given, const std::string& label) {
  if (given.empty())
    throw InputError(label + " has no face, expected at least one face of the skin");
  for (const MeshFace& f : given)
    if (f.element < 0 || static_cast<std::size_t>(f.element) >= mesh.elements.size() ||
        f.face < 0 ||
        static_cast<std::size_t>(f.face) >=
            faces(mesh.elements[static_cast<std::size_t>(f.element)].shape).size())
      throw InputError(label + " names face " + std::to_string(f.face) + " of element " +
                       std::to_string(f.element + 1) + ", which does not exist");
}

} // namespace tactus::fem
