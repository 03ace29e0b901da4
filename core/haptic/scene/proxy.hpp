#pragma once

#include "core/haptic/scene/half_spaces.hpp"
#include "core/haptic/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace tactus::haptic {

/// One body near the tool, with its pose in this tick.
struct Obstacle {
  const Body* body = nullptr;
  Pose pose{};
  std::size_t slot = 0; ///< index that the caller gives the body
  Bounds bounds{};      ///< box in world coordinates, without the tool's radius
};

/// A face on which the proxy rests.
struct Touch {
  std::size_t slot = 0;
  Vec3 point{};  ///< m, world: a position of the tool's centre at which it touches the face
  Vec3 normal{}; ///< outwards, world
  double penetration_m = 0; ///< the part of (proxy - goal) along this normal
};

/// The faces that hold the proxy, at most three.
struct Touches {
  std::array<Touch, 3> touch{};
  std::size_t count = 0;
  [[nodiscard]] std::span<const Touch> all() const noexcept { return {touch.data(), count}; }
  /// The part of (proxy - goal) along the normals, m.
  [[nodiscard]] Vec3 normal_part() const noexcept {
    Vec3 sum;
    for (const Touch& one : all())
      sum += one.normal * one.penetration_m;
    return sum;
  }
  /// Adds a face or replaces one of the same body with the same normal. A fourth face is ignored.
  void add(const Touch& face) noexcept;
  /// Sets the penetrations of these faces for this goal. If nearest_point() finds no solution,
  /// returns false and changes nothing.
  bool solve_penetration(const Vec3& goal) noexcept;
};

/// Obstacles, tool and work limit of one search.
struct Surroundings {
  std::span<const Obstacle> obstacles;
  double tool_radius_m;
  WorkLimit& work;
};

/// Common coefficient of friction of these faces: the mean of the coefficients of their bodies,
/// weighted by the normal forces.
[[nodiscard]] double friction_of(std::span<const Touch> faces,
                                 std::span<const Obstacle> obstacles) noexcept;

/// The proxy of a haptic tool: the position on the surface of the bodies that is nearest to the
/// handle (the goal) while the handle is inside. The god-object method of Zilles & Salisbury
/// (IEEE/RSJ Intelligent Robots and Systems 1995) for the centre of a sphere. Each step moves
/// straight to the nearest point to the goal that the faces found so far allow, stops where it
/// enters another face, and adds that face; at most three faces are active. Every step shortens the
/// distance to the goal and none passes through a surface. Therefore the spring between goal and
/// proxy never gains energy, and the proxy never passes through a thin body.
///
/// With friction the proxy itself is the anchor, one for all bodies that it touches (the friction
/// cone of Melder & Harwin, HAPTICS 2004). Let t be the displacement along the faces without
/// friction, and D the sum of the depths. The proxy then moves only by |t| - mu D, until the goal
/// lies on the edge of the cone. If the goal lies within the cone, the proxy stays.
/// docs/theory/scene.md has the steps.
///
/// A motion is made only when its test against every obstacle is complete. When the work is
/// exhausted the proxy stays at the end of the last such motion, outside of every body.
class Proxy {
public:
  /// Distance that the proxy keeps from every surface, so that rounding does not put it inside: far
  /// above the rounding of positions (1e-16 m), far below what can be felt.
  static constexpr double kSkin_m = 1e-12;

  struct Result {
    Vec3 end{};
    Touches touches{};
    bool hit = false;     ///< a face was entered
    bool complete = true; ///< false: the work was exhausted before the nearest point was found
  };
  /// Moves from a position outside of the obstacles towards the goal as far as they and their
  /// friction allow. `held`: faces on which the start lies. Bounded time.
  [[nodiscard]] static Result settle(const Vec3& start, const Vec3& goal,
                                     const Surroundings& surroundings,
                                     const Touches& held = {}) noexcept;

  /// The first contact of a straight motion.
  struct Stop {
    double fraction = 1; ///< part of the motion that is free
    Touch touch{};       ///< valid if `hit`
    bool hit = false;
    bool complete = true; ///< false: the work was exhausted and the result is not valid
  };
  static constexpr std::size_t kNoSlot = ~std::size_t{0};
  /// Tests a straight motion against all obstacles but `except`.
  [[nodiscard]] static Stop sweep(const Vec3& from, const Vec3& to,
                                  const Surroundings& surroundings,
                                  std::size_t except = kNoSlot) noexcept;
};

} // namespace tactus::haptic
