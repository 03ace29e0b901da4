#pragma once

#include "core/contact/friction.hpp"
#include "core/contact/impact.hpp"
#include "core/footstep/room.hpp"
#include "core/particle/cloud.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

/// Recipe: the parameters of a ground. Users write them as sections and `key value` lines
/// (docs/formats/surface.md), which files/recipe.hpp reads.
namespace tactus::footstep {

inline constexpr std::size_t kMaxModes = 32, kMaxClouds = 4, kMaxPatches = 8;
/// Weight to which the masses, energies and loads of a recipe refer, N.
inline constexpr double kReferenceWeight = 700;
/// Shoe to which the particle levels of a recipe refer: hard rubber.
inline constexpr double kReferenceShoe = 0.4;

/// Variation from step to step: standard deviations of the logarithms.
struct Scatter {
  double frequency = 0.05, decay = 0.1, level = 0.15;
};

/// Modes of a board, plate or slab. Mode i has the frequency f = frequency * ratio^i, varied by
/// `detune` (standard deviation of the logarithm), T60 = t60 (f/frequency)^-t60_tilt, and the
/// output gain (f/frequency)^-tilt times gains_db[i].
struct ModesRecipe {
  double count = 6, frequency_hz = 150, ratio = 1.4, detune = 0.05;
  double t60_s = 0.1, t60_tilt = 0.5, tilt = 0.5, mass_kg = 0.25;
  /// Standard deviation of the logarithm of a mode's shape at the contact point of a step.
  double mode_share_scatter = 0.3;
  std::array<double, kMaxModes> gains_db{};
};

/// A solid floor that the masses of heel and ball strike. `law` is the ground's contact law
/// (Hunt & Crossley), in series with the sole's (shoe.hpp).
struct SolidRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::ImpactLaw law{1e9, 1.5, 0.3};
  double heel_kg = 0.08, ball_kg = 0.05; ///< striking masses at kReferenceWeight
  double ball = 0.6;                     ///< factor on the gait's landing speed of the ball
  double patches = 4;                    ///< parts of the sole that land one after the other
  double unevenness_m = 0.004;           ///< mean height of the other parts when the first part
                                         ///< touches
  double roughness = 1;                  ///< roughness of a sliding sole, N^(1/2) s^(1/2)/m^(1/2)
  double level = 1;
  Scatter scatter;
};

/// Creaking boards: two boards rub in a joint that the load presses together, while the floor bends
/// as the load moves from heel to ball. The joint is a mass on a spring, without sound of its own;
/// its slips excite the modes of the boards.
struct FrictionRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::FrictionLaw law{0.8, 0.3, 0.06, 0.4, 8e4, 20, 0.4, 0};
  double joint_hz = 90, joint_kg = 0.1; ///< resonance frequency and mass of the joint
  double joint_t60_s = 0.05;
  double preload_n = 6;       ///< normal force in the joint without load
  double load_n = 20;         ///< added normal force under kReferenceWeight
  double slip_m_per_s = 0.02; ///< joint speed when the load bends the floor at 10 reference weights
                              ///< per second
  double wobble = 0.2;        ///< slow random variation of normal force and speed, relative
  double level = 1;
  Scatter scatter;
};

/// Grains, bubbles or a rustle, and the energy that the sole gives them.
struct CloudRecipe {
  particle::CloudSettings settings;
  double heel = 1, ball = 0.5;  ///< energy of a landing at 0.5 m/s; proportional to the speed
  double load = 0, release = 0; ///< energy per reference weight of rising and of falling load
  double slide = 10;            ///< energy per metre of sliding under one reference weight
  Scatter scatter;
};

struct Recipe {
  double level = 1;         ///< level of all sections: sound pressure at the walker's head, Pa
  double felt = 2;          ///< gain of the actuator signals, 1/Pa
  double felt_ball = 1;     ///< factor on the gain of the ball's actuator signal
  double radiation_hz = 40; ///< high-pass of the sound only: radiation of the floor
  /// As in Scatter, but common to all sections: for a wetter or firmer spot, or a different
  /// landing.
  double vary_frequency = 0, vary_decay = 0;
  SolidRecipe solid;
  FrictionRecipe friction;
  std::size_t clouds = 0;
  std::array<CloudRecipe, kMaxClouds> cloud{};
  Room::Settings room; ///< the usual room around this ground
};

/// One key of a section, for documents and tools.
struct RecipeKey {
  std::string_view section, name, unit;
  double lowest, highest;
  std::string_view text;
  double& (*member)(Recipe& recipe); ///< a cloud's key refers to the last cloud
};
[[nodiscard]] std::span<const RecipeKey> recipe_keys() noexcept;

} // namespace tactus::footstep
