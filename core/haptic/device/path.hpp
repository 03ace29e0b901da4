#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

/// Where a simulated hand wants to be, as a function of time.
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

/// Rows joined by straight lines, the first and last held outside. Buttons hold from their row on.
/// Two rows of one time are a jump.
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

/// There and back between two points: position a + (b - a)(1 - cos(2 pi t / period)) / 2.
struct LinePath {
  Vec3 from{}, to{};
  double period_s = 1;
  [[nodiscard]] PathPoint at(double time_s) const noexcept;
};

/// Round a centre in the plane of axes first and second (0, 1, 2 = x, y, z), starting on first.
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
