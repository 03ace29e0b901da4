#pragma once
#include "core/dsp/complex.hpp"
#include "fem/radiation/acoustic_skin.hpp"
#include "fem/radiation/panel_pairs.hpp"

namespace tactus::fem {

/// The air around a vibrating closed surface, exp(+j omega t). Outside,
///
///   p(x) = ∫ mu(y) (dG/dn_y + eta G) dS,   G = exp(-j k R)/(4 pi R),   eta = j k,
///
/// a combined layer (Brakhage & Werner 1965), which has one solution at every frequency. Each of
/// its layers alone fails at the resonances of the enclosed space. mu is continuous and linear on
/// the triangles and satisfies Galerkin's equations
///
///   <H mu, phi_i> + eta <(D' - 1/2) mu, phi_i> = -j omega rho <v_n, phi_i>,
///   <H mu, phi> = -∫∫ G (curl mu . curl phi - k^2 n.n' mu phi) dS dS'   (Maue 1949).
///
/// Integrals with 1/R of neighbours are closed forms inside and Gauss points outside; they do not
/// depend on the frequency and are kept.
class ExteriorField {
public:
  explicit ExteriorField(AcousticSkin);

  [[nodiscard]] std::size_t unknowns() const noexcept { return skin_.vertex.size(); }
  [[nodiscard]] const AcousticSkin& skin() const noexcept { return skin_; }
  [[nodiscard]] const std::vector<Panel>& panels() const noexcept { return panels_; }
  /// Memory of one solution's matrix, bytes.
  [[nodiscard]] double memory_bytes() const noexcept;

  /// `flow`: columns of ∫ v_n phi_i dS, m^3/s. Returns the columns of mu at wavenumber `k`, 1/m.
  /// Refuses a singular matrix.
  [[nodiscard]] std::vector<Complex> solve(double k, std::span<const double> flow,
                                           std::size_t columns, double air_density,
                                           double sound_speed) const;

  /// Pressure at a point outside that is farther away than a triangle's size.
  [[nodiscard]] Complex pressure(double k, std::span<const Complex> mu, const Vec3& x) const;

private:
  struct Neighbours { ///< a pair of close panels (first <= second), integrated in closed form
    int second;
    std::array<double, 9> potential, slope, slope_back;
  };
  void prepare_neighbours();
  /// The pairs of panel t with the panels first ... last - 1; `close` advances to the position of
  /// `last` in near_[t].
  void integrate_pairs(std::size_t t, std::size_t first, std::size_t last, double k,
                       std::vector<Neighbours>::const_iterator& close, PanelPairs&) const;
  /// Galerkin's matrix at a wavenumber, 1/m, column-major.
  [[nodiscard]] std::vector<Complex> matrix(double k) const;

  AcousticSkin skin_;
  std::vector<Panel> panels_;
  PanelArrays arrays_{{}};                    ///< the same panels as arrays
  std::vector<std::vector<Neighbours>> near_; ///< indexed by first panel, ascending by second
};

} // namespace tactus::fem
