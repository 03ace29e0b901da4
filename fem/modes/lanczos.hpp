#pragma once
#include "fem/modes/shifted_factor.hpp"

namespace tactus::fem {

/// Number of vectors solved for at once.
inline constexpr std::size_t kLanczosBlock = 8;

/// Eigenpairs of K u = lambda M u, lambda ascending.
struct Spectrum {
  std::vector<double> lambda;  ///< rad^2/s^2
  std::vector<double> vectors; ///< columns, M-orthonormal
  std::size_t solves = 0;      ///< right-hand sides solved
};

struct LanczosSettings {
  std::size_t count = 0;
  double tolerance = 1e-8; ///< limit of ||K u - lambda M u|| relative to lambda ||M u||
  Progress progress{};
};

/// The `count` lowest eigenpairs M-orthogonal to `deflated` (M-orthonormal columns), by block
/// Lanczos on (K + s M)^-1 M with full orthogonalisation and thick restarts: Golub & Underwood
/// 1977; Grimes, Lewis & Simon 1994; Wu & Simon 2000. A pair counts as found if its residual,
/// relative to its eigenvalue, is below `tolerance`. The error of its frequency is then about the
/// square of that. Blocks of b vectors find eigenvalues of multiplicity up to b. The start vectors
/// are always the same.
[[nodiscard]] Spectrum lowest_modes(const Matrices&, ShiftedFactor&, double shift,
                                    std::span<const double> deflated, const LanczosSettings&);

} // namespace tactus::fem
