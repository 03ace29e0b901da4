#pragma once

#include "core/haptic/chain/chain.hpp"
#include "core/reed/playability/gradient.hpp"
#include "core/reed/playability/guidance.hpp"
#include "core/reed/playability/playability_map.hpp"
#include "programs/reed_study/explorer.hpp"

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace tactus::study {

/// The force on the hand.
enum class Feel {
  kOff,
  kReeds,    ///< slope of f_p over five reeds, as in the paper
  kGrowth,   ///< slope of tanh(g/50), g the growth rate of linear theory
  kHeight,   ///< slope of GrowthMap's height, which also has a slope in silent regions
  kGuidance, ///< Guidance over the same map
};
inline constexpr std::array<std::string_view, 5> kFeels{"off", "reeds", "growth", "height",
                                                        "guidance"};

/// An instrument, its plane, and its maps computed in advance.
struct World {
  World(const reed::Parameters& parameters, const reed::ControlRange& range);

  reed::Parameters parameters;
  reed::ControlRange range;
  reed::PlayabilityMap played; ///< f_p from rest; the study starts where it is silent
  reed::GrowthMap theory;
  reed::GradientField growth; ///< tanh(g/50)
  reed::GuidanceField guidance;
};

struct TrialSettings {
  Feel feel = Feel::kOff;
  std::uint64_t seed = 1;
  double duration_s = 60;
  double ceiling_n = 1; ///< F_max of each axis for slopes, of the vector for guidance
  double gain_n = 0.3;  ///< gain of slopes
  haptic::HandSettings hand{};
  ExplorationSettings exploration{};
};

/// A note plays while f_p > 0.3. It is found or lost once this has been true or false for 0.1 s.
inline constexpr double kPlays = 0.3, kMinDuration_s = 0.1;

struct TrialResult {
  double playing = 0;         ///< share of the time with a note
  int losses = 0;             ///< notes lost
  double first_s = 0;         ///< time until the first note; the whole duration if there is none
  double silence_s = 0;       ///< mean time from losing (or the start) to finding a note
  double force_n = 0;         ///< mean size of the force on the handle
  double playing_force_n = 0; ///< mean size of the force while a note plays
  double speed_m_per_s = 0;   ///< mean; if well above that without force, the force shakes the hand
  int played_cells = 0;       ///< number of squares, a tenth of the plane's side, with a note
};

struct Sample {
  double time_s, y, z, playability, force_y_n, force_z_n;
};

/// One trial; with a trace, its state every 10 ms.
TrialResult run(const World& world, const TrialSettings& settings,
                std::vector<Sample>* trace = nullptr);

} // namespace tactus::study
