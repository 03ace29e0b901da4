#pragma once

#include "core/geometry/vec3.hpp"
#include "core/modal/table/shape_sensitivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactus::modal {

/// The elastic constants of wood and the like by the directions 1 2 3 (longitudinal, radial,
/// tangential); nu_ij: strain in j for stress along i.
struct Orthotropy {
  std::array<double, 3> youngs_modulus_pa{}, shear_modulus_pa{}, poisson{}; ///< pairs 23 13 12
  Vec3 axis_1{1, 0, 0}, axis_2{0, 1, 0}; ///< direction 2 lies in the plane of these two axes

  /// True if no deformation releases energy, and the axes span a plane.
  [[nodiscard]] bool possible() const noexcept;
  /// Young's modulus of a bar cut along a direction of length 1 (Lekhnitskii):
  /// 1/E = sum of l_i^4/E_i + sum of (1/G_ij - 2 nu_ij/E_i) l_i^2 l_j^2.
  [[nodiscard]] double modulus_along(const Vec3& direction) const noexcept;
};

/// The material to which the frequencies of a table belong.
struct Material {
  std::string name;
  double youngs_modulus_pa = 0; ///< modulus along direction 1; 0: not in the table
  double poisson = 0.3;
  double density_kg_per_m3 = 0; ///< 0: not in the table
  std::optional<Orthotropy> orthotropy = std::nullopt;

  /// The modulus that a contact meets at a surface with this normal.
  [[nodiscard]] double modulus_along(const Vec3& normal) const noexcept {
    return orthotropy ? orthotropy->modulus_along(normal) : youngs_modulus_pa;
  }
};

/// The radiation of each mode of a free body: coefficients of outgoing spherical waves about a
/// centre, for unit amplitude of modal velocity, at one or several frequencies. Evaluated by
/// core/modal/radiation/multipole.hpp.
struct MultipoleTable {
  std::vector<std::int32_t> highest_degree;      ///< mp_lmax [K]
  std::vector<std::int64_t> offset;              ///< mp_off [K+1], into one scale's coefficients
  std::vector<double> scales;                    ///< mp_scales [S], ratios of frequency
  std::vector<std::complex<float>> coefficients; ///< mp_coef [S x total]
  Vec3 centre{};                                 ///< m
  double reference_radius_m = 0;                 ///< mp_rref
  /// Coefficients at frequencies common to all modes, for modes that a force drives; may be empty.
  struct Band {
    std::vector<double> frequency_hz;              ///< mp_band_freq [F], ascending
    std::vector<std::int32_t> highest_degree;      ///< mp_band_lmax [K]
    std::vector<std::int64_t> offset;              ///< mp_band_off [K+1]
    std::vector<std::complex<float>> coefficients; ///< mp_band_coef [F x total]
    [[nodiscard]] bool empty() const noexcept { return coefficients.empty(); }
  } band;
  [[nodiscard]] bool empty() const noexcept { return coefficients.empty(); }
};

/// Measured or computed velocities of surface elements after a strike (AudioHaptics paper).
struct RawTable {
  std::size_t hits = 0, points = 0, samples = 0;
  std::vector<float> velocity_m_per_s; ///< [hits][points][samples], for an impact of 1 m/s
  std::vector<Vec3> position_m, hit_m;
  std::vector<double> area_m2;
  double sample_rate_hz = 0;
  [[nodiscard]] bool empty() const noexcept { return velocity_m_per_s.empty(); }
};

/// The modes of a body's surface, with everything that sound and contact depend on. Written by
/// modal_fem, read by files/tables.hpp; docs/formats/modal_table.md lists the arrays.
struct ModalTable {
  std::vector<double> frequency_hz; ///< [K], ascending, elastic modes only
  std::vector<float> shape;         ///< [K][V][3], 1/sqrt(kg): modal mass 1; empty: unit gain
  std::vector<Vec3> vertex_m;       ///< [V]
  std::vector<std::array<std::int32_t, 3>> triangle; ///< [T], counterclockwise seen from outside
  std::vector<double> loss_factor;          ///< [K] of the material, or empty when decay is given
  std::vector<double> decay_rate;           ///< [K] 1/s
  std::vector<double> radiation_decay_rate; ///< [K] 1/s or empty
  std::vector<double> poisson_slope;        ///< [K] d ln f / d nu or empty
  std::vector<float> residual_compliance;   ///< [V] m/N of the modes left out, or empty
  double mass_kg = 0;
  Vec3 centre_of_mass_m{};
  std::array<Vec3, 3> inertia_kg_m2{};
  bool free = true; ///< nothing holds the body: a strike makes it recoil
  std::string body_name, boundary;
  Material material;
  double air_density_kg_per_m3 = 1.184, sound_speed_m_per_s = 346.1;
  MultipoleTable multipoles;
  RawTable raw;
  ShapeSensitivity sensitivity; ///< may be empty
  bool has_mesh = false;        ///< modal_fem serve can solve it at other shapes

  [[nodiscard]] std::size_t modes() const noexcept { return frequency_hz.size(); }
  [[nodiscard]] std::size_t vertices() const noexcept { return vertex_m.size(); }
  /// Displacement of a vertex for unit modal coordinate.
  [[nodiscard]] Vec3 shape_at(std::size_t mode, std::size_t vertex) const noexcept {
    const float* at = shape.data() + (mode * vertex_m.size() + vertex) * 3;
    return {at[0], at[1], at[2]};
  }
};

inline constexpr std::size_t kMaxModes = 20000;
inline constexpr std::size_t kMaxVertices = 5'000'000;

/// The share of a mode of the earlier shape in a mode of the new one: the modal coordinates are
/// z_now = sum over before of share z_before. The shares are a partial isometry, so that they add
/// no energy: +-1 for a mode that keeps its shape, a rotation among modes of similar frequency that
/// mix, none for a mode without a successor.
struct ModeShare {
  std::uint32_t before = 0, now = 0; ///< numbers of the modes
  double share = 0;                  ///< -1..1
};

/// The number of modes to keep, at least `count`, so that no group of near-equal frequencies is
/// cut. The directions of the modes within such a group are arbitrary, so that the sound of a part
/// of it would depend on how the body is turned. Near-equal: a gap below 0.1 %, and below a tenth
/// of the mean gap of a plate's modes, 1 / mode.
[[nodiscard]] inline std::size_t with_whole_groups(std::span<const double> frequency_hz,
                                                   std::size_t count) noexcept {
  const auto& f = frequency_hz;
  while (count > 0 && count < f.size() &&
         std::abs(f[count] - f[count - 1]) <
             std::min(1e-3, .1 / static_cast<double>(count)) * f[count])
    ++count;
  return std::min(count, f.size());
}

} // namespace tactus::modal
