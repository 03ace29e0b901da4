#pragma once
#include "fem/design/lattice.hpp"
#include "fem/statics/statics.hpp"

namespace tactus::fem {

/// The equivalent stress: the scalar formed from a stress tensor.
enum class StressMeasure : std::uint8_t { von_mises, max_shear };

/// Equivalent stress of each element from its stress at the centroid, Pa.
[[nodiscard]] std::vector<double> equivalent_stress(std::span<const Stress>, StressMeasure);

/// Derivatives of both equivalent stresses by the design parameters.
struct StressSensitivity {
  std::vector<float> von_mises; ///< [parameter][element], Pa per unit of the parameter
  std::vector<float> max_shear; ///< as von_mises
};

/// du/dp by the direct method, one back-substitution per parameter:
///   K du/dp = f' - K' u.
/// K' u is the material derivative of the element integrals (Choi & Kim, Structural Sensitivity
/// Analysis and Optimization 1, ch. 6), exact at the quadrature points: with the design velocity V
/// = dX/dp and its gradient L = grad V, (grad N)' = -L^T grad N and (dV)' = tr L dV. Loads on faces
/// and springs are differentiated by central differences of their small vectors, so the whole is
/// semi-analytic. Returns m per unit of the parameter, [parameter][dof].
[[nodiscard]] std::vector<double> displacement_sensitivity(const Mesh&, const StaticModel&,
                                                           StaticAnalysis&,
                                                           std::span<const DesignVelocity>);

/// Derivatives of both equivalent stresses in every element, from d sigma = C sym(grad du - grad u
/// L). Computes eight parameters at a time, so that du/dp of all parameters is never in memory at
/// once.
[[nodiscard]] StressSensitivity stress_sensitivity(const Mesh&, const StaticModel&, StaticAnalysis&,
                                                   std::span<const DesignVelocity>,
                                                   const Progress& = {});

/// A scalar of the whole stress field, with the measure s at the centroids.
struct StressScalar {
  enum class Kind : std::uint8_t {
    mean,        ///< (1/N) sum s
    volume_mean, ///< sum V s / sum V
    p_norm       ///< (sum V s^p / sum V)^(1/p): a smooth approximation of the maximum
  };
  Kind kind = Kind::volume_mean;
  StressMeasure measure = StressMeasure::von_mises;
  double power = 8; ///< p of p_norm
};

/// A scalar with its derivatives by the design parameters.
struct Gradient {
  double value = 0;
  std::vector<double> by_parameter;
};

/// The scalar (Pa) and its gradient by the adjoint method: one back-substitution, whatever the
/// number of parameters.
[[nodiscard]] Gradient stress_scalar(const Mesh&, const StaticModel&, StaticAnalysis&,
                                     const StressScalar&, std::span<const DesignVelocity>);

/// The volume of the body, m^3, and its gradient.
[[nodiscard]] Gradient volume_gradient(const Mesh&, std::span<const DesignVelocity>);

} // namespace tactus::fem
