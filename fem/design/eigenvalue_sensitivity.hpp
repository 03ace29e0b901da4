#pragma once
#include "fem/design/sensitivity.hpp"

namespace tactus::fem {

/// Modes to be differentiated, followed by further ones.
struct GivenModes {
  std::span<const double> frequency_hz; ///< ascending
  std::span<const double> shapes;       ///< columns of dofs() numbers, mass-normalised, as in Modes
  std::size_t count;                    ///< number of leading modes to differentiate
  double same = 1e-3; ///< relative distance of frequencies below which they are one eigenvalue
};

/// Derivatives d(omega^2)/dp = phi' (K' - omega^2 M') phi of mass-normalised modes (Fox & Kapoor
/// 1968), rad^2/s^2 per unit of the parameter, [parameter][mode]. K' and M' are the material
/// derivatives of the element integrals; constrained directions stay constrained, and springs move
/// with their faces.
///
/// Modes closer than `same` (relative, in frequency) count as one eigenvalue of that multiplicity.
/// Its derivatives are the eigenvalues, ascending, of the matrix phi_i' (K' - omega^2 M') phi_j
/// over the group (Seyranian, Lund & Olhoff 1994). They are directional: valid for a change of this
/// parameter only, and not additive over parameters.
///
/// Returns the derivatives of the first `count` of the given modes. Refuses if the group of the
/// last of these modes reaches the end of the given modes, since members of the group may be
/// missing. So pass at least one further mode. `springs` are those in the matrices of the modes.
[[nodiscard]] std::vector<double> eigenvalue_sensitivity(const Mesh&, std::span<const Material>,
                                                         std::span<const SpringPatch> springs,
                                                         const GivenModes&,
                                                         std::span<const DesignVelocity>);

} // namespace tactus::fem
