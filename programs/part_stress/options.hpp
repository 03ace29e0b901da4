#pragma once
#include "fem/shapes/lift_arm.hpp"
#include "programs/body/design_space.hpp"
#include "programs/body/output_files.hpp"
#include "programs/part_stress/region.hpp"

namespace tactus::fem {

/// A support: nodes fixed in some directions, or an elastic foundation of faces.
struct SupportOptions {
  std::string words;
  Region at_region;
  std::array<bool, 3> directions{true, true, true};
  Vec3 stiffness_n_per_m{}; ///< if zero, the nodes are fixed
};

struct LoadOptions {
  enum class Kind : std::uint8_t { force, traction, pressure, bolt, point };
  Kind kind;
  std::string words;
  Region at_region; ///< unused for a point
  Vec3 point;       ///< m
  Vec3 value;       ///< N or Pa; a pressure is in x
};

/// A control point and its displacement, m.
struct Move {
  int control = 0;
  Vec3 displacement;
};

/// The options of the command line.
struct PartOptions : BodyOptions {
  std::vector<SupportOptions> supports;
  std::vector<LoadOptions> loads;
  Vec3 gravity; ///< m/s^2

  DesignOptions design; ///< the control points
  double skin_edge = 0; ///< m; 0 for the mesh's own skin in the table
  std::vector<Move> moves;

  bool petsc = false; ///< solve with PETSc on `ranks` processes
  int ranks = 0;      ///< 2 unless given

  bool list_faces = false;
  std::string step; ///< path

  /// The dimensions of the shape lift_arm. Refuses as check() does.
  [[nodiscard]] LiftArm lift_arm() const;
  [[nodiscard]] bool is_lift_arm() const { return !is_file && body == "lift_arm"; }
  [[nodiscard]] bool needs_faces() const; ///< true if a region is the number of a CAD face
  [[nodiscard]] std::vector<Output> outputs() const;
};

/// Reads the command line. Refuses unknown options and values. Lengths are in `--unit`.
[[nodiscard]] PartOptions read_options(const std::vector<std::string>& words);

/// The help text.
[[nodiscard]] std::string usage();

} // namespace tactus::fem
