#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

/// What a mass-spring network is made of; network_model.hpp steps it. docs/network.md has the
/// equations.
namespace tactus::haptic {

struct NetworkMass {
  std::uint64_t key =
      0; ///< never used twice, growing along the list; a mass keeps its motion by it
  double mass_kg = 1e-3;
  Vec3 position{};    ///< m, at rest and after a reset
  bool fixed = false; ///< an anchor: it holds and does not move
};

/// Spring and damper between two masses, d the vector from a to b, L its length, n = d/L,
/// w the relative velocity of b:
///   force on a = (k (L - l0) + (b_n - b_t) (w . n)) n + b_t w,   on b the opposite.
struct NetworkLink {
  enum class Kind : std::uint16_t {
    kSpring, ///< both ways
    kPull,   ///< a cable: nothing while L < l0
    kPush,   ///< a buffer: nothing while L > l0
  };
  std::uint16_t a = 0, b = 0; ///< indices into Network::masses
  Kind kind = Kind::kSpring;
  double stiffness_n_per_m = 0;            ///< k
  double rest_length_m = 0;                ///< l0
  double damping_n_s_per_m = 0;            ///< b_n, along the link
  double transverse_damping_n_s_per_m = 0; ///< b_t, across it: the inner loss of a string
};

/// How the handle meets the masses: a sphere about it pushes them away, a spring-damper of that
/// stiffness and damping, never pulling.
struct NetworkTouch {
  double radius_m = 0.01;
  double stiffness_n_per_m = 400;
  double damping_n_s_per_m = 0.1;
};

/// The spring-damper between the handle and a mass that it grabs.
struct NetworkGrab {
  double stiffness_n_per_m = 400;
  double damping_n_s_per_m = 0.1;
};

/// One signal outlet: what is read from which mass.
struct NetworkPickup {
  enum class Quantity {
    kVelocity,     ///< m/s
    kDisplacement, ///< m, from the position at rest
    kForce,        ///< N, that links put on the mass: an anchor's is what a bridge feels
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::size_t mass = kNone;
  int axis = 2;
  Quantity quantity = Quantity::kVelocity;
};

/// A network as the host wants it. Made by the host, read by the servo, never changed.
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
  double rate_hz = 48000; ///< steps a second, at least
};

} // namespace tactus::haptic
