#include "fem/shapes/shapes.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/shapes/ball.hpp"
#include "fem/shapes/block.hpp"
#include "fem/shapes/section.hpp"
#include "fem/shapes/spline.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

namespace tactus::fem {
namespace {

constexpr double kRequired = std::numeric_limits<double>::quiet_NaN();
using std::numbers::pi;

using Dimensions = std::map<std::string, double>;

double element_size(const MeshChoice& choice, double largest) {
  return choice.h > 0 ? choice.h : largest / 16;
}

double layers_of(const MeshChoice& choice, double default_value) {
  return choice.layers > 0 ? choice.layers : choice.sparse ? 1 : default_value;
}

/// Number of sectors around the axis, with sides about h long. It is a multiple of four so that
/// meshes are symmetric.
double sectors_for(double radius, double h) {
  return std::max(16.0, 4 * std::ceil(2 * pi * radius / h / 4 - 1e-9));
}

/// The size of a revolved section's mesh. Node pairs follow by inclusion and exclusion: the pairs
/// of each element, minus those of faces shared by two elements, plus those of edges, minus those
/// of corners.
MeshSize turned(const SectionSize& s, double sectors, std::array<double, 2> section_cells) {
  const double inner_sides = s.sides - s.outer_sides - s.axis_sides;
  const double inner_corners = s.corners - s.outer_sides - s.axis_corners;
  MeshSize size;
  size.elements = sectors * s.quads;
  size.nodes = sectors * (2 * (s.corners - s.axis_corners) + s.sides - s.axis_sides) +
               s.axis_corners + s.axis_sides;
  size.node_pairs = sectors * (210 * (s.quads - s.axis_quads) + 120 * s.axis_quads - 36 * s.quads -
                               30 * inner_sides + 5 * inner_corners);
  size.skin_triangles = 6 * sectors * s.outer_sides;
  size.cells = {sectors, section_cells[0], section_cells[1]};
  size.nodes_made = 20 * size.elements;
  return size;
}

ShapePlan planned(const MeshSize& size, std::function<SweptBody()> make) {
  return {size, [nodes = size.nodes, make = std::move(make)] {
            if (!(nodes < 1e8)) // twenty per element are made before merging
              throw InputError(format("the mesh would have %.3g nodes, expected at most 1e8: use a "
                                      "larger --h",
                                      nodes));
            return make();
          }};
}

void require(bool good, const std::string& shape, const std::string& expected) {
  if (!good)
    throw InputError(shape + ": expected " + expected);
}

using GivenGrid = std::optional<SweepGrid>;

GivenGrid grid_of(const MeshChoice& choice) {
  return choice.grid ? GivenGrid(*choice.grid) : std::nullopt;
}
const SweepGrid* pointer_to(const GivenGrid& grid) { return grid ? &*grid : nullptr; }

double cells_of(const SweepGrid& grid, std::size_t direction) {
  return static_cast<double>(grid.line[direction].size() - 1);
}

/// Number of sectors around the axis, or that of a given grid.
double sectors_of(const MeshChoice& choice, double radius, double h) {
  return choice.grid ? cells_of(*choice.grid, 2) : sectors_for(radius, h);
}

/// Turns a section about the axis.
SweptBody turn(Section section, double number) {
  const int sectors = static_cast<int>(number);
  SweptBody body{revolve(section, sectors), std::move(section.grid)};
  body.grid.uniform[2] = 4;
  body.grid.line[2].clear();
  for (int i = 0; i <= sectors; ++i)
    body.grid.line[2].push_back(2 * pi * i / sectors);
  return body;
}

ShapePlan solid_of_revolution(Rectangles shape, const MeshChoice& choice, double largest) {
  shape.h = element_size(choice, largest);
  shape.grade = choice.grade_concave;
  shape.min_divisions_r = choice.sparse ? 1 : 2;
  shape.grading = choice.sparse ? 9 : 27;
  shape.min_divisions_z = static_cast<int>(layers_of(choice, 3));
  const double sectors = sectors_of(choice, shape.r.back(), shape.h);
  const SectionSize section = size_of(shape, choice.grid);
  const double up = std::max(1.0, section.quads * (shape.z.back() - shape.z.front()));
  const double across = std::max(1.0, section.quads * (shape.r.back() - shape.r.front()));
  MeshSize size =
      turned(section, sectors,
             {std::sqrt(section.quads * across / up), std::sqrt(section.quads * up / across)});
  for (std::size_t i = 0; i + 1 < shape.r.size(); ++i)
    for (std::size_t j = 0; j + 1 < shape.z.size(); ++j)
      if (shape.solid[i][j])
        size.volume += pi * (shape.r[i + 1] * shape.r[i + 1] - shape.r[i] * shape.r[i]) *
                       (shape.z[j + 1] - shape.z[j]);
  const double wide = 2 * shape.r.back();
  size.box = {wide, wide, shape.z.back() - shape.z.front()};
  return planned(size, [shape = std::move(shape), sectors, given = grid_of(choice)] {
    return turn(rectangles(shape, pointer_to(given)), sectors);
  });
}

ShapePlan shell_of_revolution(Shell s, const MeshChoice& choice, double largest) {
  // The swept layer follows the curve. Where it is thin, one quadratic element suffices across it.
  // But thin elements bend too stiffly unless they are short, so shells are twice as fine as
  // solids.
  const double h = choice.h > 0 ? choice.h : largest / 28;
  double arc = 0, radius = 0, thickest = 0, solid = 0, low = s.middle(0).z, high = low;
  constexpr int kSamples = 400;
  for (int i = 0; i < kSamples; ++i) {
    const Meridian a = s.middle(double(i) / kSamples), b = s.middle(double(i + 1) / kSamples);
    const double step = std::hypot(b.r - a.r, b.z - a.z);
    arc += step;
    radius = std::max(radius, b.r);
    low = std::min(low, b.z);
    high = std::max(high, b.z);
    thickest = std::max(thickest, s.thickness(double(i) / kSamples));
    solid += pi * (a.r + b.r) * step * s.thickness((i + .5) / kSamples);
  }
  const double default_value =
      std::max(thickest < .05 * largest ? 1.0 : 2.0, std::ceil(thickest / h));
  const double along = choice.grid ? cells_of(*choice.grid, 0) : std::max(8.0, std::ceil(arc / h));
  const double layers = choice.grid ? cells_of(*choice.grid, 1) : layers_of(choice, default_value);
  const double sectors = sectors_of(choice, radius, h);
  MeshSize size = turned(size_of_shell(along, layers, {s.middle(0).r == 0, s.middle(1).r == 0}),
                         sectors, {along, layers});
  size.volume = solid;
  size.box = {2 * radius + thickest, 2 * radius + thickest, high - low + thickest};
  return planned(size,
                 [s = std::move(s), along, layers, sectors, given = grid_of(choice)]() mutable {
                   s.along = static_cast<int>(along);
                   s.layers = static_cast<int>(layers);
                   return turn(shell(s, pointer_to(given)), sectors);
                 });
}

ShapePlan disk(const Dimensions& d, const MeshChoice& choice) {
  const double r = d.at("diameter") / 2, t = d.at("thickness");
  const double patch = d.at("patch_diameter") / 2;
  Rectangles shape{.r = {0, r}, .z = {-t / 2, t / 2}, .solid = {{true}}};
  if (patch > 0) {
    require(patch < r, "disk", "a patch smaller than the disk");
    shape.r = {0, patch, r};
    shape.solid = {{true}, {true}};
    shape.singular_r = {1};
    shape.singular_z = {0};
  }
  return solid_of_revolution(shape, choice, std::max(2 * r, t));
}

ShapePlan hollow_disk(const Dimensions& d, const MeshChoice& choice) {
  const double r = d.at("diameter") / 2, t = d.at("thickness");
  const double c = d.at("cavity_diameter") / 2, g = d.at("cavity_thickness");
  require(c < r && g < t, "hollow_disk", "a cavity smaller than the disk");
  Rectangles shape{.r = {0, c, r},
                   .z = {-t / 2, -g / 2, g / 2, t / 2},
                   .solid = {{true, false, true}, {true, true, true}}};
  MeshChoice graded = choice;
  if (graded.h <= 0) // the layers at the edges add many elements
    graded.h = std::max(2 * r, t) / 14;
  return solid_of_revolution(shape, graded, std::max(2 * r, t));
}

ShapePlan tube_like(const char* label, double outer, double inner, double tall,
                    const MeshChoice& choice) {
  require(inner < outer, label, "an inner diameter below the outer one");
  return solid_of_revolution({.r = {inner, outer}, .z = {-tall / 2, tall / 2}, .solid = {{true}}},
                             choice, std::max(2 * outer, tall));
}

ShapePlan box(double x, double y, double z, const MeshChoice& choice) {
  const double h = element_size(choice, std::max({x, y, z})), thinnest = std::min({x, y, z});
  const auto min_divisions = [&](double size) {
    // Twisting bends a section's width; two elements would be one percent too stiff.
    const int across = choice.sparse ? 1 : choice.h > 0 ? 2 : 4;
    return size > thinnest ? across : static_cast<int>(layers_of(choice, 3));
  };
  const auto count = [&](std::size_t direction, double side) {
    return choice.grid ? cells_of(*choice.grid, direction)
                       : count_divisions({-side / 2, side / 2, h, min_divisions(side)});
  };
  const double nx = count(0, x), ny = count(1, y), nz = count(2, z);
  MeshSize size;
  size.elements = nx * ny * nz;
  const double corners = (nx + 1) * (ny + 1) * (nz + 1);
  const double edges =
      nx * (ny + 1) * (nz + 1) + (nx + 1) * ny * (nz + 1) + (nx + 1) * (ny + 1) * nz;
  size.nodes = corners + edges;
  // The shared faces, edges and corners are inside the box.
  const double faces = (nx - 1) * ny * nz + nx * (ny - 1) * nz + nx * ny * (nz - 1);
  const double lines =
      nx * (ny - 1) * (nz - 1) + (nx - 1) * ny * (nz - 1) + (nx - 1) * (ny - 1) * nz;
  size.node_pairs = 210 * size.elements - 36 * faces + 6 * lines - (nx - 1) * (ny - 1) * (nz - 1);
  size.skin_triangles = 12 * (nx * ny + ny * nz + nz * nx);
  size.cells = {nx, ny, nz};
  size.nodes_made = 2 * size.nodes; // number of entries of the lattice
  size.volume = x * y * z;
  size.box = {x, y, z};
  return planned(size, [=, min_divisions_x = min_divisions(x), min_divisions_y = min_divisions(y),
                        min_divisions_z = min_divisions(z), given = grid_of(choice)] {
    const auto cut = [h](double side, int divisions) {
      return divide({-side / 2, side / 2, h, divisions});
    };
    SweepGrid grid;
    grid.line =
        given ? given->line
              : std::array<std::vector<double>, 3>{cut(x, min_divisions_x), cut(y, min_divisions_y),
                                                   cut(z, min_divisions_z)};
    grid.kept = {{{-x / 2, x / 2}, {-y / 2, y / 2}, {-z / 2, z / 2}}};
    return SweptBody{block(grid.line[0], grid.line[1], grid.line[2]), std::move(grid)};
  });
}

ShapePlan bar(const Dimensions& d, const MeshChoice& choice) {
  const double l = d.at("length");
  if (d.at("diameter") > 0) {
    const double r = d.at("diameter") / 2;
    ShapePlan plan = solid_of_revolution({.r = {0, r}, .z = {-l / 2, l / 2}, .solid = {{true}}},
                                         choice, std::max(2 * r, l));
    plan.size.box = {l, 2 * r, 2 * r};
    plan.make = [upright = std::move(plan.make)] {
      SweptBody body = upright();
      for (Vec3& p : body.mesh.nodes) // along x
        p = {p.z, p.x, p.y};
      return body;
    };
    return plan;
  }
  return box(l, d.at("width"), d.at("thickness"), choice);
}

ShapePlan sphere(const Dimensions& d, const MeshChoice& choice) {
  const double radius = d.at("diameter") / 2, h = element_size(choice, 2 * radius);
  const int at_least = choice.sparse ? 1 : 2;
  return planned(size_of_ball(radius, h, at_least, choice.grid),
                 [radius, h, at_least, given = grid_of(choice)] {
                   return make_ball(radius, h, at_least, pointer_to(given));
                 });
}

ShapePlan hollow_sphere(const Dimensions& d, const MeshChoice& choice) {
  const double r = d.at("diameter") / 2, t = d.at("thickness");
  require(t < r, "hollow_sphere", "a thickness below the radius");
  const double m = r - t / 2;
  return shell_of_revolution(
      {.middle =
           [m](double u) {
             return Meridian{u == 0 || u == 1 ? 0 : m * std::sin(pi * u), -m * std::cos(pi * u)};
           },
       .thickness = [t](double) { return t; }},
      choice, 2 * r);
}

ShapePlan bowl(const Dimensions& d, const MeshChoice& choice) {
  const double r = d.at("diameter") / 2, t = d.at("thickness"), angle = d.at("angle") * pi / 180;
  require(t < r && angle > 0 && angle < pi, "bowl",
          "a thickness below the radius, 0 < angle < 180");
  const double m = r - t / 2;
  return shell_of_revolution(
      {.middle =
           [m, angle](double u) {
             return Meridian{u == 0 ? 0 : m * std::sin(angle * u), -m * std::cos(angle * u)};
           },
       .thickness = [t](double) { return t; }},
      choice, 2 * r);
}

ShapePlan bell(const std::vector<ProfilePoint>& profile, const MeshChoice& choice) {
  const Spline curve(profile);
  double largest = 0, low = profile[0].z, high = low;
  for (const ProfilePoint& p : profile) {
    largest = std::max(largest, 2 * p.r);
    low = std::min(low, p.z);
    high = std::max(high, p.z);
  }
  return shell_of_revolution({.middle =
                                  [curve, closed = profile[0].r == 0](double u) {
                                    const ProfilePoint p = curve.at(u);
                                    return Meridian{u == 0 && closed ? 0 : std::max(p.r, 0.0), p.z};
                                  },
                              .thickness = [curve](double u) { return curve.at(u).thickness; }},
                             choice, std::max(largest, high - low));
}

} // namespace

const std::vector<ShapeEntry>& known_shapes() {
  static const std::vector<ShapeEntry> shapes{
      {"disk",
       "a solid disk",
       {{"diameter", kRequired, ""},
        {"thickness", kRequired, ""},
        {"patch_diameter", 0,
         "a circle on the lower face with element edges along it, for a support"}}},
      {"hollow_disk",
       "a disk with a closed cavity in its middle",
       {{"diameter", kRequired, ""},
        {"thickness", kRequired, ""},
        {"cavity_diameter", kRequired, ""},
        {"cavity_thickness", kRequired, ""}}},
      {"ring",
       "a flat ring",
       {{"outer_diameter", kRequired, ""},
        {"inner_diameter", kRequired, ""},
        {"thickness", kRequired, ""}}},
      {"plate",
       "a rectangular plate",
       {{"length", kRequired, "along x"},
        {"width", kRequired, "along y"},
        {"thickness", kRequired, ""}}},
      {"bar",
       "a bar, rectangular or (with a diameter) round",
       {{"length", kRequired, "along x"},
        {"width", 0, "along y"},
        {"thickness", 0, "along z"},
        {"diameter", 0, "diameter of a round bar"}}},
      {"tube",
       "an open tube",
       {{"outer_diameter", kRequired, ""},
        {"inner_diameter", kRequired, ""},
        {"length", kRequired, ""}}},
      {"sphere", "a solid ball", {{"diameter", kRequired, ""}}},
      {"hollow_sphere",
       "a closed spherical shell",
       {{"diameter", kRequired, "outside"}, {"thickness", kRequired, ""}}},
      {"bowl",
       "an open spherical shell",
       {{"diameter", kRequired, "outer diameter of the sphere"},
        {"thickness", kRequired, ""},
        {"angle", 90, "angle from the bottom to the rim; 90 is a hemisphere", false}}},
      {"bell",
       "a shell of revolution from a file (--profile) of lines: radius height thickness",
       {}},
      {"board",
       "a thin plate, by default of wood with its grain along x",
       {{"length", kRequired, "along x"},
        {"width", kRequired, "along y"},
        {"thickness", kRequired, ""}}},
  };
  return shapes;
}

ShapePlan plan_shape(const std::string& name, const Dimensions& given,
                     const std::vector<ProfilePoint>& profile, const MeshChoice& choice) {
  const auto& shapes = known_shapes();
  const auto entry = std::find_if(shapes.begin(), shapes.end(),
                                  [&](const ShapeEntry& s) { return s.name == name; });
  if (entry == shapes.end())
    throw InputError("unknown shape " + name);
  Dimensions d;
  for (const Dimension& dimension : entry->dimensions) {
    const auto at = given.find(dimension.name);
    const double value = at != given.end() ? at->second : dimension.default_value;
    std::string option = dimension.name;
    std::replace(option.begin(), option.end(), '_', '-');
    if (std::isnan(value))
      throw InputError(name + " needs --" + option);
    if (!(value > 0) && at != given.end())
      throw InputError(name + ": " + option + " " + std::to_string(value) + ": expected above 0");
    d[dimension.name] = value;
  }
  for (const auto& [key, value] : given)
    if (!d.contains(key))
      throw InputError(name + " has no dimension " + key);
  if (name == "disk")
    return disk(d, choice);
  if (name == "hollow_disk")
    return hollow_disk(d, choice);
  if (name == "ring")
    return tube_like("ring", d["outer_diameter"] / 2, d["inner_diameter"] / 2, d["thickness"],
                     choice);
  if (name == "tube")
    return tube_like("tube", d["outer_diameter"] / 2, d["inner_diameter"] / 2, d["length"], choice);
  if (name == "sphere")
    return sphere(d, choice);
  if (name == "hollow_sphere")
    return hollow_sphere(d, choice);
  if (name == "bowl")
    return bowl(d, choice);
  if (name == "bell") {
    if (profile.empty())
      throw InputError("bell needs --profile FILE");
    return bell(profile, choice);
  }
  if (name == "bar") {
    if (!(d["diameter"] > 0 || (d["width"] > 0 && d["thickness"] > 0)))
      throw InputError("bar needs --diameter, or --width and --thickness");
    return bar(d, choice);
  }
  return box(d["length"], d["width"], d["thickness"], choice);
}

Mesh make_shape(const std::string& name, const Dimensions& given,
                const std::vector<ProfilePoint>& profile, const MeshChoice& choice) {
  return plan_shape(name, given, profile, choice).make().mesh;
}

std::vector<ProfilePoint> read_profile(const std::string& path, double unit) {
  std::istringstream file(read_bytes(path, std::uint64_t{1} << 20));
  std::vector<ProfilePoint> points;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    std::string a, b, c, more;
    if (!(words >> a))
      continue;
    words >> b >> c;
    const auto r = to_number(a), z = to_number(b), t = to_number(c);
    if (!r || !z || !t || words >> more || *r < 0 || !(*t > 0))
      throw InputError(path + " line " + std::to_string(number) + ": " + printable(line, 60) +
                       ", expected radius >= 0, height and thickness > 0");
    points.push_back({unit * *r, unit * *z, unit * *t});
  }
  if (points.size() < 2)
    throw InputError(path + " has " + std::to_string(points.size()) +
                     " points, expected two or more");
  return points;
}

} // namespace tactus::fem
