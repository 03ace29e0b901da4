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

/// One foot's ground, made of a recipe: the sole's parts strike a floor with modes, boards creak,
/// grains and bubbles are set free by landings, by load that comes and goes, and by a sole that
/// slides. Each step draws a new place as it first lands: frequencies, decay times, strengths
/// differ a little from step to step.
///
/// Masses, energies and loads are proportional to the body's weight; deeper into soft ground takes
/// longer: the times of grains and bubbles grow with the root of the weight (a mass that lands on a
/// linear spring).
class Ground {
public:
  Ground();
  void prepare(double sample_rate) noexcept;
  /// What sounds goes on sounding under the new recipe. Shoe: hardness 0..1 (shoe.hpp).
  void set(const Recipe& recipe, double shoe) noexcept;
  /// Of the body, N; from the next landing on.
  void set_weight(double weight_n) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;

  struct Sound {
    double heel_vibration = 0,
           ball_vibration = 0; ///< the ground's motion under each, for the drives
    double pressure_pa = 0;    ///< sound pressure, Pa: what of their sum the air takes
  };
  /// One sample.
  Sound next(const SoleState& sole) noexcept;
  [[nodiscard]] bool silent() const noexcept { return silent_; }

private:
  /// Grains, bubbles or a rustle under the whole sole; how much of their energy is the heel's.
  struct Particles {
    particle::Cloud cloud;
    particle::EnergyStore heel; ///< as the cloud's own store, fed by the heel alone
  };
  static constexpr std::size_t kRegions = 2; ///< heel and ball
  void begin_step_variation() noexcept;
  void draw_contact_positions() noexcept;

  Recipe recipe_;
  double sample_rate_ = 48000, shoe_ = 0.4, weight_ = 1; ///< in reference weights
  double root_weight_ = 1; ///< of what is no lighter than the lightest
  Random random_;
  std::array<double, kMaxModes> detune_{};
  std::array<StruckFloor, kRegions> floor_;
  CreakingBoards boards_;
  std::array<Particles, kMaxClouds> particles_;
  double speed_factor_ = 1;
  double sole_factor_ = 1; ///< of particles between sole and floor, for a hard or soft sole
  double radiation_ = 0, radiation_gain_ = 0;
  double load_ = 0;                   ///< of the last sample, in reference weights
  bool heel_down_ = false;            ///< the heel has landed since the foot was last in the air
  bool has_contact_position_ = false; ///< one has been drawn since the last reset
  bool silent_ = true;
};

} // namespace tactus::footstep
