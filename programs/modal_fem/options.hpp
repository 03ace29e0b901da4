#pragma once
#include "fem/assembly/matrices.hpp"
#include "programs/body/design_space.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// The region on which a support or spring acts, in metres.
struct FixedRegion {
  std::string words; ///< as the user wrote them
  std::string set;   ///< a named node set of the mesh file, or empty
  Vec3 centre;       ///< centre of a ball of `radius` around a point of the skin
  double radius = 0;
  int plane = -1; ///< or a plane x, y, z = level
  double level = 0;
  std::array<bool, 3> directions{true, true, true};
  double stiffness = 0;
};

/// The options of the command line.
struct ModalOptions : BodyOptions {
  std::vector<FixedRegion> fixed_regions;
  std::size_t modes = 40;
  double tolerance = .002; ///< largest error of a frequency; 0 for no refinement
  bool tolerance_given = false;
  bool slepc = false;    ///< solve with SLEPc on `ranks` processes
  int ranks = 0;         ///< 0 if not given
  bool residual = false; ///< also compute the static compliance of the omitted modes
  bool radiation = false;
  std::size_t acoustic_triangles = 2000;
  DesignOptions design;          ///< control points for the frequencies' derivatives
  std::vector<double> ratios{1}; ///< multiples of frequency at which radiation is tabulated
  double air_density = 1.184, sound_speed = 346.1;       ///< air at 25 degrees
  std::string csv, petsc, import_values, import_vectors; ///< paths
};

/// Reads the command line. Refuses unknown options and values. Lengths are in `--unit`.
[[nodiscard]] ModalOptions read_options(const std::vector<std::string>& words);

/// The help text.
[[nodiscard]] std::string usage();

} // namespace tactus::fem
