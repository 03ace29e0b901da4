#pragma once
#include "core/modal/body/struck_body.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// The velocities to store in a raw table.
struct RawSettings {
  std::vector<Vec3> hit_m;   ///< points struck, along the surface's normal
  Vec3 side{0, 0, 1};        ///< direction of the faces that radiate
  bool ring = false;         ///< points on one radius, each for a whole ring
  double ring_angle_rad = 0; ///< angle of that radius, for side z from +x to +y
  std::size_t points = 200;  ///< approximate number; 0 for every triangle of the table
  double seconds = 0.5, sample_rate = 44100;
  double impulse_n_s = 0; ///< if above 0, this impulse at time 0 replaces the striker at 1 m/s
  modal::Striker striker;
};

/// Normal velocities of surface elements after an impact, from a table's modes: the tables of the
/// AudioHaptics paper. The striker's force comes from the coupled contact at sixteen times the
/// sample rate (at most 1 MHz). Modes above 0.45 of the sample rate are omitted, since they would
/// alias. A free body's recoil is omitted too. Refuses points that are not on the body and sides
/// without faces.
[[nodiscard]] modal::RawTable make_raw(const modal::ModalTable&, const RawSettings&);

/// Runs `modal_fem raw TABLE ... -o OUT` with the words after `raw`. Returns the exit status.
int run_raw(const std::vector<std::string>& words);

/// The help text of `modal_fem raw`.
[[nodiscard]] std::string raw_usage();

} // namespace tactus::fem
