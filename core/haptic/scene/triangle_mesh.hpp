#pragma once

#include "core/haptic/scene/pose.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactus::haptic {

/// Where a way meets a surface: the share of the way, and the surface's unit normal, which looks
/// back to where the way began.
struct Crossing {
  double share;
  Vec3 normal;
};

using Triangle = std::array<std::uint32_t, 3>;

/// Triangles under a tree of boxes. Building allocates; afterwards it is read only, by any thread.
/// The test is watertight: the edge that two triangles share is judged alike for both, so that no
/// way slips through between them.
class TriangleMesh {
public:
  /// Corners nearer than this are one corner; a triangle that loses one is left out.
  static constexpr double kWeld_m = 1e-6;

  TriangleMesh(std::span<const Vec3> corners_m, std::span<const Triangle> triangles);

  /// The first triangle met on the way. Time grows with the logarithm of the number of triangles
  /// for short ways.
  [[nodiscard]] std::optional<Crossing> crossing(const Vec3& from, const Vec3& to) const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }
  [[nodiscard]] const Vec3& low() const noexcept { return low_; }
  [[nodiscard]] const Vec3& high() const noexcept { return high_; }
  [[nodiscard]] std::span<const Vec3> corners() const noexcept { return corners_; }
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept { return triangles_; }

private:
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0; ///< leaf: its first triangle; else its second child
    std::uint32_t count = 0; ///< triangles of a leaf; 0: the first child follows at once
  };
  void weld(std::span<const Vec3> corners, std::span<const Triangle> triangles);
  std::uint32_t build(std::span<std::uint32_t> order, std::span<const Vec3> middles,
                      std::uint32_t first, int depth);

  std::vector<Vec3> corners_;
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  Vec3 low_{}, high_{};
};

} // namespace tactus::haptic
