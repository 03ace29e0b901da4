#pragma once

#include "core/modal/table/modal_table.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Modal tables of bodies whose modes are known in closed form.
namespace tactus::test {

using modal::ModalTable;
using modal::Vec3;

/// A simply supported rectangular aluminium plate of sides a, b and thickness h (m), centred in the
/// x-y plane (Leissa 1969, section 4.1): modes m, n of frequency
///   f = pi/2 sqrt(D/(rho h)) ((m/a)^2 + (n/b)^2),   D = E h^3/(12 (1 - nu^2)),
/// up to `highest` (Hz). The table's surface is the upper face alone, in columns x rows squares.
inline ModalTable plate(double a = 0.32, double b = 0.2, double h = 0.005, double highest = 20000,
                        std::size_t columns = 32, std::size_t rows = 20) {
  constexpr double kPi = std::numbers::pi, kE = 70.3e9, kNu = 0.33, kRho = 2700;
  ModalTable table;
  table.body_name = "plate";
  table.boundary = "simply supported";
  table.free = false;
  table.material = {"aluminium", kE, kNu, kRho};
  table.mass_kg = kRho * a * b * h;
  const double factor = kPi / 2 * std::sqrt(kE * h * h * h / (12 * (1 - kNu * kNu)) / (kRho * h));
  std::multimap<double, std::pair<int, int>> modes;
  for (int m = 1; m < 60; ++m)
    for (int n = 1; n < 60; ++n) {
      const double f = factor * (m * m / (a * a) + n * n / (b * b));
      if (f < highest)
        modes.insert({f, {m, n}});
    }
  for (std::size_t k = 0; k <= rows; ++k)
    for (std::size_t i = 0; i <= columns; ++i)
      table.vertex_m.push_back({a * (static_cast<double>(i) / static_cast<double>(columns) - 0.5),
                                b * (static_cast<double>(k) / static_cast<double>(rows) - 0.5),
                                h / 2});
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < columns; ++i) {
      const auto p = static_cast<std::int32_t>(k * (columns + 1) + i);
      const auto r = static_cast<std::int32_t>(p + static_cast<std::int32_t>(columns) + 2);
      table.triangle.push_back({p, p + 1, r});
      table.triangle.push_back({p, r, r - 1});
    }
  for (const auto& [f, mn] : modes) {
    table.frequency_hz.push_back(f);
    table.loss_factor.push_back(1e-3);
    for (const Vec3& v : table.vertex_m) {
      table.shape.push_back(0);
      table.shape.push_back(0);
      table.shape.push_back(static_cast<float>(2 / std::sqrt(table.mass_kg) *
                                               std::sin(mn.first * kPi * (v.x / a + 0.5)) *
                                               std::sin(mn.second * kPi * (v.y / b + 0.5))));
    }
  }
  return table;
}

} // namespace tactus::test
