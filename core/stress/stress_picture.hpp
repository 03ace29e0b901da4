#pragma once

#include "core/stress/stress_model.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tactus::stress {

/// A triangle of the surface, projected along z.
struct PictureFace {
  double stress_pa = 0;             ///< mean of its three corners
  std::array<double, 6> corner_m{}; ///< x1 y1 x2 y2 x3 y3
};

/// A side view of the part at one shape. `stress_scale_pa` is the largest stress of a face in the
/// table's own shape, so that colours can be compared between shapes.
struct Picture {
  std::vector<PictureFace> faces; ///< faces from the farthest to the nearest
  double stress_scale_pa = 0, width_m = 0;
};

/// Draws the surface of a part in parallel projection, seen from +z: x to the right, y up.
///
/// A vertex v moves by sum_c W[v][c] d_c, with the table's surface weights W and the displacements
/// d_c of the control points (free-form deformation). Without weights the surface keeps its shape.
/// The stress of a vertex is that of its element, from the model's series. Faces that point away
/// from the viewer in the table's shape are omitted; the others are sorted by depth, so that
/// drawing them in order hides covered parts.
class StressPicture {
public:
  explicit StressPicture(const StressTable& table);

  /// `model`: of the same table. displacement_m: [P]. Allocates.
  [[nodiscard]] std::shared_ptr<const Picture> draw(const StressModel& model,
                                                    std::span<const double> displacement_m) const;

private:
  struct Vertex {
    std::int32_t node = 0;
    std::size_t element = 0; ///< index in elements_
  };
  std::vector<Vertex> vertices_;
  std::vector<std::size_t> elements_;             ///< elements whose stress colours a vertex
  std::vector<std::array<std::size_t, 3>> faces_; ///< indices of vertices, by depth
  double stress_scale_pa_ = 0, width_m_ = 0;
};

} // namespace tactus::stress
