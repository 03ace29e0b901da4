#pragma once

#include "core/haptic/network/network.hpp"

#include <vector>

/// Strings and membranes as parts of a network.
namespace tactus::haptic {

/// Masses and the links among them; link ends count from the part's first mass, keys are 0.
struct NetworkPart {
  std::vector<NetworkMass> masses;
  std::vector<NetworkLink> links;
};

/// count equal masses between two anchors, d = |to - from|/(count + 1) apart, each m = mass/count.
/// Small transverse motion has the frequencies
///   omega_j = 2 sqrt(T/(m d)) sin(j pi/(2 (count + 1))),   j = 1..count
/// (Fletcher & Rossing, The Physics of Musical Instruments, 2nd ed., 2.1). Masses in order, anchors
/// first and last.
struct NetworkString {
  int count = 40;
  Vec3 from{-0.05, 0, 0}, to{0.05, 0, 0}; ///< m
  double mass_kg = 1e-3;                  ///< of all masses together
  double tension_n = 10;
  double damping_n_s_per_m = 1e-3; ///< of each link, along and across
  /// Of each link along the string, at least T/d. At T/d the rest length is 0 and the string
  /// linear; above, the rest length is d - T/k and the tension grows with the amplitude.
  double stiffness_n_per_m = 0;
};
[[nodiscard]] NetworkPart make_string(const NetworkString& string);

/// nx x ny equal masses in a rectangle between two opposite corners, which share one coordinate;
/// anchors along the four edges. Links of rest length 0 carry tension dy between neighbours along
/// the first axis, tension dx along the second. Small motion across it has the frequencies
///   omega_jk^2 = (4 tension/m) ((dy/dx) sin^2(j pi/(2(nx+1))) + (dx/dy) sin^2(k pi/(2(ny+1)))).
struct NetworkMembrane {
  int nx = 12, ny = 12;
  Vec3 from{-0.04, -0.04, 0}, to{0.04, 0.04, 0}; ///< m
  double mass_kg = 2e-3;
  double tension_n_per_m = 50;
  double damping_n_s_per_m = 1e-3; ///< of each link
};
/// Rows along the first axis one after another, the rim included, the four corners left out.
/// Empty when the corners do not share exactly one coordinate.
[[nodiscard]] NetworkPart make_membrane(const NetworkMembrane& membrane);
/// Index of the mass in column i = 0..nx+1 and row j = 0..ny+1 of that part; corners have none.
[[nodiscard]] std::size_t membrane_index(int nx, int ny, int i, int j) noexcept;

} // namespace tactus::haptic
