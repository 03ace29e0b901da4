#pragma once

#include "core/contact/friction.hpp"
#include "core/contact/impact.hpp"
#include "core/footstep/room.hpp"
#include "core/particle/cloud.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// What a ground is made of, as users write it down: a text of sections and `key value` lines.
namespace tactus::footstep {

inline constexpr std::size_t kMostModes = 32, kMostClouds = 4;

/// How far each step differs from the next: standard deviations of logarithms.
struct Scatter {
  double frequency = 0.05, decay = 0.1, level = 0.15;
};

/// Modes of a board, plate or slab: frequency * ratio^i, each detuned by `detune`, with
/// T60 = t60 (f/frequency)^-t60_tilt, heard with gain (f/frequency)^-tilt and the list `gains`.
struct ModesRecipe {
  double count = 6, frequency_hz = 150, ratio = 1.4, detune = 0.05;
  double t60_s = 0.1, t60_tilt = 0.5, tilt = 0.5, mass_kg = 0.25;
  double place = 0.3; ///< log. standard deviation of a mode's share in a step: no two places alike
  std::array<double, kMostModes> gains_db{};
};

/// The floor as a whole, met by the masses of heel and ball under Hunt & Crossley's law.
struct SolidRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::ImpactLaw law{1e7, 1.5, 0.3};
  double heel_kg = 0.08, ball_kg = 0.05;
  double ball = 0.6; ///< landing speed of the ball, times what the gait says
  double level = 1;
  Scatter scatter;
};

/// Boards that rub: a bristle contact driven by the weight as it moves onto the foot.
struct FrictionRecipe {
  bool present = false;
  ModesRecipe modes;
  contact::FrictionLaw law{0.8, 0.3, 0.06, 0.4, 8e4, 20, 0.4, 0};
  double pressed_n = 6;      ///< in the joint without load
  double load_n = 20;        ///< more under one body's weight
  double slip_m_per_s = 0.1; ///< while the load grows by 10 weights a second
  double wobble = 0.2;       ///< slow unevenness of pressure and slip, relative
  double level = 1;
  Scatter scatter;
};

/// Grains, bubbles or a rustle: what gives them energy.
struct CloudRecipe {
  particle::CloudSettings settings;
  double heel = 1, ball = 0.5;  ///< for a landing at 0.5 m/s; grows with its square
  double load = 0, release = 0; ///< for each body weight that comes and goes
  Scatter scatter;
};

struct Recipe {
  double level = 1;
  double radiation_hz = 40; ///< below, the floor radiates less and less; it is felt all the same
  /// As Scatter, but of all sections alike: wetter or firmer ground, another way to land.
  double vary_frequency = 0, vary_decay = 0;
  SolidRecipe solid;
  FrictionRecipe friction;
  std::size_t clouds = 0;
  std::array<CloudRecipe, kMostClouds> cloud{};
  Room::Settings room; ///< where one usually meets that ground
};

/// Reads a recipe. Lines: `level 1` before any section; `[solid]`, `[friction]`, `[grains]`,
/// `[bubbles]` and `[rustle]` (together up to four of these three), `[room]`, then `key value` in
/// the units that docs/footstep.md lists; `#` begins a comment. Returns an empty text, or one
/// sentence that names line, key, value and what was expected; `recipe` is then unchanged.
[[nodiscard]] std::string read_recipe(std::string_view text, Recipe& recipe);

/// One key of a section, for documents and tools.
struct RecipeKey {
  std::string_view section, name, unit;
  double lowest, highest;
  std::string_view text;
  double& (*place)(Recipe& recipe); ///< in the cloud read last, where it is one of a cloud's
};
[[nodiscard]] std::span<const RecipeKey> recipe_keys() noexcept;

} // namespace tactus::footstep
