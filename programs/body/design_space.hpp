#pragma once
#include "fem/design/lattice.hpp"
#include "programs/body/body_options.hpp"

#include <optional>

namespace tactus::fem {

/// The lattice of control points that changes the body's shape, from the command line.
struct DesignOptions {
  bool requested = false; ///< an option of the lattice was given
  std::optional<Box> box; ///< m; none: the body's
  std::array<int, 3> points{3, 3, 3};
  std::array<int, 3> degree{}; ///< 0: 3, or one less than the points where they are fewer
  std::vector<int> controls;   ///< that may move; empty: all that keep the body in one piece
  std::array<bool, 3> directions{true, true, true};
  double range = 0; ///< m, of each coordinate both ways; 0: half the lattice's spacing
  double trust = 0; ///< m; 0: a tenth of the lattice's shortest side

  /// Reads the reader's present option if it is one of the lattice; false for any other. Refuses
  /// what it does not understand.
  bool take(BodyReader& reader);
};

/// Directions such as xy. Refuses other letters, and none.
[[nodiscard]] std::array<bool, 3> read_directions(const std::string& option,
                                                  const std::string& word);

/// The possible changes of the body's shape.
struct DesignSpace {
  Lattice lattice;
  ControlWeights weights;
  std::vector<int> controls; ///< movable control points
  std::vector<ParameterRange> parameters;
  std::vector<DesignVelocity> velocities; ///< of the parameters
  double trust = 0;                       ///< m

  /// Refuses parameters beyond their bounds or not finite, naming the control point.
  void check_within_bounds(std::span<const double> values) const;
};

/// The control lattice around the body or in its box. Control points of a face of the box that the
/// body passes through stay, so that the body stays in one piece; so do those that move no node.
/// Bounds are cut where a coordinate alone would turn an element inside out.
[[nodiscard]] DesignSpace design_space_of(const DesignOptions&, const Mesh&);

/// Help text of the options that DesignOptions::take() knows.
[[nodiscard]] std::string usage_of_lattice();

} // namespace tactus::fem
