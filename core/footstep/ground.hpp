#pragma once

#include "core/dsp/random.hpp"
#include "core/footstep/creaking_boards.hpp"
#include "core/footstep/recipe.hpp"
#include "core/footstep/step_event.hpp"
#include "core/footstep/struck_floor.hpp"
#include "core/particle/cloud.hpp"
#include "core/particle/energy_store.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::footstep {

/// The ground under one foot, built from a Recipe: forces and landings of the sole in, sound
/// pressure and vibration out.
///
/// The parts of the sole strike a floor with modes (StruckFloor). Boards creak under the load
/// (CreakingBoards). Grains, bubbles and rustles are driven by landings, by changes of the load and
/// by sliding (particle::Cloud). At the first landing of each step, frequencies, decay times,
/// levels and contact points are drawn again, so that no two steps are identical.
///
/// Masses, energies and loads are proportional to the body's weight. The times of particles grow
/// with its square root, as for a mass that lands on a linear spring.
class Ground {
public:
  Ground();
  void prepare(double sample_rate) noexcept;
  /// Sounds in progress continue under the new recipe. `shoe`: hardness 0..1 (shoe.hpp).
  void set(const Recipe& recipe, double shoe) noexcept;
  /// Weight of the body, N; takes effect with the next landing.
  void set_weight(double weight_n) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;

  struct Sound {
    double heel_vibration = 0, ball_vibration = 0; ///< vibration under each part, for the actuator
                                                   ///< signals
    double pressure_pa = 0; ///< sound pressure: high-pass of their sum at radiation_hz
  };
  /// Computes one sample.
  Sound next(const SoleState& sole) noexcept;
  [[nodiscard]] bool silent() const noexcept { return silent_; }

private:
  /// Grains, bubbles or a rustle under the whole sole.
  struct Particles {
    particle::Cloud cloud;
    particle::EnergyStore heel; ///< the part of the cloud's energy that came from the heel
  };
  static constexpr std::size_t kRegions = 2; ///< heel and ball
  using Vibration = std::array<double, kRegions>;
  /// Load in reference weights, and its derivative in reference weights per second.
  struct Load {
    double heel, ball, heel_slope, ball_slope;
  };
  void begin_step_variation() noexcept;
  void draw_contact_positions() noexcept;
  // Each function adds one sample of a kind of source to `vibration`, and returns false if the
  // source is silent.
  [[nodiscard]] bool add_floor(const SoleState& sole, Vibration& vibration) noexcept;
  [[nodiscard]] bool add_boards(const Load& load, Vibration& vibration) noexcept;
  [[nodiscard]] bool add_particles(const SoleState& sole, const Load& load,
                                   Vibration& vibration) noexcept;

  Recipe recipe_;
  double sample_rate_ = 48000, shoe_ = 0.4, weight_ = 1; ///< weight_: in reference weights
  double root_weight_ = 1; ///< square root of the weight, which is at least kMinWeight here
  Random random_;
  std::array<double, kMaxModes> detune_{};
  std::array<StruckFloor, kRegions> floor_;
  CreakingBoards boards_;
  std::array<Particles, kMaxClouds> particles_;
  double speed_factor_ = 1;
  double sole_factor_ = 1; ///< level of the particles between sole and floor, by hardness
  double radiation_ = 0, radiation_gain_ = 0;
  double load_ = 0;                   ///< load of the last sample, in reference weights
  double heel_share_ = 0;             ///< heel's share of the load, or of the last load
  bool heel_down_ = false;            ///< the heel has landed since the foot was in the air
  bool has_contact_position_ = false; ///< contact points have been drawn since the last reset
  bool silent_ = true;
};

} // namespace tactus::footstep
