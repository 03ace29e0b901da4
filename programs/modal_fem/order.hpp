#pragma once
#include "fem/assembly/matrices.hpp"
#include "fem/shapes/shapes.hpp"
#include "programs/modal_fem/shape.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// Where a support or spring acts, in metres.
struct Place {
  std::string words; ///< as given
  std::string set;   ///< a named node set of the mesh file, or empty
  Vector3 centre;    ///< of a ball of `radius` around a point of the skin
  double radius = 0;
  int plane = -1; ///< or a plane x, y, z = level
  double level = 0;
  std::array<bool, 3> directions{true, true, true};
  double stiffness = 0;
};

/// What the command line asks for.
struct Order {
  std::string body; ///< a shape's name or a file
  bool is_file = false;
  std::map<std::string, double> dimensions; ///< m
  std::string profile;
  double unit = 1e-3;
  bool unit_given = false;
  MeshChoice choice;
  std::vector<std::pair<std::string, std::string>> materials; ///< region (or "") and name
  std::map<std::string, double> changes;                      ///< young, poisson, density, loss
  std::vector<double> axes;
  std::vector<Place> places;
  std::size_t modes = 40;
  double tolerance = .002; ///< largest error of a frequency; 0: the first mesh stays
  bool tolerance_given = false;
  bool several_parts = false, quiet = false, straight = false, remesh = false;
  std::string part; ///< the one to take of a file's separate parts
  int threads = 1;
  bool slepc = false;         ///< solve with SLEPc on `ranks` processes
  int ranks = 0;              ///< 0: not given
  double time_limit_s = 1200; ///< without progress, for reading and meshing a file
  double memory_bytes = 0;    ///< 0: half of what is free
  double fillet = 0;          ///< m
  double shrink_wrap = 0;     ///< m; below 0: the gap is chosen; 0: no wrap
  bool residual = false;      ///< also what the modes left out would yield
  bool radiation = false;
  std::size_t acoustic_triangles = 2000;
  ShapeOrder shape;              ///< control points that the frequencies follow
  std::vector<double> ratios{1}; ///< of frequency, at which radiation is tabulated
  double air_density = 1.184, sound_speed = 346.1; ///< air at 25 degrees
  std::string output, csv, vtu, sheet, inp, petsc, import_values, import_vectors;
};

/// Refuses what it does not understand. Lengths are in `--unit`.
[[nodiscard]] Order read_order(const std::vector<std::string>& words);

/// The help text.
[[nodiscard]] std::string usage();

} // namespace tactus::fem
