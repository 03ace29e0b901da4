#pragma once

#include "core/modal/table/modal_table.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

/// Modal tables of bodies whose modes are known in closed form.
namespace tactus::test {

using modal::ModalTable;

/// Modes without a shape, held: each has the gain of 1 kg.
inline ModalTable mode_table(const std::vector<double>& hz, double decay_per_s = 5) {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  table.frequency_hz = hz;
  table.decay_rate.assign(hz.size(), decay_per_s);
  return table;
}

/// So many of them between 50 Hz and 19 kHz.
inline ModalTable many_modes_table(std::size_t count) {
  std::vector<double> hz;
  for (std::size_t k = 0; k < count; ++k)
    hz.push_back(50 + 19000. * static_cast<double>(k) / static_cast<double>(count));
  return mode_table(hz);
}

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
      const double w = 2 / std::sqrt(table.mass_kg) * std::sin(mn.first * kPi * (v.x / a + 0.5)) *
                       std::sin(mn.second * kPi * (v.y / b + 0.5));
      table.shape.insert(table.shape.end(), {0, 0, static_cast<float>(w)});
    }
  }
  return table;
}

/// The same modes of a plate that nothing holds: it recoils too.
inline ModalTable free_plate(double a = 0.2, double b = 0.15, double h = 0.005,
                             double highest = 30000, std::size_t columns = 32,
                             std::size_t rows = 20) {
  ModalTable table = plate(a, b, h, highest, columns, rows);
  table.free = true;
  const double twelfth = table.mass_kg / 12;
  table.inertia_kg_m2 = {Vec3{twelfth * b * b, 0, 0}, Vec3{0, twelfth * a * a, 0},
                         Vec3{0, 0, twelfth * (a * a + b * b)}};
  return table;
}

/// A free bar along x of Euler and Bernoulli, of both faces: cos(b) cosh(b) = 1,
/// f = (b/L)^2 sqrt(E h^2/(12 rho))/(2 pi).
inline ModalTable free_bar(double length, double width, double height, double highest,
                           double young = 70.3e9, double density = 2700) {
  constexpr double kPi = std::numbers::pi;
  constexpr std::int32_t kColumns = 80;
  ModalTable table;
  table.body_name = "bar";
  table.free = true;
  table.material = {"", young, 0.33, density};
  const double mass = table.mass_kg = density * length * width * height;
  table.inertia_kg_m2 = {Vec3{mass / 12 * (width * width + height * height), 0, 0},
                         Vec3{0, mass / 12 * (length * length + height * height), 0},
                         Vec3{0, 0, mass / 12 * (length * length + width * width)}};
  for (const double z : {0.5, -0.5})
    for (std::int32_t i = 0; i <= kColumns; ++i)
      for (const double y : {-0.5, 0.5})
        table.vertex_m.push_back(
            {length * (static_cast<double>(i) / kColumns - 0.5), y * width, z * height});
  for (const std::int32_t face : {0, 2 * (kColumns + 1)})
    for (std::int32_t i = face; i < face + 2 * kColumns; i += 2) {
      const auto add = [&](std::int32_t one, std::int32_t two) { // seen from outside
        table.triangle.push_back({i, face == 0 ? one : two, face == 0 ? two : one});
      };
      add(i + 2, i + 3);
      add(i + 3, i + 1);
    }
  for (int n = 1;; ++n) {
    double b = (n + 0.5) * kPi;
    for (int i = 0; i < 5; ++i) // Newton's method
      b -= (std::cos(b) - 1 / std::cosh(b)) / (-std::sin(b) + std::tanh(b) / std::cosh(b));
    const double f =
        b * b / (length * length) * std::sqrt(young * height * height / (12 * density)) / (2 * kPi);
    if (f > highest)
      return table;
    table.frequency_hz.push_back(f);
    table.loss_factor.push_back(1e-3);
    const double sigma = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
    for (const Vec3& v : table.vertex_m) {
      const double x = b * (v.x / length + 0.5);
      // cosh - sigma sinh without the difference of large numbers
      const double grown = 0.5 * std::exp(x) * (1 - sigma) + 0.5 * std::exp(-x) * (1 + sigma);
      const double w = (grown + std::cos(x) - sigma * std::sin(x)) / std::sqrt(mass);
      table.shape.insert(table.shape.end(), {0, 0, static_cast<float>(w)});
    }
  }
}

} // namespace tactus::test
