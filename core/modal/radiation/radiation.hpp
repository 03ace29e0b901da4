#pragma once

#include "core/modal/radiation/arrivals.hpp"
#include "core/modal/radiation/surface_quadrature.hpp"
#include "core/modal/table/modal_table.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// What a listener hears of every mode: pressure for unit amplitude of modal velocity, at the
/// mode's complex rate, with the delay of the shortest way taken out.
struct ListenerTransfer {
  std::vector<std::complex<double>> pressure; ///< T_k, Pa s/(m sqrt(kg))
  double delay_s = 0;
};

/// The surface of a body as sources of sound.
class RadiatingSurface {
public:
  /// Allocates: every mode's normal displacement at the surface's nodes. The surface must stay.
  void build(const ModalTable& table, const Surface& surface);

  /// What is around the body, and how the table's lengths and shapes are scaled.
  struct Scene {
    double size = 1, shape_scale = 1, air_density_kg_per_m3 = 1.184, sound_speed_m_per_s = 346.1;
    double sample_rate = 48000;
    std::size_t max_spread = Arrivals::kMaxSpread; ///< samples
    double delay_from_s = -1; ///< of another body heard beside this one (TravelTime); below 0: none
  };
  /// Outward displacement of each triangle for a unit of the rigid motions' coordinates.
  using RigidShapes = std::vector<std::array<double, Arrivals::kRigid>>;

  /// Rayleigh's integral of the retarded normal acceleration,
  ///   p(t) = rho sum over k of  int phi_k,n q_k''(t - d/c) / (2 pi d) dS,
  /// the pressure in front of a flat source in a rigid baffle. A flat body radiates with the faces
  /// that look to the listener's side along its thin direction, any other body with all the faces
  /// that the listener sees. The listener is in metres in the body's axes. Its `delay_s`, of the
  /// shortest path, is what is left for a delay line, the latency of the band limit taken out
  /// (never below 0). The surface must outlive the result.
  [[nodiscard]] std::unique_ptr<Arrivals> arrivals(const Vec3& listener, const Scene& scene,
                                                   const RigidShapes& rigid) const;
  /// The same in free vibration, for a mode's velocity, with complex rates s = -alpha + j omega_d:
  ///   T_k = rho s_k  int phi_k,n exp(-s_k (d - d0)/c) / (2 pi d) dS,   d0 the shortest distance,
  /// without a band limit. `size` scales the body, `shape_scale` its mode shapes.
  [[nodiscard]] ListenerTransfer modal(std::span<const std::complex<double>> rate,
                                       std::span<const std::size_t> mode, const Vec3& listener,
                                       double size, double shape_scale, double air_density,
                                       double sound_speed) const;
  /// Of a triangle, in the table's size.
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
  /// Of a mode at a source, along the normal; straight between the triangle's nodes.
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

/// A body's radiation into all directions as outgoing spherical waves, from the table's multipoles:
///   p = sum over l, m of c_lm h_l(k r) / h_l(k r_ref) Y_lm(direction),  exp(+j omega t),
/// h_l spherical Hankel functions of the second kind, Y_lm the complex orthonormal harmonics with
/// Condon and Shortley's phase, coefficient l^2 + l + m for unit amplitude of modal velocity.
/// `ratio` is the present frequency over the table's at the same size.
[[nodiscard]] ListenerTransfer
multipole_transfer(const ModalTable& table, std::span<const std::complex<double>> rate,
                   std::span<const std::size_t> mode, const Vec3& listener, double size,
                   double shape_scale, double air_density, double sound_speed);

} // namespace tactus::modal
