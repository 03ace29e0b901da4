#pragma once

#include "core/contact/friction.hpp"
#include "core/contact/impact.hpp"
#include "core/footstep/room.hpp"
#include "core/particle/cloud.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

/// What a ground is made of, as users write it down (files/recipe.hpp).
namespace tactus::footstep {

inline constexpr std::size_t kMaxModes = 32, kMaxClouds = 4, kMaxPatches = 8;
/// The weight for which a recipe's masses, energies and loads are written, N.
inline constexpr double kReferenceWeight = 700;
/// The shoe for which the levels of its particles are: hard rubber.
inline constexpr double kReferenceShoe = 0.4;

/// How far each step differs from the next: standard deviations of logarithms.
struct Scatter {
  double frequency = 0.05, decay = 0.1, level = 0.15;
};

/// Modes of a board, plate or slab: frequency * ratio^i, each detuned by `detune`, with
/// T60 = t60 (f/frequency)^-t60_tilt, heard with gain (f/frequency)^-tilt and the list `gains`.
struct ModesRecipe {
  double count = 6, frequency_hz = 150, ratio = 1.4, detune = 0.05;
  double t60_s = 0.1, t60_tilt = 0.5, tilt = 0.5, mass_kg = 0.25;
  double mode_share_scatter =
      0.3; ///< log. standard deviation of a mode's share in a step: no two places alike
  std::array<double, kMaxModes> gains_db{};
};

/// The floor as a whole, met by the masses of heel and ball under Hunt & Crossley's law: the
/// ground's own, in series with the shoe's (shoe.hpp).
struct SolidRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::ImpactLaw law{1e9, 1.5, 0.3};
  double heel_kg = 0.08, ball_kg = 0.05; ///< under a body of kReferenceWeight
  double ball = 0.6;                     ///< landing speed of the ball, times what the gait says
  double patches = 4;                    ///< parts of the sole that touch one after the other
  double unevenness_m = 0.004;           ///< mean height of the later ones when the first touches
  double roughness = 1;                  ///< of a sole that slides, N^(1/2) s^(1/2)/m^(1/2)
  double level = 1;
  Scatter scatter;
};

/// Boards that creak: two of them rub in a joint that the foot's load presses together, while the
/// floor bends as the load moves from heel to ball. The joint gives way as one mass on a spring (it
/// is felt, not heard) until the bristles let go: the slips excite the boards' modes.
struct FrictionRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::FrictionLaw law{0.8, 0.3, 0.06, 0.4, 8e4, 20, 0.4, 0};
  double joint_hz = 90, joint_kg = 0.1; ///< spring and mass of the joint
  double joint_t60_s = 0.05;
  double preload_n = 6;       ///< in the joint without load
  double load_n = 20;         ///< more under kReferenceWeight
  double slip_m_per_s = 0.02; ///< while 10 reference weights a second move from heel to ball
  double wobble = 0.2;        ///< slow unevenness of pressure and slip, relative
  double level = 1;
  Scatter scatter;
};

/// Grains, bubbles or a rustle: what gives them energy.
struct CloudRecipe {
  particle::CloudSettings settings;
  double heel = 1, ball = 0.5;  ///< for a landing at 0.5 m/s; grows with the speed
  double load = 0, release = 0; ///< for each reference weight that comes and goes
  double slide = 10;            ///< for each metre that the sole slides under one reference weight
  Scatter scatter;
};

struct Recipe {
  double level = 1;         ///< of all sections: sound pressure at the walker's ears, Pa
  double felt = 2;          ///< of the drives, 1/Pa
  double felt_ball = 1;     ///< of the ball's drive, times the heel's
  double radiation_hz = 40; ///< below, the floor radiates less and less; it is felt all the same
  /// As Scatter, but of all sections alike: wetter or firmer ground, another way to land.
  double vary_frequency = 0, vary_decay = 0;
  SolidRecipe solid;
  FrictionRecipe friction;
  std::size_t clouds = 0;
  std::array<CloudRecipe, kMaxClouds> cloud{};
  Room::Settings room; ///< where one usually meets that ground
};

/// One key of a section, for documents and tools.
struct RecipeKey {
  std::string_view section, name, unit;
  double lowest, highest;
  std::string_view text;
  double& (*member)(Recipe& recipe); ///< in the cloud read last, where it is one of a cloud's
};
[[nodiscard]] std::span<const RecipeKey> recipe_keys() noexcept;

} // namespace tactus::footstep
