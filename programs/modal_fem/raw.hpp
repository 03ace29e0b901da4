#pragma once
#include "core/modal/body/struck_body.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// Which velocities a raw table holds.
struct RawSettings {
  std::vector<Vec3> hit_m;   ///< points struck, along the surface's normal
  Vec3 side{0, 0, 1};        ///< the faces that look there radiate
  bool ring = false;         ///< one radius, each point standing for a whole ring
  double ring_angle_rad = 0; ///< of that radius, for side z from +x to +y
  std::size_t points = 200;  ///< about; 0: every triangle of the table
  double seconds = 0.5, sample_rate = 44100;
  double impulse_n_s = 0; ///< above 0: this impulse at time 0; else a striker at 1 m/s
  modal::Striker striker;
};

/// Normal velocities of surface elements after an impact, from a table's modes: the tables of the
/// AudioHaptics paper. The striker's force comes from the coupled contact at sixteen times the
/// sample rate (at most 1 MHz); modes above 0.45 of the sample rate are left out, as they would
/// alias; a free body's recoil is, too. Refuses points off the body and empty sides.
[[nodiscard]] modal::RawTable make_raw(const modal::ModalTable&, const RawSettings&);

/// `modal_fem raw TABLE ... -o OUT`: the words after `raw`. Returns the exit status.
int run_raw(const std::vector<std::string>& words);

/// The help text of it.
[[nodiscard]] std::string raw_usage();

} // namespace tactus::fem
