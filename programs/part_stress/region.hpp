#pragma once
#include "fem/statics/selection.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// A region of the body, as given on the command line.
struct Region {
  std::string words;
  Selection selection;
};

/// Reads the region from the first of `parts`, the words between colons, and removes these:
///
///   x=LEVEL                          nodes and faces on a plane across x, y or z
///   plane:X,Y,Z,NX,NY,NZ             on the plane through a point with a normal
///   box:X1,Y1,Z1,X2,Y2,Z2            in a box
///   cylinder:X1,Y1,Z1,X2,Y2,Z2,R     on the wall of a cylinder, the wall of a hole
///   sphere:X,Y,Z,R                   on a sphere
///   X,Y,Z,R                          in a ball
///   set:NAME                         a set of nodes that the mesh names
///   face:N                           a face of a CAD file, by its number
///
/// Lengths are in units of `unit` metres. `option` is named in errors.
[[nodiscard]] Region read_region(const std::string& option, std::vector<std::string>& parts,
                                 double unit);

/// Reads numbers between commas, each multiplied by `scale`. Refuses another count.
[[nodiscard]] std::vector<double> read_numbers(const std::string& option, const std::string& cells,
                                               std::size_t count, double scale);
[[nodiscard]] Vec3 read_vector(const std::string& option, const std::string& cells,
                               double scale = 1);

/// The help text about regions.
[[nodiscard]] std::string usage_of_regions();

} // namespace tactus::fem
