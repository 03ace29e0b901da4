#pragma once
#include "fem/io/triangles.hpp"

#include <functional>

namespace tactus::fem {

/// The same closed surface in triangles of about `edge(position)` (m) on a side: long edges are
/// halved, short ones collapse, the others turn to where angles are best, and points within flat
/// parts even out (Botsch & Kobbelt 2004). Edges of more than 30 degrees stay, and so do details
/// that would move by more than `deviation` (m), however small. Shells keep their numbers.
[[nodiscard]] Triangles remeshed(const Triangles&, const std::function<double(const Vec3&)>& edge,
                                 double deviation);
[[nodiscard]] inline Triangles remeshed(const Triangles& surface, double edge, double deviation) {
  return remeshed(
      surface, [edge](const Vec3&) { return edge; }, deviation);
}

} // namespace tactus::fem
