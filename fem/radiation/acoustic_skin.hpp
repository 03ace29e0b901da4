#pragma once
#include "fem/mesh/surface.hpp"

#include <span>

namespace tactus::fem {

/// A closed surface of flat triangles, outward.
struct AcousticSkin {
  std::vector<Vec3> vertex;
  std::vector<std::array<int, 3>> triangle;
};

/// The part of a body's skin that the outside air touches: closed surfaces around cavities, whose
/// enclosed volume is negative, are left out.
[[nodiscard]] AcousticSkin outer_skin(const Mesh&);

/// About `triangles` triangles. Coarser: half-edge collapses onto kept vertices, cheapest first by
/// quadric error (Garland & Heckbert 1997) plus a share of the edge's length, refusing folds,
/// slivers and changes of topology. Edges at which the skin turns outwards by more than 40 degrees
/// get rows of flat triangles: the pressure's slope is infinite there, and triangles of equal size
/// leave an error that shows where the rest of the field cancels. Finer: every triangle in four, as
/// long as the number permits.
[[nodiscard]] AcousticSkin with_triangles(const AcousticSkin&, std::size_t triangles);

/// Projects the normal velocity on one skin onto the hat functions of another: f_i = ∫ v_n phi_i
/// dS, point by point of the fine skin (three a triangle) to the nearest point of the coarse one.
/// The total flow is kept exactly.
class FlowTransfer {
public:
  FlowTransfer(const AcousticSkin& fine, const AcousticSkin& coarse);
  /// `velocity` at each vertex of the fine skin, m/s; the result has one flow a coarse vertex,
  /// m^3/s.
  [[nodiscard]] std::vector<double> operator()(std::span<const Vec3> velocity) const;

private:
  struct Share {
    std::array<int, 3> to;
    std::array<double, 3> weight;
    Vec3 area; ///< normal times area
  };
  std::vector<std::array<int, 3>> fine_;
  std::vector<Share> shares_;
  std::size_t count_;
};

/// The vertices' weights of the point of a triangle that is nearest to `p`.
[[nodiscard]] std::array<double, 3> nearest_on_triangle(const std::array<Vec3, 3>& corner,
                                                        const Vec3& p);

} // namespace tactus::fem
