#pragma once
#include <functional>
#include <span>
#include <vector>

namespace tactus::fem {

/// Orders of convergence. The error of a frequency is proportional to h^4 in an element of size h.
/// In an element at a singular edge it is proportional to h^(2a), a = 0.544 at an inner angle of
/// 270 degrees (Strang & Fix 1973, chapter 8).
inline constexpr double kSmoothOrder = 4, kSingularOrder = 1.1;

/// Limits of the factor by which a refinement may change the size of an element.
struct FactorLimits {
  double finest = 1.0 / 16, coarsest = 1;
};

/// Cells (elements, or intervals of a grid) with their contributions to each mode's relative error
/// and the order in which these scale with the cell's size.
struct ErrorCells {
  std::vector<std::vector<double>> share; ///< [mode][cell]
  std::vector<double> order;              ///< [cell]
};

/// Factors on the sizes of cells after which every mode's predicted error, sum_i share[k][i]
/// factor_i^order_i, is at most `target`. `rule(error, pressure)` returns the factors that satisfy
/// Lagrange's conditions, given one error per cell and a multiplier; a larger multiplier makes the
/// factors smaller. The multiplier is found by bisection. The modes' errors are weighted. A mode's
/// weight rises while its predicted error exceeds that of the other modes.
using FactorRule =
    std::function<std::vector<double>(std::span<const double> error, double pressure)>;
[[nodiscard]] std::vector<double> balanced_factors(const ErrorCells&, double target,
                                                   const FactorLimits&, const FactorRule& rule,
                                                   int rounds);

} // namespace tactus::fem
