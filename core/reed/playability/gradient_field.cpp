#include "core/reed/playability/gradient_field.hpp"

#include <algorithm>

namespace tactus::reed {

void GradientField::resize(std::size_t columns, std::size_t rows) {
  columns_ = std::max<std::size_t>(columns, 2);
  rows_ = std::max<std::size_t>(rows, 2);
  for (auto* nodes : {&values_, &slope_y_, &slope_z_})
    nodes->assign(columns_ * rows_, 0);
}

void GradientField::differentiate() noexcept {
  const auto slope = [this](std::size_t i, std::size_t k, std::size_t step, std::size_t index,
                            std::size_t count) {
    const std::size_t here = k * columns_ + i;
    const std::size_t before = index > 0 ? here - step : here;
    const std::size_t after = index + 1 < count ? here + step : here;
    const std::size_t nodes = (after - before) / step;
    return (values_[after] - values_[before]) / static_cast<double>(nodes) *
           static_cast<double>(count - 1);
  };
  for (std::size_t k = 0; k < rows_; ++k)
    for (std::size_t i = 0; i < columns_; ++i) {
      slope_y_[k * columns_ + i] = slope(i, k, 1, i, columns_);
      slope_z_[k * columns_ + i] = slope(i, k, columns_, k, rows_);
    }
}

GradientField::Cell GradientField::cell(double y, double z) const noexcept {
  const auto index = [](double x, std::size_t count, double& fraction) {
    const double at = (x > 0 ? std::min(x, 1.0) : 0.0) * static_cast<double>(count - 1);
    const std::size_t node = std::min(static_cast<std::size_t>(at), count - 2);
    fraction = at - static_cast<double>(node);
    return node;
  };
  Cell c{};
  c.corner = index(y, columns_, c.fraction_y);
  c.corner += index(z, rows_, c.fraction_z) * columns_;
  return c;
}

double GradientField::interpolate(const std::vector<double>& nodes, const Cell& c) const noexcept {
  const double* n = nodes.data() + c.corner;
  const double low = n[0] + c.fraction_y * (n[1] - n[0]);
  const double high = n[columns_] + c.fraction_y * (n[columns_ + 1] - n[columns_]);
  return low + c.fraction_z * (high - low);
}

double GradientField::value(double y, double z) const noexcept {
  return empty() ? 0 : interpolate(values_, cell(y, z));
}

Gradient GradientField::gradient(double y, double z) const noexcept {
  if (empty())
    return {};
  const Cell c = cell(y, z);
  return {interpolate(slope_y_, c), interpolate(slope_z_, c)};
}

} // namespace tactus::reed
