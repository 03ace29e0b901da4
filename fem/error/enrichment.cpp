#include "fem/error/enrichment.hpp"

#include <algorithm>
#include <unordered_map>

namespace tactus::fem {
namespace {

struct Edge {
  int from, to;
  int axis; ///< as in Element::interval
};
constexpr std::array<Edge, 6> kTetEdges{
    {{0, 1, 0}, {1, 2, 0}, {2, 0, 0}, {0, 3, 0}, {1, 3, 0}, {2, 3, 0}}};
constexpr std::array<Edge, 9> kWedgeEdges{{{0, 1, 0},
                                           {1, 2, 1},
                                           {2, 0, 0},
                                           {3, 4, 0},
                                           {4, 5, 1},
                                           {5, 3, 0},
                                           {0, 3, 2},
                                           {1, 4, 2},
                                           {2, 5, 2}}};
constexpr std::array<Edge, 12> kHexEdges{{{0, 1, 0},
                                          {1, 2, 1},
                                          {2, 3, 0},
                                          {3, 0, 1},
                                          {4, 5, 0},
                                          {5, 6, 1},
                                          {6, 7, 0},
                                          {7, 4, 1},
                                          {0, 4, 2},
                                          {1, 5, 2},
                                          {2, 6, 2},
                                          {3, 7, 2}}};
constexpr std::array<Edge, 8> kPyramidEdges{
    {{0, 1, 0}, {1, 2, 0}, {2, 3, 0}, {3, 0, 0}, {0, 4, 0}, {1, 4, 0}, {2, 4, 0}, {3, 4, 0}}};

std::span<const Edge> edges(Shape shape) noexcept {
  switch (corner_count(shape)) {
  case 4:
    return kTetEdges;
  case 5:
    return kPyramidEdges;
  case 6:
    return kWedgeEdges;
  default:
    return kHexEdges;
  }
}

std::vector<EnrichingFunction> list(Shape shape) {
  std::vector<EnrichingFunction> functions;
  for (const Edge& e : edges(shape)) {
    EnrichingFunction f{EntityKind::edge, {e.from, e.to, -1, -1}, {}};
    f.share[static_cast<std::size_t>(e.axis)] = 1;
    functions.push_back(f);
  }
  for (const Face& face : faces(shape)) {
    if (is_linear(shape) && face.corners == 3) // the edge functions contain all quadratics of such
                                               // a face
      continue;
    EnrichingFunction f{EntityKind::face, {-1, -1, -1, -1}, {}};
    std::copy_n(face.node.begin(), face.corners, f.corner.begin());
    for (const Edge& e : edges(shape)) { // a face varies along the axes of its edges
      const auto has = [&](int n) { return std::count(f.corner.begin(), f.corner.end(), n) > 0; };
      if (has(e.from) && has(e.to))
        f.share[static_cast<std::size_t>(e.axis)] += 1.0 / face.corners;
    }
    functions.push_back(f);
  }
  if (shape == Shape::hex8 || shape == Shape::hex20)
    functions.push_back({EntityKind::interior, {-1, -1, -1, -1}, {1. / 3, 1. / 3, 1. / 3}});
  return functions;
}

/// A factor of a function with its gradient.
struct Factor {
  double value = 1;
  Vec3 slope;
};
Factor operator*(const Factor& a, const Factor& b) noexcept {
  return {a.value * b.value, b.value * a.slope + a.value * b.slope};
}

/// 4 l_a l_b (l_b - l_a) = x (1 - x^2), or 4 l_a l_b for linear elements.
Factor along_edge(const Factor& a, const Factor& b, bool linear) noexcept {
  const Factor even{4 * a.value * b.value, 4 * (b.value * a.slope + a.value * b.slope)};
  return linear ? even : even * Factor{b.value - a.value, b.slope - a.slope};
}

std::array<Factor, 4> barycentric(const Vec3& p) noexcept {
  return {
      {{1 - p.x - p.y - p.z, {-1, -1, -1}}, {p.x, {1, 0, 0}}, {p.y, {0, 1, 0}}, {p.z, {0, 0, 1}}}};
}

void tetrahedron(const Vec3& p, bool linear, std::span<Factor> out) noexcept {
  const auto l = barycentric(p);
  std::size_t i = 0;
  for (const Edge& e : kTetEdges)
    out[i++] =
        along_edge(l[static_cast<std::size_t>(e.from)], l[static_cast<std::size_t>(e.to)], linear);
  if (!linear)
    for (const Face& f : faces(Shape::tet10))
      out[i++] = Factor{27, {}} * l[static_cast<std::size_t>(f.node[0])] *
                 l[static_cast<std::size_t>(f.node[1])] * l[static_cast<std::size_t>(f.node[2])];
}

void wedge(const Vec3& p, bool linear, std::span<Factor> out) noexcept {
  const std::array<Factor, 3> l{{{1 - p.x - p.y, {-1, -1, 0}}, {p.x, {1, 0, 0}}, {p.y, {0, 1, 0}}}};
  const std::array<Factor, 2> level{{{.5 * (1 - p.z), {0, 0, -.5}}, {.5 * (1 + p.z), {0, 0, .5}}}};
  const auto at = [&](int node) { return l[static_cast<std::size_t>(node % 3)]; };
  std::size_t i = 0;
  for (const Edge& e : kWedgeEdges)
    out[i++] = e.axis == 2 ? along_edge(level[0], level[1], linear) * at(e.from)
                           : along_edge(at(e.from), at(e.to), linear) *
                                 level[static_cast<std::size_t>(e.from / 3)];
  for (const Face& f : faces(Shape::wedge15)) {
    if (f.corners == 3) {
      if (linear)
        continue;
      out[i++] =
          Factor{27, {}} * l[0] * l[1] * l[2] * level[static_cast<std::size_t>(f.node[0] / 3)];
      continue;
    }
    int a = -1, b = -1; // the two corners of the triangle at this side
    for (const int n : f.node)
      if (n >= 0 && n < 3)
        (a < 0 ? a : b) = n;
    out[i++] = along_edge(at(a), at(b), true) * along_edge(level[0], level[1], true);
  }
}

/// The functions equal a linear hexahedron's on the base and a linear tetrahedron's on the sides,
/// with u = r / (1 - t) and v = s / (1 - t).
void pyramid(const Vec3& p, std::span<Factor> out) noexcept {
  const double h = std::max(1 - p.z, 1e-12), u = p.x / h, v = p.y / h;
  const Factor up{p.z, {0, 0, 1}}, down{h, {0, 0, -1}};
  const auto toward = [&](int axis, double side) { // (1 + side u) / 2
    Factor f{.5 * (1 + side * (axis == 0 ? u : v)), {}};
    f.slope[axis] = .5 * side / h;
    f.slope.z = .5 * side * (axis == 0 ? u : v) / h;
    return f;
  };
  const auto even = [&](int axis) { return along_edge(toward(axis, -1), toward(axis, 1), true); };
  const auto corners = reference_nodes(Shape::pyramid5);
  const auto at = [&](int node) { return corners[static_cast<std::size_t>(node)]; };
  std::size_t i = 0;
  for (const Edge& e : kPyramidEdges) {
    const Vec3 from = at(e.from);
    const int along = from.x == at(e.to).x ? 1 : 0, across = 1 - along;
    out[i++] = e.to == 4 ? Factor{4, {}} * up * down * toward(0, from.x) * toward(1, from.y)
                         : down * down * even(along) * toward(across, from[across]);
  }
  out[i] = down * down * even(0) * even(1);
}

void hexahedron(const Vec3& p, bool linear, std::span<Factor> out) noexcept {
  const auto corners = reference_nodes(Shape::hex8);
  const auto toward = [&](int axis, double side) { // (1 + side x) / 2
    Factor f{.5 * (1 + side * p[axis]), {}};
    f.slope[axis] = .5 * side;
    return f;
  };
  const auto even = [&](int axis) { return along_edge(toward(axis, -1), toward(axis, 1), true); };
  std::size_t i = 0;
  for (const Edge& e : kHexEdges) {
    const Vec3& from = corners[static_cast<std::size_t>(e.from)];
    const Vec3& to = corners[static_cast<std::size_t>(e.to)];
    Factor f = along_edge(toward(e.axis, from[e.axis]), toward(e.axis, to[e.axis]), linear);
    for (int k = 0; k < 3; ++k)
      if (k != e.axis)
        f = f * toward(k, from[k]);
    out[i++] = f;
  }
  for (const Face& face : faces(Shape::hex8)) {
    Factor f;
    for (int k = 0; k < 3; ++k) {
      const double side = corners[static_cast<std::size_t>(face.node[0])][k];
      const bool across = std::all_of(face.node.begin(), face.node.begin() + 4, [&](int n) {
        return corners[static_cast<std::size_t>(n)][k] == side;
      });
      f = f * (across ? toward(k, side) : even(k));
    }
    out[i++] = f;
  }
  out[i] = even(0) * even(1) * even(2);
}

struct KeyHash {
  std::size_t operator()(const std::array<int, 4>& key) const noexcept {
    std::uint64_t h = 0xcbf29ce484222325ULL;
    for (const int k : key)
      h = (h ^ static_cast<std::uint64_t>(k + 1)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

/// The element's nodes, including mid-edge nodes, that lie on a function's edge or face.
std::vector<int> nodes_of_entity(Shape shape, const EnrichingFunction& f) {
  std::vector<int> nodes;
  const auto has = [&](int n) { return std::count(f.corner.begin(), f.corner.end(), n) > 0; };
  for (const int n : f.corner)
    if (n >= 0)
      nodes.push_back(n);
  if (is_linear(shape))
    return nodes;
  int middle = corner_count(shape);
  for (const Edge& e : edges(shape)) { // nodes and edges are in the same order
    if (has(e.from) && has(e.to))
      nodes.push_back(middle);
    ++middle;
  }
  return nodes;
}

} // namespace

std::span<const EnrichingFunction> enriching_functions(Shape shape) noexcept {
  static const auto lists = for_shapes(list);
  return lists[static_cast<std::size_t>(shape)];
}

void evaluate_enrichment(Shape shape, const Vec3& at, ShapeValues& out) noexcept {
  std::array<Factor, kMaxEnriching> f;
  switch (shape) {
  case Shape::tet4:
  case Shape::tet10:
    tetrahedron(at, is_linear(shape), f);
    break;
  case Shape::wedge6:
  case Shape::wedge15:
    wedge(at, is_linear(shape), f);
    break;
  case Shape::pyramid5:
    pyramid(at, f);
    break;
  case Shape::hex8:
  case Shape::hex20:
    hexahedron(at, is_linear(shape), f);
    break;
  }
  for (std::size_t i = 0; i < enriching_functions(shape).size(); ++i) {
    out.value[i] = f[i].value;
    out.derivative[i] = f[i].slope;
  }
}

Enrichment::Enrichment(const Mesh& mesh, std::span<const std::uint8_t> constrained_nodes) {
  std::unordered_map<std::array<int, 4>, int, KeyHash> known;
  known.reserve(4 * mesh.elements.size());
  for (const Element& e : mesh.elements) {
    first.push_back(number.size());
    const auto nodes = mesh.nodes_of(e);
    for (const EnrichingFunction& f : enriching_functions(e.shape)) {
      std::array<int, 4> key{-1, -1, -1, -1};
      for (std::size_t c = 0; c < 4; ++c)
        if (f.corner[c] >= 0)
          key[c] = nodes[static_cast<std::size_t>(f.corner[c])];
      const bool odd = f.kind == EntityKind::edge && !is_linear(e.shape);
      sign.push_back(odd && key[0] > key[1] ? -1 : 1);
      std::sort(key.begin(), key.end());
      const bool shared = f.kind != EntityKind::interior;
      const auto [at, is_new] =
          shared ? known.try_emplace(key, static_cast<int>(count)) : std::pair{known.end(), true};
      number.push_back(is_new ? static_cast<int>(count) : at->second);
      if (!is_new)
        continue;
      ++count;
      const auto on_it = nodes_of_entity(e.shape, f);
      for (std::size_t k = 0; k < 3; ++k)
        constrained.push_back(
            shared && std::all_of(on_it.begin(), on_it.end(), [&](int n) {
              return constrained_nodes[3 * static_cast<std::size_t>(
                                               nodes[static_cast<std::size_t>(n)]) +
                                       k];
            }));
    }
  }
  first.push_back(number.size());
}

} // namespace tactus::fem
