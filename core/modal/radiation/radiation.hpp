#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/radiation/arrivals.hpp"
#include "core/modal/radiation/surface_quadrature.hpp"
#include "core/modal/table/modal_table.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// The transfer from each mode's velocity to the pressure at a listener, at the mode's complex
/// rate, without the delay of the shortest path.
struct ListenerTransfer {
  std::vector<Complex> pressure; ///< T_k, Pa s/(m sqrt(kg))
  double delay_s = 0;
};

/// The radiation of a body's surface by Rayleigh's integral.
class RadiatingSurface {
public:
  /// Computes every mode's normal displacement at the surface's nodes. Allocates. The surface must
  /// outlive this object.
  void build(const ModalTable& table, const Surface& surface);

  /// The air, and the factors on the table's lengths (`size`) and mode shapes (`shape_scale`).
  struct Scene {
    double size = 1, shape_scale = 1, air_density_kg_per_m3 = 1.184, sound_speed_m_per_s = 346.1;
    double sample_rate = 48000;
    std::size_t max_spread = Arrivals::kMaxSpread; ///< samples
    double delay_from_s =
        -1; ///< delay of another body with the same listener (TravelTime); below 0: none
  };
  /// Outward displacement of each triangle for a unit of the rigid motions' coordinates.
  using RigidShapes = std::vector<std::array<double, Arrivals::kRigid>>;

  /// Rayleigh's integral of the retarded normal acceleration,
  ///   p(t) = rho sum over k of  int phi_k,n q_k''(t - d/c) / (2 pi d) dS,
  /// which is exact in front of a flat source in a rigid baffle. A flat body radiates with the
  /// faces on the listener's side, any other body with all faces that are turned to the listener.
  /// `listener`: m, in the body's axes. The surface must outlive the result.
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals(const Vec3& listener, const Scene& scene,
                                                   const RigidShapes& rigid) const;
  /// Rayleigh's integral in free vibration with complex rates s = -alpha + j omega_d, without a
  /// band limit:
  ///   T_k = rho s_k  int phi_k,n exp(-s_k (d - d0)/c) / (2 pi d) dS,   d0 the shortest distance.
  /// `mode`: the table's index of each rate.
  [[nodiscard]] ListenerTransfer modal(std::span<const Complex> rate,
                                       std::span<const std::size_t> mode, const Vec3& listener,
                                       const Scene& scene) const;
  /// Centre (m) and normal of a triangle, in the table's size.
  [[nodiscard]] const Vec3& centre(std::size_t triangle) const noexcept {
    return centre_[triangle];
  }
  [[nodiscard]] const Vec3& normal(std::size_t triangle) const noexcept {
    return normal_[triangle];
  }
  [[nodiscard]] std::size_t triangles() const noexcept { return area_.size(); }

private:
  class Retarded;
  [[nodiscard]] std::vector<std::size_t> facing(const Vec3& listener) const;
  /// A mode's normal displacement at a source, interpolated linearly between the triangle's nodes.
  [[nodiscard]] double displacement(std::size_t mode, const SurfaceSource& source) const noexcept {
    const float* const at = displacement_.data() + mode * nodes_.vertex.size();
    const auto& node = nodes_.triangle_nodes[source.triangle];
    return static_cast<double>(source.weight[0] * at[node[0]] + source.weight[1] * at[node[1]] +
                               source.weight[2] * at[node[2]]);
  }

  const Surface* surface_ = nullptr;
  std::vector<Vec3> centre_, normal_;
  std::vector<double> area_;
  SurfaceNodes nodes_;
  std::vector<float> displacement_; ///< [K][N], along the nodes' normals
  bool flat_ = false;
  Vec3 thin_axis_{0, 0, 1}, middle_{};
};

/// The transfer of a body in free air at its modes' frequencies, from the table's multipoles:
///   p = sum over l, m of c_lm h_l(k r) / h_l(k r_ref) Y_lm(direction),  exp(+j omega t),
/// h_l spherical Hankel functions of the second kind, Y_lm the complex orthonormal harmonics with
/// Condon and Shortley's phase, coefficient l^2 + l + m for unit amplitude of modal velocity.
[[nodiscard]] ListenerTransfer multipole_transfer(const ModalTable& table,
                                                  std::span<const Complex> rate,
                                                  std::span<const std::size_t> mode,
                                                  const Vec3& listener,
                                                  const RadiatingSurface::Scene& scene);

} // namespace tactus::modal
