#include "core/footstep/recipe.hpp"

#include <algorithm>
#include <utility>

namespace tactus::footstep {
namespace {

/// A key without its section, because several sections have parts of the same kind.
template <class Part> struct PartKey {
  std::string_view name, unit;
  double lowest, highest;
  std::string_view text;
  double Part::*member;
};

constexpr PartKey<Recipe> kWhole[] = {
    {"level", "", 0, 1e4, "gain of the whole: sound and actuators", &Recipe::level},
    {"felt", "1/Pa", 0, 1e4, "actuator signal for 1 Pa of the whole's sound pressure",
     &Recipe::felt},
    {"felt_ball", "", 0, 100, "gain of the actuator under the ball", &Recipe::felt_ball},
    {"radiation", "Hz", 1, 8000, "cut-off frequency of the floor's radiation",
     &Recipe::radiation_hz},
    {"vary_frequency", "", 0, 2,
     "variation of all frequencies from step to step, common to all sections",
     &Recipe::vary_frequency},
    {"vary_decay", "", 0, 2,
     "variation of all decay times from step to step, common to all sections",
     &Recipe::vary_decay}};

constexpr PartKey<ModesRecipe> kModes[] = {
    {"modes", "", 1, kMaxModes, "number of modes", &ModesRecipe::count},
    {"frequency", "Hz", 20, 12000, "frequency of the lowest mode", &ModesRecipe::frequency_hz},
    {"ratio", "", 1.01, 4, "frequency ratio of one mode to the one below", &ModesRecipe::ratio},
    {"detune", "", 0, 1, "irregularity of the frequencies", &ModesRecipe::detune},
    {"t60", "s", 0.001, 20, "decay time of the lowest mode", &ModesRecipe::t60_s},
    {"t60_tilt", "", -2, 3, "exponent of the decay times: T60 ~ f^-this", &ModesRecipe::t60_tilt},
    {"tilt", "", -3, 4, "exponent of the loudness: ~ f^-this", &ModesRecipe::tilt},
    {"mass", "kg", 0.001, 1000, "modal mass of each mode", &ModesRecipe::mass_kg},
    {"place", "", 0, 2, "variation of the modes' shares with the place of the step",
     &ModesRecipe::mode_share_scatter}};

constexpr PartKey<Scatter> kScatter[] = {
    {"vary_frequency", "", 0, 2, "variation of the section's frequencies from step to step",
     &Scatter::frequency},
    {"vary_decay", "", 0, 2, "variation of the section's decay times from step to step",
     &Scatter::decay},
    {"vary_level", "", 0, 2, "variation of the section's strength from step to step",
     &Scatter::level}};

constexpr PartKey<contact::ImpactLaw> kImpact[] = {
    {"stiffness", "N/m^exponent", 1, 1e15,
     "contact stiffness of the ground, in series with the sole's", &contact::ImpactLaw::stiffness},
    {"exponent", "", 1, 6, "exponent of the contact law", &contact::ImpactLaw::exponent},
    {"dissipation", "s/m", 0, 100, "contact dissipation of the ground",
     &contact::ImpactLaw::dissipation_s_per_m}};

constexpr PartKey<SolidRecipe> kSolid[] = {
    {"heel", "kg", 1e-4, 100, "striking mass of the heel", &SolidRecipe::heel_kg},
    {"ball_mass", "kg", 1e-4, 100, "striking mass of the ball", &SolidRecipe::ball_kg},
    {"ball", "", 0, 10, "factor on the ball's landing speed", &SolidRecipe::ball},
    {"patches", "", 1, kMaxPatches, "number of parts of the sole that touch one after the other",
     &SolidRecipe::patches},
    {"unevenness", "m", 0, 0.1, "mean height of the later parts when the first touches",
     &SolidRecipe::unevenness_m},
    {"roughness", "N^.5 s^.5/m^.5", 0, 1e3, "friction noise of a sliding sole",
     &SolidRecipe::roughness},
    {"level", "", 0, 1e4, "strength of the sound", &SolidRecipe::level}};

constexpr PartKey<contact::FrictionLaw> kRubbing[] = {
    {"mu_s", "", 0.01, 10, "static friction coefficient",
     &contact::FrictionLaw::static_coefficient},
    {"mu_d", "", 0.01, 10, "dynamic friction coefficient",
     &contact::FrictionLaw::dynamic_coefficient},
    {"stribeck", "m/s", 1e-4, 10, "Stribeck velocity of the friction",
     &contact::FrictionLaw::stribeck_m_per_s},
    {"breakaway", "", 0.01, 0.99, "share of the sliding force up to which the bristles only bend",
     &contact::FrictionLaw::breakaway},
    {"stiffness", "N/m", 1, 1e9, "bristle stiffness", &contact::FrictionLaw::stiffness_n_per_m},
    {"damping", "N s/m", 0, 1e5, "bristle damping", &contact::FrictionLaw::damping_ns_per_m},
    {"viscosity", "N s/m", 0, 1e4, "viscous friction", &contact::FrictionLaw::viscosity_ns_per_m},
    {"roughness", "N^.5 s^.5/m^.5", 0, 1e3, "friction noise of the surfaces",
     &contact::FrictionLaw::roughness}};

constexpr PartKey<FrictionRecipe> kFriction[] = {
    {"pressed", "N", 0, 1e4, "normal force in the joint without load", &FrictionRecipe::preload_n},
    {"joint", "Hz", 5, 2000, "resonance of the joint's mass on its spring",
     &FrictionRecipe::joint_hz},
    {"joint_mass", "kg", 0.001, 100, "mass of the joint", &FrictionRecipe::joint_kg},
    {"joint_t60", "s", 0.001, 5, "decay time of the joint", &FrictionRecipe::joint_t60_s},
    {"load", "N", 0, 1e4, "additional normal force in the joint under 700 N",
     &FrictionRecipe::load_n},
    {"slip", "m/s", 0, 10, "slip speed of the joint while 7000 N/s move from heel to ball",
     &FrictionRecipe::slip_m_per_s},
    {"wobble", "", 0, 2, "slow random variation of normal force and slip speed",
     &FrictionRecipe::wobble},
    {"level", "", 0, 1e4, "strength of the sound", &FrictionRecipe::level}};

using particle::CloudSettings;
constexpr PartKey<CloudSettings> kEvents[] = {
    {"count", "", 0, 50000, "number of events for each unit of energy", &CloudSettings::count},
    {"exponent", "", 0.05, 20, "exponent of the event energies' power law",
     &CloudSettings::exponent},
    {"largest", "", 1.001, 1e6, "energy of the largest event over the smallest",
     &CloudSettings::largest},
    {"lower_by_size", "", 0, 2,
     "exponent by which large events sound lower: frequency ~ energy^-this",
     &CloudSettings::lower_by_size}};

constexpr PartKey<CloudSettings> kCloudSound[] = {
    {"attack", "s", 1e-4, 5, "time in which a landing's energy arrives", &CloudSettings::attack_s},
    {"decay", "s", 1e-4, 10, "time in which the energy falls to 1/e", &CloudSettings::decay_s},
    {"frequency", "Hz", 20, 20000, "median frequency of the grains", &CloudSettings::frequency_hz},
    {"spread", "", 0, 3, "standard deviation of the logarithm of the frequency",
     &CloudSettings::spread},
    {"level", "", 0, 1e4, "strength of the sound", &CloudSettings::level}};

constexpr PartKey<CloudRecipe> kCloudEnergy[] = {
    {"heel", "", 0, 100, "energy of the heel's landing at 0.5 m/s", &CloudRecipe::heel},
    {"ball", "", 0, 100, "energy of the ball's landing at 0.5 m/s", &CloudRecipe::ball},
    {"load", "", 0, 100, "energy for each 700 N of rising load", &CloudRecipe::load},
    {"release", "", 0, 100, "energy for each 700 N of falling load", &CloudRecipe::release},
    {"slide", "", 0, 1000, "energy for each metre slid under 700 N", &CloudRecipe::slide}};

constexpr PartKey<CloudSettings> kGrains[] = {
    {"quality", "", 0.1, 200, "quality factor of a grain's band-pass", &CloudSettings::quality},
    {"length", "s", 1e-5, 1, "median decay time of the grains", &CloudSettings::length_s}};
constexpr PartKey<CloudSettings> kBubbles[] = {
    {"rise", "", 0, 1, "rise of a bubble's pitch", &CloudSettings::rise}};
constexpr PartKey<CloudSettings> kRustle[] = {
    {"quality", "", 0.1, 200, "quality factor of the band-passes", &CloudSettings::quality}};

constexpr PartKey<Room::Settings> kRoom[] = {
    {"level", "dB", Room::kMinLevel, 40, "energy of the room's response over the direct sound's",
     &Room::Settings::level_db},
    {"t60", "s", 0.02, 10, "decay time of the room", &Room::Settings::t60_s},
    {"bright", "Hz", 100, 20000, "frequency at which the decay time is half",
     &Room::Settings::bright_hz}};

// Access to the parts of a recipe; the parts of a cloud are those of the last cloud.
Recipe& whole(Recipe& r) { return r; }
SolidRecipe& solid(Recipe& r) { return r.solid; }
ModesRecipe& solid_modes(Recipe& r) { return r.solid.modes; }
contact::ImpactLaw& solid_law(Recipe& r) { return r.solid.law; }
Scatter& solid_scatter(Recipe& r) { return r.solid.scatter; }
FrictionRecipe& friction(Recipe& r) { return r.friction; }
ModesRecipe& friction_modes(Recipe& r) { return r.friction.modes; }
contact::FrictionLaw& friction_law(Recipe& r) { return r.friction.law; }
Scatter& friction_scatter(Recipe& r) { return r.friction.scatter; }
CloudRecipe& cloud(Recipe& r) { return r.cloud[r.clouds - 1]; }
CloudSettings& cloud_settings(Recipe& r) { return cloud(r).settings; }
Scatter& cloud_scatter(Recipe& r) { return cloud(r).scatter; }
Room::Settings& room(Recipe& r) { return r.room; }

template <auto part, auto& keys, std::size_t i> double& member_of(Recipe& r) {
  return part(r).*keys[i].member;
}
/// The keys of a part, in a section.
template <auto part, auto& keys> constexpr auto keys_of(std::string_view section) {
  return [section]<std::size_t... i>(std::index_sequence<i...>) {
    return std::array{RecipeKey{section, keys[i].name, keys[i].unit, keys[i].lowest,
                                keys[i].highest, keys[i].text, &member_of<part, keys, i>}...};
  }
  (std::make_index_sequence<std::size(keys)>());
}
template <std::size_t... counts>
constexpr auto joined(const std::array<RecipeKey, counts>&... parts) {
  std::array<RecipeKey, (counts + ...)> all{};
  auto* next = all.data();
  ((next = std::copy(parts.begin(), parts.end(), next)), ...);
  return all;
}
constexpr auto cloud_keys(std::string_view section) {
  return joined(keys_of<cloud_settings, kCloudSound>(section),
                keys_of<cloud, kCloudEnergy>(section), keys_of<cloud_scatter, kScatter>(section));
}

constexpr auto kKeys = joined(
    keys_of<whole, kWhole>(""), keys_of<solid_modes, kModes>("solid"),
    keys_of<solid_law, kImpact>("solid"), keys_of<solid, kSolid>("solid"),
    keys_of<solid_scatter, kScatter>("solid"), keys_of<friction_modes, kModes>("friction"),
    keys_of<friction_law, kRubbing>("friction"), keys_of<friction, kFriction>("friction"),
    keys_of<friction_scatter, kScatter>("friction"), keys_of<cloud_settings, kEvents>("grains"),
    cloud_keys("grains"), keys_of<cloud_settings, kGrains>("grains"),
    keys_of<cloud_settings, kEvents>("bubbles"), cloud_keys("bubbles"),
    keys_of<cloud_settings, kBubbles>("bubbles"), cloud_keys("rustle"),
    keys_of<cloud_settings, kRustle>("rustle"), keys_of<room, kRoom>("room"));

} // namespace

std::span<const RecipeKey> recipe_keys() noexcept { return kKeys; }

} // namespace tactus::footstep
