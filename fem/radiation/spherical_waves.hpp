#pragma once
#include "fem/radiation/exterior_field.hpp"

namespace tactus::fem {

/// j_0(x) ... j_highest(x), by downward recursion (Miller).
[[nodiscard]] std::vector<double> spherical_bessel(std::size_t highest, double x);
/// h_0(x) ... h_highest(x) of the second kind, j - j y: outgoing for exp(+j omega t).
[[nodiscard]] std::vector<Complex> spherical_hankel(std::size_t highest, double x);
/// Regular waves psi_lm = j_l(k r) Y_lm(direction) at a point and their slopes n . grad psi_lm, for
/// l up to a highest degree and m >= 0; psi_l,-m = (-1)^m conj(psi_lm). Y_lm is complex and
/// orthonormal with Condon and Shortley's phase, polar axis z. The roots of the recurrences are
/// tabulated:
///   cos Y_lm = A_lm Y_l-1,m + A_l+1,m Y_l+1,m,   A_lm = sqrt((l^2 - m^2)/(4 l^2 - 1)),
///   (d/dx + j d/dy) psi_lm = k (B_l+1,m+1 psi_l+1,m+1 + B_l,-m psi_l-1,m+1),
///   d/dz psi_lm = k (A_lm psi_l-1,m - A_l+1,m psi_l+1,m),
///   B_lm = sqrt((l + m)(l + m - 1)/(4 l^2 - 1)).
class RegularWaves {
public:
  explicit RegularWaves(std::size_t highest);
  /// Length of one plane: for each degree a row m = 0 ... l, padded to a multiple of the vector
  /// width.
  [[nodiscard]] std::size_t size() const noexcept { return start_.back(); }
  /// Start of the row of degree l in a plane.
  [[nodiscard]] std::size_t start(std::size_t l) const noexcept { return start_[l]; }
  /// The real and imaginary parts of psi (no unit) and of the slopes (1/m), a plane each.
  struct Planes {
    std::span<double> psi, psi_j, slope, slope_j;
  };
  /// Fills the planes at `x` in m from the centre; k in 1/m, n of length 1.
  void evaluate(double k, const Vec3& x, const Vec3& n, const Planes&);

private:
  /// psi of one degree, indexed by m from -1 on.
  struct Row {
    std::vector<double> legendre, re, im;
  };
  void next_row(std::size_t l, double cosine, double bessel, double diagonal);
  void write(std::size_t l, double k, const Vec3& n, const Planes&) const;
  [[nodiscard]] std::size_t at(std::size_t l) const noexcept { return l * width_ + kBefore; }

  static constexpr std::size_t kBefore = 8; ///< numbers in a row before m = 0, one whole vector
  std::size_t highest_, width_;
  std::vector<std::size_t> start_;
  // By degree and m: A_lm, 1/A_lm, B_lm, B_l,-m; zero where they are not used.
  std::vector<double> along_, inverse_, across_, across_back_;
  std::vector<double> turn_, turn_j_; ///< exp(j m azimuth)
  std::array<Row, 4> rows_;           ///< rows of the last degrees, indexed by degree modulo 4
};

/// Outgoing waves about `centre` of the field of each column of mu (unknowns() numbers a column):
///   p = sum c_lm h_l(k r)/h_l(k r_ref) Y_lm for r beyond the surface. Each term is exact, from
///   G = -j k sum h_l(k r) j_l(k r') Y_lm Y'*_lm.
[[nodiscard]] std::vector<Complex> multipoles(const ExteriorField&, double k,
                                              std::span<const Complex> mu, std::size_t highest,
                                              const Vec3& centre, double reference_radius);

/// Mean power of outgoing waves, W: sum |c_lm / h_l(k r_ref)|^2 / (2 rho c k^2).
[[nodiscard]] double radiated_power(std::span<const Complex> coefficients, double k,
                                    double reference_radius, double air_density,
                                    double sound_speed);

} // namespace tactus::fem
