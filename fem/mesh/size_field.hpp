#pragma once
#include "fem/error/balance.hpp"
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Element sizes in space for the next mesh of a body: a value at each corner of the last one, the
/// nearest corner's anywhere.
class SizeField {
public:
  /// `size` of each point, m.
  SizeField(std::vector<Vector3> points, std::vector<double> size);
  [[nodiscard]] double at(const Vector3&) const noexcept;
  [[nodiscard]] double smallest() const noexcept;
  [[nodiscard]] double largest() const noexcept;
  double elements = 0;   ///< about how many there will be
  bool straight = false; ///< the last mesh had straight sides only

private:
  [[nodiscard]] std::size_t cell(const Vector3&, int dx, int dy, int dz) const noexcept;

  std::vector<Vector3> point_;
  std::vector<double> size_;
  Box box_;
  double edge_ = 1; ///< of the search cells
  std::array<int, 3> cells_{};
  std::vector<std::size_t> first_, inside_;
};

/// Sizes on which every mode's error is at most `target`, with the fewest elements: of min sum
/// 1/f_i^3 under sum error_i f_i^order_i = target, f_i^(order_i + 3) ~ 1 / (order_i error_i). Cells
/// are the mesh's elements. They do not grow, since the shape of curved faces hangs on them; over a
/// distance d sizes grow by d/2 at most.
[[nodiscard]] SizeField refined_sizes(const Mesh&, const ErrorCells&, double target);

} // namespace tactus::fem
