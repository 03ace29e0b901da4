#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Element sizes in space for the next mesh of a body: a value at each corner of the last mesh; any
/// other position has the value of the nearest corner.
class SizeField {
public:
  /// `size` is the element size at each point, m.
  SizeField(std::vector<Vec3> points, std::vector<double> size);
  [[nodiscard]] double at(const Vec3&) const noexcept;
  [[nodiscard]] double smallest() const noexcept;
  [[nodiscard]] double largest() const noexcept;
  double elements = 0;   ///< predicted number of elements
  bool straight = false; ///< the last mesh had only straight edges
  /// For a swept body (sweep.hpp): the borders of its layers as shares of its height, 0 to 1.
  std::vector<double> levels;

private:
  [[nodiscard]] std::size_t cell(const Vec3&, int dx, int dy, int dz) const noexcept;

  std::vector<Vec3> point_;
  std::vector<double> size_;
  Box box_;
  double edge_ = 1; ///< edge of the search cells
  std::array<int, 3> cells_{};
  std::vector<std::size_t> first_, inside_;
};

} // namespace tactus::fem
