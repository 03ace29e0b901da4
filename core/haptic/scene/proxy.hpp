#pragma once

#include "core/haptic/scene/half_spaces.hpp"
#include "core/haptic/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace tactus::haptic {

/// One body as the proxy meets it in this tick.
struct Obstacle {
  const Body* body = nullptr;
  Pose pose{};
  std::size_t slot = 0; ///< the caller's number
  Bounds bounds{};      ///< world, of the bare body
};

/// A face that holds the proxy back.
struct Touch {
  std::size_t slot = 0;
  Vec3 point{};  ///< m, world: a position of the tool's centre in which it touches the face
  Vec3 normal{}; ///< outwards, world
  double penetration_m = 0; ///< the normal's share of the distance from the goal to the proxy
};

struct Touches {
  std::array<Touch, 3> touch{};
  std::size_t count = 0;
  [[nodiscard]] std::span<const Touch> all() const noexcept { return {touch.data(), count}; }
  /// What they push together: the normal part of the distance from the goal to the proxy.
  [[nodiscard]] Vec3 normal_part() const noexcept {
    Vec3 sum;
    for (const Touch& one : all())
      sum += one.normal * one.penetration_m;
    return sum;
  }
  /// The pushes that put the goal in front of all these faces; false, with all as it was, when
  /// rounding hides them.
  bool solve_penetration(const Vec3& goal) noexcept;
};

/// What surrounds the tool in this tick, and what may be spent on it.
struct Surroundings {
  std::span<const Obstacle> obstacles;
  double tool_radius_m;
  WorkLimit& work;
};

/// The ideal tool that stays outside while the handle goes in: the god object of Zilles & Salisbury
/// (IEEE/RSJ Intelligent Robots and Systems 1995), here the centre of a sphere. Each step goes
/// straight to the point nearest to the goal that the faces met so far allow, stops where it enters
/// another, and adds that face; at most three hold it. Every step shortens the distance to the goal
/// and none passes through a surface, so the spring between goal and proxy never gains energy and a
/// thin body is never left on its far side.
///
/// Only motions whose test against every obstacle is complete are made. When the work is exhausted
/// the proxy stays where the last of them ended: outside of everything, on its way.
class Proxy {
public:
  /// The proxy keeps this far from every surface, so that rounding cannot put it inside: far above
  /// the rounding of positions (1e-16 m), far below anything that is felt.
  static constexpr double kSkin_m = 1e-12;

  struct Result {
    Vec3 end{};
    Touches touches{};
    Touch first{}; ///< the first face that was entered
    bool hit = false;
    bool complete = true; ///< else the work was exhausted before the nearest point was found
  };
  /// From a position outside towards the goal, as far as the obstacles let it. Bounded time.
  [[nodiscard]] static Result settle(const Vec3& start, const Vec3& goal,
                                     const Surroundings& surroundings) noexcept;

  /// The fraction of a straight motion that is free of all obstacles but one, and what ends it.
  struct Stop {
    double fraction = 1;
    Touch touch{};
    bool hit = false;
    bool complete = true; ///< else nothing is known
  };
  static constexpr std::size_t kNoSlot = ~std::size_t{0};
  [[nodiscard]] static Stop sweep(const Vec3& from, const Vec3& to,
                                  const Surroundings& surroundings,
                                  std::size_t except = kNoSlot) noexcept;
};

} // namespace tactus::haptic
