#pragma once

#include "core/reed/playability/gradient_plane.hpp"

#include <cstddef>
#include <vector>

namespace tactus::reed {

/// A scalar field on a regular grid over the plane [0, 1] x [0, 1] with bilinear interpolation. Its
/// gradient is interpolated between the central differences at the nodes, so that it is continuous.
class GradientField {
public:
  /// Allocates columns x rows nodes (at least 2 x 2) of value 0.
  void resize(std::size_t columns, std::size_t rows);
  [[nodiscard]] std::size_t columns() const noexcept { return columns_; }
  [[nodiscard]] std::size_t rows() const noexcept { return rows_; }
  [[nodiscard]] bool empty() const noexcept { return values_.empty(); }

  /// Node of column i (along y) and row k (along z).
  [[nodiscard]] double& node(std::size_t i, std::size_t k) noexcept {
    return values_[k * columns_ + i];
  }
  [[nodiscard]] double node(std::size_t i, std::size_t k) const noexcept {
    return values_[k * columns_ + i];
  }
  [[nodiscard]] double y_of(std::size_t column) const noexcept {
    return static_cast<double>(column) / static_cast<double>(columns_ - 1);
  }
  [[nodiscard]] double z_of(std::size_t row) const noexcept {
    return static_cast<double>(row) / static_cast<double>(rows_ - 1);
  }

  /// Recomputes the slopes at all nodes; call after the nodes have changed.
  void differentiate() noexcept;
  /// Bilinear; y and z are clamped to [0, 1]. 0 while the field is empty.
  [[nodiscard]] double value(double y, double z) const noexcept;
  /// The gradient per unit of y and z; valid after differentiate().
  [[nodiscard]] Gradient gradient(double y, double z) const noexcept;

private:
  struct Cell {
    std::size_t corner;
    double fraction_y, fraction_z;
  };
  [[nodiscard]] Cell cell(double y, double z) const noexcept;
  [[nodiscard]] double interpolate(const std::vector<double>& nodes,
                                   const Cell& cell) const noexcept;

  std::size_t columns_ = 0, rows_ = 0;
  std::vector<double> values_, slope_y_, slope_z_;
};

} // namespace tactus::reed
