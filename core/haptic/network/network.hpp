#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

/// The description of a mass-spring network: masses, links, pickups. network_model.hpp simulates
/// it; docs/theory/network.md has the equations.
namespace tactus::haptic {

/// One point mass.
struct NetworkMass {
  /// Unique, ascending along the list. A mass that keeps its key keeps its motion.
  std::uint64_t key = 0;
  double mass_kg = 1e-3;
  Vec3 position{};    ///< m, at rest and after a reset
  bool fixed = false; ///< an anchor, which does not move
};

/// A spring and damper between two masses a and b. d: vector from a to b, L: its length, n = d/L,
/// w: velocity of b relative to a.
///   force on a = (k (L - l0) + (b_n - b_t) (w . n)) n + b_t w,   force on b = -force on a.
struct NetworkLink {
  enum class Kind : std::uint16_t {
    kSpring, ///< pulls and pushes
    kPull,   ///< a cable: no force while L < l0
    kPush,   ///< a buffer: no force while L > l0
  };
  std::uint16_t a = 0, b = 0; ///< indices into Network::masses
  Kind kind = Kind::kSpring;
  double stiffness_n_per_m = 0;            ///< k
  double rest_length_m = 0;                ///< l0
  double damping_n_s_per_m = 0;            ///< b_n, along the link
  double transverse_damping_n_s_per_m = 0; ///< b_t, across it, as the internal loss of a string
};

/// Contact of the handle with the masses: a sphere around the handle pushes them away by a spring
/// and a damper and never pulls.
struct NetworkTouch {
  double radius_m = 0.01;
  double stiffness_n_per_m = 400;
  double damping_n_s_per_m = 0.1;
};

/// The spring and damper between the handle and a grabbed mass.
struct NetworkGrab {
  double stiffness_n_per_m = 400;
  double damping_n_s_per_m = 0.1;
};

/// The signal of one outlet: a quantity of one mass.
struct NetworkPickup {
  enum class Quantity {
    kVelocity,     ///< m/s
    kDisplacement, ///< m, from the position at rest
    kForce,        ///< N, force of the links on the mass; for an anchor, the force on a bridge
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::size_t mass = kNone;
  int axis = 2;
  Quantity quantity = Quantity::kVelocity;
};

/// A whole network. The host makes it, the servo reads it; it is never changed.
struct Network {
  static constexpr std::size_t kMaxMasses = 200, kMaxAnchors = 100;
  static constexpr std::size_t kMaxPoints = kMaxMasses + kMaxAnchors;
  static constexpr std::size_t kMaxLinks = 1000;
  static constexpr std::size_t kPickups = 2;

  std::vector<NetworkMass> masses;
  std::vector<NetworkLink> links;
  double drag_per_s = 0; ///< alpha: a force -alpha m v on every mass
  Vec3 gravity{};        ///< m/s^2
  NetworkTouch touch{};
  NetworkGrab grab{};
  std::array<NetworkPickup, kPickups> pickups{};
  double rate_hz = 48000; ///< requested steps per second; see steps_per_tick()
};

} // namespace tactus::haptic
