#pragma once
#include "fem/mesh/surface.hpp"

#include <span>

namespace tactus::fem {

/// A closed surface of flat triangles, outward.
struct AcousticSkin {
  std::vector<Vec3> vertex;
  std::vector<std::array<int, 3>> triangle;
};

/// The part of a body's skin that the outside air touches: without the closed surfaces around
/// cavities, whose enclosed volume is negative.
[[nodiscard]] AcousticSkin outer_skin(const Mesh&);

/// Returns a skin of about `triangles` triangles. To coarsen, edges collapse onto kept vertices,
/// the cheapest first by quadric error (Garland & Heckbert 1997) plus a share of the edge's length,
/// without folds, slivers and changes of topology. Edges at which the skin turns outwards by more
/// than 40 degrees get rows of flat triangles. The pressure's slope is infinite there, and
/// triangles of equal size would leave an error that dominates where the rest of the field cancels.
/// To refine, every triangle is divided in four, as long as the number permits.
[[nodiscard]] AcousticSkin with_triangles(const AcousticSkin&, std::size_t triangles);

/// Projects the normal velocity on one skin onto the hat functions of another: f_i = ∫ v_n phi_i
/// dS, mapping each of three points per fine triangle to the nearest point of the coarse skin. The
/// total flow is exactly preserved.
class FlowTransfer {
public:
  FlowTransfer(const AcousticSkin& fine, const AcousticSkin& coarse);
  /// `velocity` at each vertex of the fine skin, m/s; the result has one flow per coarse vertex,
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

/// The weights of the vertices for the point of a triangle that is nearest to `p`.
[[nodiscard]] std::array<double, 3> nearest_on_triangle(const std::array<Vec3, 3>& corner,
                                                        const Vec3& p);

} // namespace tactus::fem
