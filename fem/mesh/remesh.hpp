#pragma once
#include "fem/io/triangles.hpp"

#include <functional>

namespace tactus::fem {

/// Remeshes a closed surface with triangles whose edges are about `edge(position)` (m) long. Long
/// edges are halved, short edges collapsed, other edges flipped to improve angles, and points
/// within flat parts smoothed (Botsch & Kobbelt 2004). Edges of more than 30 degrees are kept, as
/// are details that would move by more than `deviation` (m), however small. Shells keep their
/// numbers.
[[nodiscard]] Triangles remeshed(const Triangles&, const std::function<double(const Vec3&)>& edge,
                                 double deviation);
[[nodiscard]] inline Triangles remeshed(const Triangles& surface, double edge, double deviation) {
  return remeshed(
      surface, [edge](const Vec3&) { return edge; }, deviation);
}

} // namespace tactus::fem
