#pragma once
#include "fem/radiation/panel.hpp"

#include <span>
#include <vector>

namespace tactus::fem {

/// cos x and sin x for 0 <= x < 1e6, absolute error below 2e-15. It has no branches or calls, so a
/// compiler vectorises loops over it, unlike loops over the C library's functions.
inline void cosine_and_sine(double x, double& cosine, double& sine) noexcept {
  constexpr double kToNearest = 6755399441055744.0; // 1.5 2^52; adding it rounds to an integer
  constexpr double kTurnHigh = 6.2831853069365025;  // upper 32 bits of 2 pi, and the rest
  constexpr double kTurnLow = 2.430840202602477e-10;
  const double turns = (x * .15915494309189535 + kToNearest) - kToNearest;
  const double h = .25 * ((x - turns * kTurnHigh) - turns * kTurnLow), hh = h * h;
  // Taylor's series on [-pi/4, pi/4], then the angle is doubled twice.
  double s = 1 / 6227020800. - hh / 1307674368e3;
  s = 1 / 362880. + hh * (-1 / 39916800. + hh * s);
  s = h * (1 + hh * (-1 / 6. + hh * (1 / 120. + hh * (-1 / 5040. + hh * s))));
  double c = -1 / 87178291200. + hh / 20922789888e3;
  c = 1 / 40320. + hh * (-1 / 3628800. + hh * (1 / 479001600. + hh * c));
  c = 1 + hh * (-.5 + hh * (1 / 24. + hh * (-1 / 720. + hh * c)));
  const double s2 = 2 * s * c, c2 = 1 - 2 * s * s;
  sine = 2 * s2 * c2;
  cosine = 1 - 2 * s2 * s2;
}

/// Panels as one array per component, for loops over many panels.
struct PanelArrays {
  using Vectors = std::array<std::vector<double>, 3>; ///< [axis][panel]
  std::array<Vectors, 3> point, curl;
  Vectors normal;
  std::vector<double> area;

  explicit PanelArrays(std::span<const Panel>);
};

/// Integrals of one panel's hat functions a with the hat functions b of up to kSize others.
struct PanelPairs {
  static constexpr std::size_t kSize = 64;
  struct alignas(64) Lane : std::array<double, kSize> {}; ///< a value for each of the others
  struct Integrals {
    std::array<Lane, 9> re, im; ///< [3 a + b]
  };
  /// ∫∫ phi_a G phi_b dS dS', and with dG/dn of the first panel and of the second. Each panel has
  /// three points. The integrand is G minus 1/(4 pi R) where `near` is 1, and G where it is 0.
  Integrals value, slope, slope_back;
  Lane near;

  /// Fills the integrals with the panels first ... first + count - 1 at wavenumber k, 1/m.
  void integrate(const Panel&, const PanelArrays&, std::size_t first, std::size_t count, double k);

  /// Computes from the integrals the contributions of the pairs to Galerkin's matrix
  /// (ExteriorField). `there` is in the row of a and the column of b, `back` in the row of b and
  /// the column of a.
  void to_galerkin(const Panel&, const PanelArrays&, std::size_t first, std::size_t count, double k,
                   Integrals& there, Integrals& back) const;
};

} // namespace tactus::fem
