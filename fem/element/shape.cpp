#include "fem/element/shape.hpp"

namespace tactus::fem {
namespace {

constexpr std::array<Vec3, 10> kTet{{{0, 0, 0},
                                     {1, 0, 0},
                                     {0, 1, 0},
                                     {0, 0, 1},
                                     {.5, 0, 0},
                                     {.5, .5, 0},
                                     {0, .5, 0},
                                     {0, 0, .5},
                                     {.5, 0, .5},
                                     {0, .5, .5}}};
constexpr std::array<Vec3, 15> kWedge{{{0, 0, -1},
                                       {1, 0, -1},
                                       {0, 1, -1},
                                       {0, 0, 1},
                                       {1, 0, 1},
                                       {0, 1, 1},
                                       {.5, 0, -1},
                                       {.5, .5, -1},
                                       {0, .5, -1},
                                       {.5, 0, 1},
                                       {.5, .5, 1},
                                       {0, .5, 1},
                                       {0, 0, 0},
                                       {1, 0, 0},
                                       {0, 1, 0}}};
constexpr std::array<Vec3, 20> kHex{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
     {-1, 1, 1},   {0, -1, -1}, {1, 0, -1},  {0, 1, -1},  {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},
     {0, 1, 1},    {-1, 0, 1},  {-1, -1, 0}, {1, -1, 0},  {1, 1, 0},   {-1, 1, 0}}};

constexpr std::array<Vec3, 5> kPyramid{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}};

constexpr std::array<Face, 4> kTet4Faces{{{3, {0, 2, 1, -1, -1, -1, -1, -1}},
                                          {3, {0, 1, 3, -1, -1, -1, -1, -1}},
                                          {3, {1, 2, 3, -1, -1, -1, -1, -1}},
                                          {3, {0, 3, 2, -1, -1, -1, -1, -1}}}};
constexpr std::array<Face, 4> kTet10Faces{{{3, {0, 2, 1, 6, 5, 4, -1, -1}},
                                           {3, {0, 1, 3, 4, 8, 7, -1, -1}},
                                           {3, {1, 2, 3, 5, 9, 8, -1, -1}},
                                           {3, {0, 3, 2, 7, 9, 6, -1, -1}}}};
constexpr std::array<Face, 6> kHex8Faces{{{4, {0, 3, 2, 1, -1, -1, -1, -1}},
                                          {4, {4, 5, 6, 7, -1, -1, -1, -1}},
                                          {4, {0, 1, 5, 4, -1, -1, -1, -1}},
                                          {4, {1, 2, 6, 5, -1, -1, -1, -1}},
                                          {4, {2, 3, 7, 6, -1, -1, -1, -1}},
                                          {4, {3, 0, 4, 7, -1, -1, -1, -1}}}};
constexpr std::array<Face, 6> kHex20Faces{{{4, {0, 3, 2, 1, 11, 10, 9, 8}},
                                           {4, {4, 5, 6, 7, 12, 13, 14, 15}},
                                           {4, {0, 1, 5, 4, 8, 17, 12, 16}},
                                           {4, {1, 2, 6, 5, 9, 18, 13, 17}},
                                           {4, {2, 3, 7, 6, 10, 19, 14, 18}},
                                           {4, {3, 0, 4, 7, 11, 16, 15, 19}}}};
constexpr std::array<Face, 5> kWedgeFaces{{{3, {0, 2, 1, 8, 7, 6, -1, -1}},
                                           {3, {3, 4, 5, 9, 10, 11, -1, -1}},
                                           {4, {0, 1, 4, 3, 6, 13, 9, 12}},
                                           {4, {1, 2, 5, 4, 7, 14, 10, 13}},
                                           {4, {2, 0, 3, 5, 8, 12, 11, 14}}}};
constexpr std::array<Face, 5> kWedge6Faces{{{3, {0, 2, 1, -1, -1, -1, -1, -1}},
                                            {3, {3, 4, 5, -1, -1, -1, -1, -1}},
                                            {4, {0, 1, 4, 3, -1, -1, -1, -1}},
                                            {4, {1, 2, 5, 4, -1, -1, -1, -1}},
                                            {4, {2, 0, 3, 5, -1, -1, -1, -1}}}};
constexpr std::array<Face, 5> kPyramidFaces{{{4, {0, 3, 2, 1, -1, -1, -1, -1}},
                                             {3, {0, 1, 4, -1, -1, -1, -1, -1}},
                                             {3, {1, 2, 4, -1, -1, -1, -1, -1}},
                                             {3, {2, 3, 4, -1, -1, -1, -1, -1}},
                                             {3, {3, 0, 4, -1, -1, -1, -1, -1}}}};

constexpr std::array<Vec3, 4> kBarycentricSlopes{{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

void tetrahedron(const Vec3& p, bool quadratic, ShapeValues& out) noexcept {
  const std::array<double, 4> l{1 - p.x - p.y - p.z, p.x, p.y, p.z};
  for (std::size_t i = 0; i < 4; ++i) {
    out.value[i] = quadratic ? l[i] * (2 * l[i] - 1) : l[i];
    out.derivative[i] = (quadratic ? 4 * l[i] - 1 : 1.0) * kBarycentricSlopes[i];
  }
  if (!quadratic)
    return;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(kTetEdges[e][0]);
    const auto b = static_cast<std::size_t>(kTetEdges[e][1]);
    out.value[4 + e] = 4 * l[a] * l[b];
    out.derivative[4 + e] = 4 * l[b] * kBarycentricSlopes[a] + 4 * l[a] * kBarycentricSlopes[b];
  }
}

constexpr std::array<Vec3, 3> kWedgeSlopes{{{-1, -1, 0}, {1, 0, 0}, {0, 1, 0}}};

void linear_wedge(const Vec3& p, ShapeValues& out) noexcept {
  const std::array<double, 3> l{1 - p.x - p.y, p.x, p.y};
  for (std::size_t i = 0; i < 6; ++i) {
    const double sign = i < 3 ? -1 : 1, h = .5 * (1 + sign * p.z);
    out.value[i] = l[i % 3] * h;
    out.derivative[i] = h * kWedgeSlopes[i % 3];
    out.derivative[i].z = .5 * sign * l[i % 3];
  }
}

/// Bilinear on the base and linear on the sides, so that hexahedra and tetrahedra can join it. At
/// the apex the quotients have their limits along the axis (Bedrosian 1992).
void pyramid(const Vec3& p, ShapeValues& out) noexcept {
  const double h = 1 - p.z, u = h > 0 ? p.x / h : 0, v = h > 0 ? p.y / h : 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double a = kPyramid[i].x, b = kPyramid[i].y;
    out.value[i] = .25 * h * (1 + a * u) * (1 + b * v);
    out.derivative[i] = .25 * Vec3{a * (1 + b * v), b * (1 + a * u), a * b * u * v - 1};
  }
  out.value[4] = p.z;
  out.derivative[4] = {0, 0, 1};
}

void wedge(const Vec3& p, ShapeValues& out) noexcept {
  const std::array<double, 3> l{1 - p.x - p.y, p.x, p.y};
  const std::array<Vec3, 3>& slope = kWedgeSlopes;
  const double t = p.z, q = 1 - t * t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t level = 0; level < 2; ++level) {
      const double sign = level == 0 ? -1 : 1, h = 1 + sign * t;
      const std::size_t corner = i + 3 * level, edge = 6 + i + 3 * level, j = (i + 1) % 3;
      out.value[corner] = .5 * l[i] * ((2 * l[i] - 1) * h - q);
      Vec3 d = .5 * ((4 * l[i] - 1) * h - q) * slope[i];
      d.z = .5 * l[i] * ((2 * l[i] - 1) * sign + 2 * t);
      out.derivative[corner] = d;
      out.value[edge] = 2 * l[i] * l[j] * h;
      d = 2 * h * l[j] * slope[i] + 2 * h * l[i] * slope[j];
      d.z = 2 * l[i] * l[j] * sign;
      out.derivative[edge] = d;
    }
    out.value[12 + i] = l[i] * q;
    Vec3 d = q * slope[i];
    d.z = -2 * t * l[i];
    out.derivative[12 + i] = d;
  }
}

void hexahedron(const Vec3& x, bool quadratic, ShapeValues& out) noexcept {
  const std::size_t count = quadratic ? 20 : 8;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& p = kHex[i];
    const Vec3 a{1 + p.x * x.x, 1 + p.y * x.y, 1 + p.z * x.z};
    int along = -1; // the direction of an edge node's edge
    for (int k = 0; k < 3; ++k)
      if (p[k] == 0)
        along = k;
    Vec3 d;
    if (along >= 0) {
      const int j = (along + 1) % 3, k = (along + 2) % 3;
      const double q = 1 - x[along] * x[along];
      out.value[i] = .25 * q * a[j] * a[k];
      d[along] = -.5 * x[along] * a[j] * a[k];
      d[j] = .25 * q * p[j] * a[k];
      d[k] = .25 * q * a[j] * p[k];
    } else {
      const double g = quadratic ? dot(p, x) - 2 : 1;
      out.value[i] = .125 * a.x * a.y * a.z * g;
      for (int k = 0; k < 3; ++k)
        d[k] = .125 * p[k] * a[(k + 1) % 3] * a[(k + 2) % 3] * (g + (quadratic ? a[k] : 0));
    }
    out.derivative[i] = d;
  }
}

} // namespace

int node_count(Shape shape) noexcept {
  constexpr std::array<int, kShapes> counts{4, 10, 8, 20, 15, 6, 5};
  return counts[static_cast<std::size_t>(shape)];
}

int corner_count(Shape shape) noexcept {
  constexpr std::array<int, kShapes> counts{4, 4, 8, 8, 6, 6, 5};
  return counts[static_cast<std::size_t>(shape)];
}

bool is_linear(Shape shape) noexcept { return node_count(shape) == corner_count(shape); }

std::string_view name(Shape shape) noexcept {
  constexpr std::array<std::string_view, kShapes> names{"tet4",    "tet10",  "hex8",    "hex20",
                                                        "wedge15", "wedge6", "pyramid5"};
  return names[static_cast<std::size_t>(shape)];
}

int vtk_type(Shape shape) noexcept {
  constexpr std::array<int, kShapes> types{10, 24, 12, 25, 26, 13, 14};
  return types[static_cast<std::size_t>(shape)];
}

void evaluate(Shape shape, const Vec3& at, ShapeValues& out) noexcept {
  switch (shape) {
  case Shape::tet4:
    return tetrahedron(at, false, out);
  case Shape::tet10:
    return tetrahedron(at, true, out);
  case Shape::hex8:
    return hexahedron(at, false, out);
  case Shape::hex20:
    return hexahedron(at, true, out);
  case Shape::wedge15:
    return wedge(at, out);
  case Shape::wedge6:
    return linear_wedge(at, out);
  case Shape::pyramid5:
    return pyramid(at, out);
  }
}

std::span<const Vec3> reference_nodes(Shape shape) noexcept {
  const auto count = static_cast<std::size_t>(node_count(shape));
  switch (shape) {
  case Shape::tet4:
  case Shape::tet10:
    return std::span(kTet).first(count);
  case Shape::hex8:
  case Shape::hex20:
    return std::span(kHex).first(count);
  case Shape::pyramid5:
    return kPyramid;
  case Shape::wedge6:
  case Shape::wedge15:
    break;
  }
  return std::span(kWedge).first(count);
}

std::span<const Face> faces(Shape shape) noexcept {
  switch (shape) {
  case Shape::tet4:
    return kTet4Faces;
  case Shape::tet10:
    return kTet10Faces;
  case Shape::hex8:
    return kHex8Faces;
  case Shape::hex20:
    return kHex20Faces;
  case Shape::wedge6:
    return kWedge6Faces;
  case Shape::pyramid5:
    return kPyramidFaces;
  case Shape::wedge15:
    break;
  }
  return kWedgeFaces;
}

} // namespace tactus::fem
