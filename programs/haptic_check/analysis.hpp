#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Pure functions that measure the device and the servo loop from a recording of the servo's ticks.
namespace tactus::haptic_check {

struct Record {
  std::uint64_t index = 0; ///< index of the tick on the servo's grid
  double time_s = 0;       ///< actual time of the tick
  Vec3 position{};         ///< m
  Vec3 velocity{};         ///< m/s
  Vec3 force_n{};          ///< sent force
  std::uint32_t buttons = 0, flags = 0;
};

/// The range of the handle's motion, and properties of the readings.
struct Motion {
  Vec3 lowest{}, highest{};
  double max_speed_m_per_s = 0;
  double changed_fraction = 0; ///< ticks whose reading differs from the previous one
  double min_step_m = 0;       ///< smallest distance of different readings
  std::uint32_t buttons = 0;   ///< all buttons that were pressed
};
[[nodiscard]] Motion motion_of(std::span<const Record> records) noexcept;

/// Intervals between ticks.
struct Intervals {
  static constexpr std::array<double, 8> kEdges_s{20e-6,  50e-6, 100e-6, 200e-6,
                                                  500e-6, 1e-3,  2e-3,   1e9};
  std::array<std::size_t, 8> counts{}; ///< histogram of deviations from the period
  double mean_s = 0, deviation_s = 0, max_s = 0;
  std::size_t number = 0;
};
[[nodiscard]] Intervals intervals_of(std::span<const Record> records, double period_s) noexcept;

/// A wall that pushes along a unit normal from a point on its face.
struct Wall {
  Vec3 point{}, normal{};
};
struct WallResult {
  double max_depth_m = 0, max_force_n = 0;
  double stiffness_n_per_m = 0; ///< slope of the sent force over the depth; 0 without contact
  double vibration_rms_m = 0;   ///< RMS of the motion in the wall around parabolas of 40 ms
  std::size_t ticks = 0;        ///< ticks in contact
};
/// Uses only the time after the motors have risen to full force, and excludes forces within 2 % of
/// limit_n.
[[nodiscard]] WallResult wall_result(std::span<const Record> records, const Wall& wall,
                                     double from_s, double limit_n, double period_s);

/// Amplitude and phase of x against the force's x at one frequency, by correlation over whole
/// periods.
struct Response {
  double frequency_hz = 0;
  double force_n = 0, motion_m = 0;
  double phase_rad = 0; ///< lag of the motion behind the force, -pi..pi
};
[[nodiscard]] Response response_at(std::span<const Record> records, double frequency_hz,
                                   double period_s) noexcept;

} // namespace tactus::haptic_check
