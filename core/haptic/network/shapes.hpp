#pragma once

#include "core/haptic/network/network.hpp"

#include <vector>

/// Strings and membranes as parts of a mass-spring network.
namespace tactus::haptic {

/// Masses and the links between them. Link ends are indices into this part's masses; keys are 0.
struct NetworkPart {
  std::vector<NetworkMass> masses;
  std::vector<NetworkLink> links;
};

/// A string: `count` equal masses m = mass/count between two anchors, at distances
/// d = |to - from|/(count + 1). Small transverse motion at the tension T has the angular
/// frequencies
///   omega_j = 2 sqrt(T/(m d)) sin(j pi/(2 (count + 1))),   j = 1..count
/// (Fletcher & Rossing, The Physics of Musical Instruments, 2nd ed., 2.1). The masses are in
/// order along the string; first and last are the anchors.
struct NetworkString {
  int count = 40;
  Vec3 from{-0.05, 0, 0}, to{0.05, 0, 0}; ///< m
  double mass_kg = 1e-3;                  ///< mass of all masses together
  double tension_n = 10;
  double damping_n_s_per_m = 1e-3; ///< damping of each link, along and across
  /// k of each link along the string, at least T/d (smaller values count as T/d). At k = T/d the
  /// rest length is 0 and the string is linear. For a larger k the rest length is d - T/k and the
  /// tension grows with the amplitude.
  double stiffness_n_per_m = 0;
};
[[nodiscard]] NetworkPart make_string(const NetworkString& string);

/// A rectangular membrane: nx x ny equal masses m, at distances dx and dy, with anchors along the
/// four edges. The two given corners are opposite and share one coordinate. Links have rest length
/// 0; their force is tension dy along the first axis, tension dx along the second. Small motion
/// perpendicular to the membrane has the angular frequencies
///   omega_jk^2 = (4 tension/m) ((dy/dx) sin^2(j pi/(2(nx+1))) + (dx/dy) sin^2(k pi/(2(ny+1)))).
struct NetworkMembrane {
  int nx = 12, ny = 12;
  Vec3 from{-0.04, -0.04, 0}, to{0.04, 0.04, 0}; ///< m
  double mass_kg = 2e-3;
  double tension_n_per_m = 50;
  double damping_n_s_per_m = 1e-3; ///< damping of each link
};
/// Masses row by row along the first axis, with the rim and without the four corners. Empty when
/// `from` and `to` do not share exactly one coordinate.
[[nodiscard]] NetworkPart make_membrane(const NetworkMembrane& membrane);
/// Index of the mass in column i = 0..nx+1 and row j = 0..ny+1 of a membrane; corners have none.
[[nodiscard]] std::size_t membrane_index(int nx, int ny, int i, int j) noexcept;

} // namespace tactus::haptic
