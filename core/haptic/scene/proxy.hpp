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
};

/// A face that holds the proxy back.
struct Touch {
  std::size_t slot = 0;
  Vec3 point{};      ///< m, world
  Vec3 normal{};     ///< outwards, world
  double push_m = 0; ///< the normal's share of the way from the goal to the proxy
};

struct Touches {
  std::array<Touch, 3> touch{};
  std::size_t count = 0;
  [[nodiscard]] std::span<const Touch> all() const noexcept { return {touch.data(), count}; }
};

/// The ideal point that stays outside while the handle goes in: the god object of Zilles &
/// Salisbury (IEEE/RSJ Intelligent Robots and Systems 1995). Each step goes straight to the point
/// nearest to the goal that the faces met so far allow, stops where it enters another, and adds
/// that face; at most three hold it. Every step shortens the way to the goal and none passes
/// through a surface, so the spring between goal and proxy never gains energy and a thin body is
/// never left on its far side.
class Proxy {
public:
  /// The proxy keeps this far from every surface, so that rounding cannot put it inside: far above
  /// the rounding of positions (1e-16 m), far below anything that is felt.
  static constexpr double kSkin_m = 1e-12;

  struct Way {
    Vec3 end{};
    Touches touches{};
    Touch first{}; ///< the first face that was entered
    bool met = false;
  };
  /// From a point outside towards the goal, as far as the obstacles let it. Bounded time.
  [[nodiscard]] static Way settle(const Vec3& start, const Vec3& goal,
                                  std::span<const Obstacle> obstacles) noexcept;

  /// The share of a straight way that is free of all obstacles but one, and what ends it.
  struct Stop {
    double share = 1;
    Touch touch{};
    bool met = false;
  };
  static constexpr std::size_t kNobody = ~std::size_t{0};
  [[nodiscard]] static Stop sweep(const Vec3& from, const Vec3& to,
                                  std::span<const Obstacle> obstacles,
                                  std::size_t except = kNobody) noexcept;
};

} // namespace tactus::haptic
