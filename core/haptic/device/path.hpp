#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

/// Paths of the simulated hand: position, velocity and buttons as functions of time.
namespace tactus::haptic {

struct PathPoint {
  Vec3 position{}; ///< m
  Vec3 velocity{}; ///< m/s
  std::uint32_t buttons = 0;
};

struct PathRow {
  double time_s;
  Vec3 position;
  std::uint32_t buttons;
};

/// A path through given points, linearly interpolated. The position is constant before the first
/// and after the last row. Buttons keep their state from their row to the next. Two rows with the
/// same time make a jump.
class RowPath {
public:
  /// Rows in order of time, as files/path_file.hpp reads them.
  explicit RowPath(std::vector<PathRow> rows) : rows_(std::move(rows)) {}
  [[nodiscard]] PathPoint at(double time_s) const noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return rows_.size(); }
  [[nodiscard]] double duration_s() const noexcept {
    return rows_.empty() ? 0 : rows_.back().time_s;
  }

private:
  std::vector<PathRow> rows_;
};

/// To and fro between two points: from + (to - from)(1 - cos(2 pi t / period)) / 2.
struct LinePath {
  Vec3 from{}, to{};
  double period_s = 1;
  [[nodiscard]] PathPoint at(double time_s) const noexcept;
};

/// A circle in the plane of the axes first and second (0, 1, 2 = x, y, z), from first to second:
/// centre + radius (cos(2 pi t / period) e_first + sin(2 pi t / period) e_second).
struct CirclePath {
  Vec3 centre{};
  double radius_m = 0.02, period_s = 1;
  int first = 0, second = 1;
  [[nodiscard]] PathPoint at(double time_s) const noexcept;
};

/// centre + amplitude sin(2 pi frequency t) on each axis.
struct LissajousPath {
  Vec3 centre{}, amplitude{}, frequency_hz{};
  [[nodiscard]] PathPoint at(double time_s) const noexcept;
};

using Path = std::variant<LinePath, CirclePath, LissajousPath, RowPath>;

[[nodiscard]] inline PathPoint point_at(const Path& path, double time_s) noexcept {
  return std::visit([time_s](const auto& shape) { return shape.at(time_s); }, path);
}

} // namespace tactus::haptic
