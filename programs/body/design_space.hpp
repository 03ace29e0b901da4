#pragma once
#include "fem/design/lattice.hpp"
#include "programs/body/body_options.hpp"

#include <optional>

namespace tactus::fem {

/// The lattice of control points that changes the body's shape, from the command line.
struct DesignOptions {
  bool requested = false; ///< an option of the lattice was given
  std::optional<Box> box; ///< m; if empty, the body's
  std::array<int, 3> points{3, 3, 3};
  std::array<int, 3> degree{}; ///< 0 for 3, or for one less than the points if that is less
  std::vector<int> controls;   ///< points that may move; if empty, all that keep the body whole
  std::array<bool, 3> directions{true, true, true};
  double range = 0; ///< m, for each coordinate both ways; 0 for half the lattice's spacing
  double trust = 0; ///< m; 0 for a tenth of the lattice's shortest side

  /// Reads the reader's present option if it belongs to the lattice; returns false for any other
  /// option. Refuses values that are not valid.
  bool take(BodyReader& reader);
};

/// Reads directions such as xy. Refuses other letters and an empty text.
[[nodiscard]] std::array<bool, 3> read_directions(const std::string& option,
                                                  const std::string& word);

/// The possible changes of the body's shape.
struct DesignSpace {
  Lattice lattice;
  ControlWeights weights;
  std::vector<int> controls; ///< movable control points
  std::vector<ParameterRange> parameters;
  std::vector<DesignVelocity> velocities; ///< one for each parameter
  double trust = 0;                       ///< m

  /// Refuses parameters beyond their bounds or not finite, naming the control point.
  void check_within_bounds(std::span<const double> values) const;
};

/// The control lattice around the body or in its box. If the body passes through a face of the box,
/// the control points on that face are fixed, so that the body stays in one piece. Control points
/// that move no node are fixed too. Bounds are reduced if moving one coordinate alone to its bound
/// would invert an element.
[[nodiscard]] DesignSpace design_space_of(const DesignOptions&, const Mesh&);

/// Help text of the options that DesignOptions::take() knows.
[[nodiscard]] std::string usage_of_lattice();

} // namespace tactus::fem
