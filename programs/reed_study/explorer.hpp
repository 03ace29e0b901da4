#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/device/simulated_device.hpp"

#include <cstdint>

namespace tactus::study {

/// The strategy of a simulated hand. Both strategies hold the handle like core/haptic's person:
/// spring, damper, tremor, and a target position that yields to a lasting force. Neither uses sound
/// or aims at a note, and the force does not change their sequence of movements.
enum class Strategy {
  kSearches, ///< moves to uniformly random positions in the plane, pausing at each
  kWanders,  ///< drifts around the plane's centre with slow noise
};

struct ExplorationSettings {
  Strategy strategy = Strategy::kSearches;
  // For kSearches.
  double speed_m_per_s = 0.03; ///< mean over a move; the peak is 15/8 of the mean
  double shortest_move_s = 0.5;
  double shortest_stay_s = 1, longest_stay_s = 3;
  // For kWanders.
  double wander_m = 0.025; ///< RMS per axis
  double wander_hz = 0.05;
  double arrival_s =
      8; ///< time in which the drift's centre moves from the start to the plane's centre
};

/// Moves a simulated hand from a given start.
class Explorer {
public:
  Explorer(const ExplorationSettings& exploration, std::uint64_t seed)
      : settings_(exploration), random_(seed) {}

  /// Returns `hand` as the simulated person who holds the handle; the person wanders only with
  /// kWanders.
  [[nodiscard]] haptic::HandSettings hand_settings(haptic::HandSettings hand) const;
  /// Places handle and target position at the start; call before the device's first tick.
  void begin(haptic::SimulatedDevice& device, const Vec3& start, double period_s) const;
  /// Call it at every tick, before the device is read.
  void advance(haptic::SimulatedDevice& device, double time_s);

private:
  ExplorationSettings settings_;
  Random random_;
  double next_move_s_ = 0;
};

} // namespace tactus::study
