#include "core/footstep/recipe.hpp"

namespace tactus::footstep {
namespace {

CloudRecipe& last(Recipe& recipe) { return recipe.cloud[recipe.clouds - 1]; }

// Members of a recipe and string literals: parentheses around them would be no C++.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define MEMBER(member) [](Recipe& r) -> double& { return r.member; }
#define CLOUD_MEMBER(member) [](Recipe& r) -> double& { return last(r).member; }
#define SCATTER(section, part)                                                                     \
  RecipeKey{section,                                                                               \
            "vary_frequency",                                                                      \
            "",                                                                                    \
            0,                                                                                     \
            2,                                                                                     \
            "of each step: its frequencies",                                                       \
            MEMBER(part.scatter.frequency)},                                                       \
      RecipeKey{section,                                                                           \
                "vary_decay",                                                                      \
                "",                                                                                \
                0,                                                                                 \
                2,                                                                                 \
                "of each step: its decay times",                                                   \
                MEMBER(part.scatter.decay)},                                                       \
      RecipeKey {                                                                                  \
    section, "vary_level", "", 0, 2, "of each step: its strength", MEMBER(part.scatter.level)      \
  }
#define MODES(section, part)                                                                       \
  RecipeKey{section, "modes", "", 1, kMaxModes, "number of modes", MEMBER(part.modes.count)},      \
      RecipeKey{section,                                                                           \
                "frequency",                                                                       \
                "Hz",                                                                              \
                20,                                                                                \
                12000,                                                                             \
                "of the lowest mode",                                                              \
                MEMBER(part.modes.frequency_hz)},                                                  \
      RecipeKey{section, "ratio", "", 1.01, 4, "from mode to mode", MEMBER(part.modes.ratio)},     \
      RecipeKey{section, "detune", "", 0, 1, "how irregular they are", MEMBER(part.modes.detune)}, \
      RecipeKey{section,                                                                           \
                "t60",                                                                             \
                "s",                                                                               \
                0.001,                                                                             \
                20,                                                                                \
                "decay time of the lowest mode",                                                   \
                MEMBER(part.modes.t60_s)},                                                         \
      RecipeKey{section, "t60_tilt", "", -2, 3, "T60 ~ f^-this", MEMBER(part.modes.t60_tilt)},     \
      RecipeKey{section, "tilt", "", -3, 4, "loudness ~ f^-this", MEMBER(part.modes.tilt)},        \
      RecipeKey{section, "mass", "kg", 0.001, 1000, "of each mode", MEMBER(part.modes.mass_kg)},   \
      RecipeKey {                                                                                  \
    section, "place", "", 0, 2, "how the place of the step changes the modes' shares",             \
        MEMBER(part.modes.mode_share_scatter)                                                      \
  }
#define EVENTS(section)                                                                            \
  RecipeKey{section,                                                                               \
            "count",                                                                               \
            "",                                                                                    \
            0,                                                                                     \
            50000,                                                                                 \
            "events for each unit of energy",                                                      \
            CLOUD_MEMBER(settings.count)},                                                         \
      RecipeKey{section,                                                                           \
                "exponent",                                                                        \
                "",                                                                                \
                0.05,                                                                              \
                20,                                                                                \
                "of the event energies' power law",                                                \
                CLOUD_MEMBER(settings.exponent)},                                                  \
      RecipeKey{section,                                                                           \
                "largest",                                                                         \
                "",                                                                                \
                1.001,                                                                             \
                1e6,                                                                               \
                "event over the smallest, in energy",                                              \
                CLOUD_MEMBER(settings.largest)},                                                   \
      RecipeKey {                                                                                  \
    section, "lower_by_size", "", 0, 2, "frequency ~ event energy^-this",                          \
        CLOUD_MEMBER(settings.lower_by_size)                                                       \
  }
#define CLOUD(section)                                                                             \
  RecipeKey{section,                                                                               \
            "attack",                                                                              \
            "s",                                                                                   \
            1e-4,                                                                                  \
            5,                                                                                     \
            "in which a landing's energy arrives",                                                 \
            CLOUD_MEMBER(settings.attack_s)},                                                      \
      RecipeKey{section,                                                                           \
                "decay",                                                                           \
                "s",                                                                               \
                1e-4,                                                                              \
                10,                                                                                \
                "in which it dies down",                                                           \
                CLOUD_MEMBER(settings.decay_s)},                                                   \
      RecipeKey{                                                                                   \
          section, "frequency", "Hz", 20, 20000, "median", CLOUD_MEMBER(settings.frequency_hz)},   \
      RecipeKey{section,                                                                           \
                "spread",                                                                          \
                "",                                                                                \
                0,                                                                                 \
                3,                                                                                 \
                "standard deviation of its logarithm",                                             \
                CLOUD_MEMBER(settings.spread)},                                                    \
      RecipeKey{                                                                                   \
          section, "level", "", 0, 1e4, "strength of the sound", CLOUD_MEMBER(settings.level)},    \
      RecipeKey{section,           "heel", "", 0, 100, "energy of the heel's landing at 0.5 m/s",  \
                CLOUD_MEMBER(heel)},                                                               \
      RecipeKey{section,           "ball", "", 0, 100, "energy of the ball's landing at 0.5 m/s",  \
                CLOUD_MEMBER(ball)},                                                               \
      RecipeKey{                                                                                   \
          section, "load", "", 0, 100, "energy for each 700 N that come", CLOUD_MEMBER(load)},     \
      RecipeKey{                                                                                   \
          section, "release", "", 0, 100, "energy for each 700 N that go", CLOUD_MEMBER(release)}, \
      RecipeKey{section,                                                                           \
                "slide",                                                                           \
                "",                                                                                \
                0,                                                                                 \
                1000,                                                                              \
                "energy for each metre slid under 700 N",                                          \
                CLOUD_MEMBER(slide)},                                                              \
      RecipeKey{section,                                                                           \
                "vary_frequency",                                                                  \
                "",                                                                                \
                0,                                                                                 \
                2,                                                                                 \
                "of each step: its frequencies",                                                   \
                CLOUD_MEMBER(scatter.frequency)},                                                  \
      RecipeKey{section,                                                                           \
                "vary_decay",                                                                      \
                "",                                                                                \
                0,                                                                                 \
                2,                                                                                 \
                "of each step: its decay",                                                         \
                CLOUD_MEMBER(scatter.decay)},                                                      \
      RecipeKey {                                                                                  \
    section, "vary_level", "", 0, 2, "of each step: its strength", CLOUD_MEMBER(scatter.level)     \
  }

// NOLINTEND(bugprone-macro-parentheses)

constexpr RecipeKey kKeys[] = {
    {"", "level", "", 0, 1e4, "of the whole, heard and felt", MEMBER(level)},
    {"", "felt", "1/Pa", 0, 1e4, "drives for the sound pressure of the whole", MEMBER(felt)},
    {"", "felt_ball", "", 0, 100, "of the drive under the ball", MEMBER(felt_ball)},
    {"", "radiation", "Hz", 1, 8000, "below, less and less is heard", MEMBER(radiation_hz)},
    {"", "vary_frequency", "", 0, 2, "of each step: all sections' frequencies alike",
     MEMBER(vary_frequency)},
    {"", "vary_decay", "", 0, 2, "of each step: all sections' decay times alike",
     MEMBER(vary_decay)},
    MODES("solid", solid),
    {"solid", "stiffness", "N/m^exponent", 1, 1e15, "of the ground itself; the sole's is in series",
     MEMBER(solid.law.stiffness)},
    {"solid", "exponent", "", 1, 6, "of the contact", MEMBER(solid.law.exponent)},
    {"solid", "dissipation", "s/m", 0, 100, "of the ground itself",
     MEMBER(solid.law.dissipation_s_per_m)},
    {"solid", "heel", "kg", 1e-4, 100, "mass that lands with the heel", MEMBER(solid.heel_kg)},
    {"solid", "ball_mass", "kg", 1e-4, 100, "mass that lands with the ball", MEMBER(solid.ball_kg)},
    {"solid", "ball", "", 0, 10, "times the ball's landing speed", MEMBER(solid.ball)},
    {"solid", "patches", "", 1, kMaxPatches, "parts of the sole that touch one after the other",
     MEMBER(solid.patches)},
    {"solid", "unevenness", "m", 0, 0.1, "mean height of the later ones when the first touches",
     MEMBER(solid.unevenness_m)},
    {"solid", "roughness", "N^.5 s^.5/m^.5", 0, 1e3, "of a sole that slides",
     MEMBER(solid.roughness)},
    {"solid", "level", "", 0, 1e4, "strength of the sound", MEMBER(solid.level)},
    SCATTER("solid", solid),
    MODES("friction", friction),
    {"friction", "mu_s", "", 0.01, 10, "static coefficient",
     MEMBER(friction.law.static_coefficient)},
    {"friction", "mu_d", "", 0.01, 10, "dynamic coefficient",
     MEMBER(friction.law.dynamic_coefficient)},
    {"friction", "stribeck", "m/s", 1e-4, 10, "speed at which it lets go",
     MEMBER(friction.law.stribeck_m_per_s)},
    {"friction", "breakaway", "", 0.01, 0.99, "elastic share", MEMBER(friction.law.breakaway)},
    {"friction", "stiffness", "N/m", 1, 1e9, "of the bristles",
     MEMBER(friction.law.stiffness_n_per_m)},
    {"friction", "damping", "N s/m", 0, 1e5, "of the bristles",
     MEMBER(friction.law.damping_ns_per_m)},
    {"friction", "viscosity", "N s/m", 0, 1e4, "between the surfaces",
     MEMBER(friction.law.viscosity_ns_per_m)},
    {"friction", "roughness", "N^.5 s^.5/m^.5", 0, 1e3, "of the surfaces",
     MEMBER(friction.law.roughness)},
    {"friction", "pressed", "N", 0, 1e4, "in the joint without load", MEMBER(friction.preload_n)},
    {"friction", "joint", "Hz", 5, 2000, "the joint's mass on its spring",
     MEMBER(friction.joint_hz)},
    {"friction", "joint_mass", "kg", 0.001, 100, "of the joint", MEMBER(friction.joint_kg)},
    {"friction", "joint_t60", "s", 0.001, 5, "decay time of the joint",
     MEMBER(friction.joint_t60_s)},
    {"friction", "load", "N", 0, 1e4, "more under 700 N", MEMBER(friction.load_n)},
    {"friction", "slip", "m/s", 0, 10, "while 7000 N/s move from heel to ball",
     MEMBER(friction.slip_m_per_s)},
    {"friction", "wobble", "", 0, 2, "slow unevenness of pressure and slip",
     MEMBER(friction.wobble)},
    {"friction", "level", "", 0, 1e4, "strength of the sound", MEMBER(friction.level)},
    SCATTER("friction", friction),
    EVENTS("grains"),
    CLOUD("grains"),
    {"grains", "quality", "", 0.1, 200, "Q of a grain's band-pass", CLOUD_MEMBER(settings.quality)},
    {"grains", "length", "s", 1e-5, 1, "median of a grain's decay",
     CLOUD_MEMBER(settings.length_s)},
    EVENTS("bubbles"),
    CLOUD("bubbles"),
    {"bubbles", "rise", "", 0, 1, "of a bubble's pitch", CLOUD_MEMBER(settings.rise)},
    CLOUD("rustle"),
    {"rustle", "quality", "", 0.1, 200, "Q of its band-passes", CLOUD_MEMBER(settings.quality)},
    {"room", "level", "dB", Room::kMinLevel, 40, "energy of its answer over the direct sound's",
     MEMBER(room.level_db)},
    {"room", "t60", "s", 0.02, 10, "decay time", MEMBER(room.t60_s)},
    {"room", "bright", "Hz", 100, 20000, "where the decay time is half", MEMBER(room.bright_hz)},
};

#undef MEMBER
#undef CLOUD_MEMBER
#undef SCATTER
#undef MODES
#undef EVENTS
#undef CLOUD

} // namespace

std::span<const RecipeKey> recipe_keys() noexcept { return kKeys; }

} // namespace tactus::footstep
