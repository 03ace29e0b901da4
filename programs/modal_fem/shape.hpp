#pragma once
#include "fem/design/lattice.hpp"
#include "fem/io/modal_table.hpp"
#include "programs/body/progress.hpp"

#include <functional>
#include <optional>
#include <string>

namespace tactus::fem {

/// The control lattice whose points shape the body, as the command line gives it.
struct ShapeOrder {
  bool wanted = false;    ///< an option of the lattice was given
  std::optional<Box> box; ///< m; none: the body's
  std::array<int, 3> points{3, 3, 3};
  std::array<int, 3> degree{}; ///< 0: 3, or one less than the points
  std::vector<int> controls;   ///< that may move; empty: all that keep the body whole
  std::array<bool, 3> directions{true, true, true};
  double range = 0; ///< m; 0: half a spacing
  double trust = 0; ///< m; 0: a tenth of the lattice's shortest side

  /// Reads an option of the lattice; false for any other. `value` gives the next word, lengths are
  /// times `unit`. Refuses what it does not understand.
  bool take(const std::string& option, const std::function<const std::string&()>& value,
            double unit);
};

/// Modes found beyond those that are asked for, so that no group of equal frequency is cut off.
inline constexpr std::size_t kModesBeyond = 4;

/// Derivatives of the first `count` squared frequencies with respect to the control points. Points
/// on a face of the box that the body passes through stay, so that it stays in one piece, and so do
/// those that move nothing. Bounds are cut where a coordinate alone would spoil an element.
[[nodiscard]] ShapeDerivatives shape_derivatives(const ShapeOrder&, const Mesh&,
                                                 std::span<const Material>, const Modes&,
                                                 std::size_t count, ProgressLine&);

} // namespace tactus::fem
