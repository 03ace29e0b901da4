#pragma once
#include "fem/assembly/matrices.hpp"

namespace tactus::fem {

/// A link from a mode of one solution to a mode of another. The new modal coordinates are z_now =
/// sum of share z_before.
struct ModeMatch {
  std::size_t before = 0, now = 0;
  double share = 0;
};

/// Finds which modes of a new shape correspond to those of an earlier one, by the modal assurance
/// criterion with the new mass matrix (Allemang 2003),
///
///   MAC_ji = c_ji^2,   c_ji = phi_j' M phi_i / sqrt((phi_j' M phi_j) (phi_i' M phi_i)),
///
/// with phi_i before and phi_j now. Modes with MAC >= 0.1 are linked. In each set of linked modes
/// the shares are U V' of c = U S V', without the directions with S^2 < 0.5. This is the partial
/// isometry nearest to c, so no motion gains energy. A mode whose shape is unchanged has the share
/// +-1, whatever its number. Modes of nearly equal frequency that have mixed are rotated into each
/// other. A mode without a counterpart has no share. The arguments are columns of dofs() numbers,
/// each mass-normalised in its own shape.
[[nodiscard]] std::vector<ModeMatch> match_modes(const Matrices& matrices_now,
                                                 std::span<const double> before,
                                                 std::span<const double> now);

} // namespace tactus::fem
