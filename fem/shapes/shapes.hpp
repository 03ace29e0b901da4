#pragma once
#include "fem/mesh/mesh.hpp"
#include "fem/mesh/mesh_size.hpp"
#include "fem/shapes/grid.hpp"

#include <functional>
#include <map>
#include <string>

namespace tactus::fem {

/// A dimension of a shape, as the user names it, in millimetres unless `unit` says otherwise.
struct Dimension {
  const char* name;
  double default_value; ///< NaN if it must be given
  const char* description;
  bool is_length = true;
};

struct ShapeEntry {
  const char* name;
  const char* description;
  std::vector<Dimension> dimensions;
};

/// The shapes disk, hollow_disk, ring, plate, bar, tube, sphere, hollow_sphere, bowl, bell and
/// board.
[[nodiscard]] const std::vector<ShapeEntry>& known_shapes();

struct MeshChoice {
  double h = 0; ///< element size, m; 0 for the largest dimension / 16, / 14 if graded, / 28 for
                ///< shells
  int layers =
      0; ///< elements through the smallest thickness; 0 for at least three, one or two for shells
  bool grade_concave = true;
  bool sparse = false;             ///< only the elements that h requires, one through a wall
  const SweepGrid* grid = nullptr; ///< if given, its lines replace the division
};

/// A point of a bell's profile. A profile file has lines `radius height thickness` in `unit`
/// metres, from crown to lip; # begins a comment.
struct ProfilePoint {
  double r, z, thickness;
};
[[nodiscard]] std::vector<ProfilePoint> read_profile(const std::string& path, double unit);

/// A swept mesh and the grid that divides it.
struct SweptBody {
  Mesh mesh;
  SweepGrid grid;
};

/// A shape's mesh before it is made: its size and the function that makes it.
struct ShapePlan {
  MeshSize size;
  std::function<SweptBody()> make;
};

/// Plans the swept mesh (hex20, wedge15) of a named shape; dimensions are in metres, angles in
/// degrees. Bodies of revolution have their axis along z and their middle at the origin, plates lie
/// in x y, bars along x. Refuses impossible dimensions. Elements and nodes are counted exactly,
/// with almost no time and memory, whatever the element size.
[[nodiscard]] ShapePlan plan_shape(const std::string& name,
                                   const std::map<std::string, double>& dimensions,
                                   const std::vector<ProfilePoint>& profile, const MeshChoice&);

/// Makes the planned mesh, without its grid. Refuses more nodes than an int can number.
[[nodiscard]] Mesh make_shape(const std::string& name,
                              const std::map<std::string, double>& dimensions,
                              const std::vector<ProfilePoint>& profile, const MeshChoice&);

} // namespace tactus::fem
