#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/rows.hpp"

#include <array>
#include <limits>
#include <string_view>

/// Everything that is known of a parameter of a reed instrument, a row each: the member of
/// Parameters, name, unit, range, how a change is made while the instrument sounds, and what a
/// preset does with it.
namespace tactus::reed {

/// How a changed parameter takes effect while the instrument sounds: it glides or jumps, if the
/// change is no larger than a factor or a difference; else in silence, from which the note goes on,
/// or, with a change beyond the second limit, starts from rest.
struct Change {
  static constexpr double kAny = std::numeric_limits<double>::max();
  bool glide = false;
  double factor = kAny, step = kAny;                     ///< of the quantity itself
  double continued_factor = kAny, continued_step = kAny; ///< beyond which the note starts from rest
  bool of_player = false;                                ///< limits count only with `tune`
};
constexpr Change glides(double factor = Change::kAny, double continued = Change::kAny) {
  return {true, factor, Change::kAny, continued};
}
constexpr Change glides_by(double step) { return {true, Change::kAny, step}; }
constexpr Change jumps(double factor = Change::kAny, double continued = Change::kAny) {
  return {false, factor, Change::kAny, continued};
}
constexpr Change jumps_by(double step, double continued = Change::kAny) {
  return {false, Change::kAny, step, Change::kAny, continued};
}
/// Any change needs silence.
constexpr Change fades() { return jumps_by(0); }
/// Any change starts the note from rest.
constexpr Change restarts() { return jumps_by(0, 0); }
constexpr Change player(Change change) {
  change.of_player = true;
  return change;
}

struct Row : Parameter {
  /// What a preset does: sets it; sets it, and is still that preset when it differs; leaves it.
  enum class Preset { kSets, kSetsLoosely, kLeaves };
  Change change;
  Preset preset = Preset::kSets;
};

inline constexpr std::array<std::string_view, 3> kTypes{"closed", "open", "swing"};
inline constexpr std::array<std::string_view, 2> kBores{"cyl", "cone"};
inline constexpr std::array<std::string_view, 6> kEnds{"open", "clarinet", "saxophone",
                                                       "oboe", "trumpet",  "trombone"};
inline constexpr std::array<std::string_view, 2> kFlows{"implicit", "paper"};
inline constexpr std::array<double, 4> kOversamplings{0, 1, 2, 4};

inline constexpr std::array kRows{
    Row{member<&Parameters::type>.then<&Parameters::orient>().row(
            "type", kTypes, "blown closed, blown open, or a swinging door"),
        restarts()},
    Row{member<&Parameters::rest_angle>.row("theta0", "rad", -1.2, 1.2,
                                            "rest angle; its sign follows type"),
        glides_by(0.1)},
    Row{member<&Parameters::arm_length>.row("arm", "m", 1e-4, 0.1,
                                            "arm length l, from hinge to tip"),
        glides(1.25, 2)},
    Row{member<&Parameters::mass>.row("mass", "kg", 1e-9, 0.1, "moving mass m"), glides(1.25, 2)},
    Row{member<&Parameters::reed_frequency>.row("f_r", "Hz", 1, 20000,
                                                "reed frequency while the signal f_r is 0"),
        glides(1.25)},
    Row{member<&Parameters::quality>.row("q", "", 0.1, 1000, "quality factor Q of the valve"),
        jumps(10)},
    Row{member<&Parameters::width>.row("width", "m", 1e-4, 0.1, "width w of the channel"),
        glides(1.25, 2)},
    Row{member<&Parameters::mouth_length>.row("lambda_m", "m", 0, 0.1,
                                              "length that sees the mouth pressure"),
        glides(1.25, 2)},
    Row{member<&Parameters::bore_length>.row("lambda_b", "m", 0, 0.1,
                                             "length that sees the bore pressure"),
        glides(1.25, 2)},
    Row{member<&Parameters::flow_length>.row("mu", "m", 0, 0.1, "length that sees the flow"),
        glides(1.25)},
    Row{member<&Parameters::channel_length>.row("lambda", "m", 1e-6, 0.1, "length of the channel"),
        glides(1.25)},
    Row{member<&Parameters::leak_area>.row("leak", "m^2", 0, 1e-4, "area that never closes"),
        glides(1.25)},
    Row{member<&Parameters::restitution>.row("rest", "", 0, 1, "restitution of the stop"),
        glides()},
    Row{member<&Parameters::displacement_limit>.row("xmax", "m", 1e-5, 0.05,
                                                    "limit of the displacement"),
        glides(1.25)},
    Row{member<&Parameters::sweep>.row("sweep",
                                       "1: the moving valve's own volume flow enters the bore"),
        fades()},
    Row{member<&Parameters::shape>.row("bore", kBores, "cylinder or cone"), restarts()},
    Row{member<&Parameters::length_override>.row(
            "length", "m", 0, 20, "bore length; above 0 it stands above the bore frequency"),
        jumps(1.25, 2), Row::Preset::kSetsLoosely},
    Row{member<&Parameters::length>.row(
            "own_length", "m", 0.005, 20,
            "bore length while neither length nor the signal f_b sets it"),
        glides(1.25)},
    Row{member<&Parameters::input_radius>.row("radius", "m", 5e-4, 0.1, "radius at the input"),
        glides(1.25, 2)},
    Row{member<&Parameters::end_radius>.row(
            "radius_end", "m", 5e-4, 0.3,
            "radius of the radiating opening; larger imitates a bell"),
        glides(1.25)},
    Row{member<&Parameters::apex_distance>.row("apex", "m", 0.01, 10,
                                               "cone: from its apex to the input"),
        glides(1.25, 2)},
    Row{member<&Parameters::cup_volume>.row("cup", "m^3", 0, 1e-3, "volume of mouthpiece or cup"),
        glides(1.25)},
    Row{member<&Parameters::wall_loss>.row("loss", "", 0, 20, "times the theoretical wall loss"),
        glides(1.25)},
    Row{member<&Parameters::scalar_reflection>.row(
            "refl", "", 0, 1,
            "above 0: a bare reflection of that size instead of loss and radiation"),
        glides(1.25, 2)},
    Row{member<&Parameters::bell>.row(
            "bell", "Hz", 0, 20000,
            "above it bell or open holes let the sound out; 0: a plain open end"),
        glides(1.25)},
    Row{member<&Parameters::bell_quality>.row("bell_q", "", 0.1, 100, "how sharply they open"),
        glides(1.25)},
    Row{member<&Parameters::brassiness>.row(
            "brassiness", "", 0, 100,
            "bore lengths over which a loud wave steepens before it is radiated"),
        glides(1.25)},
    Row{member<&Parameters::temperature>.row("temp", "degC", -20, 50, "temperature of the air"),
        glides(), Row::Preset::kLeaves},
    Row{member<&Parameters::end>.row(
            "end", kEnds,
            "with tune: an open end, or holes and bell of an instrument, for radius_end and bell"),
        fades()},
    Row{member<&Parameters::oversampling>.row(
            "os", kOversamplings, "oversampling 1, 2 or 4; 0: 4 for the swinging valve, else 1"),
        jumps(), Row::Preset::kLeaves},
    Row{member<&Parameters::flow>.row("flow", kFlows,
                                      "jet solved implicitly, or as printed in the paper"),
        fades(), Row::Preset::kLeaves},
    Row{member<&Parameters::breath_noise>.row("noise", "", 0, 1,
                                              "breath noise, of the jet's pressure"),
        glides(), Row::Preset::kLeaves},
    Row{member<&Parameters::seed>.seed<"seed of the breath noise">(), jumps(),
        Row::Preset::kLeaves},
    Row{member<&Parameters::tune>.row("tune", "1: choose the bore so that it plays f_b"),
        restarts(), Row::Preset::kLeaves},
    Row{member<&Parameters::correct_pitch>.row(
            "ear", "1: with tune, correct slowly what is heard out of tune"),
        player(fades()), Row::Preset::kLeaves},
    Row{member<&Parameters::fingering>.row(
            "fingering", "", 0, 127,
            "with tune: MIDI note fingered, in place of the bore frequency; 0: none"),
        jumps(), Row::Preset::kSetsLoosely},
    Row{member<&Parameters::tube>.row(
            "tube", "1: with tune and end trumpet or trombone: f_b is played with valves or slide"),
        player(fades())},
    Row{member<&Parameters::slide>.row("slide", "", 0, 7,
                                       "with tune and end trombone: slide position 1 to 7, "
                                       "fractions too; 0: the player's choice"),
        jumps(), Row::Preset::kSetsLoosely},
    Row{member<&Parameters::embouchure>.row(
            "embouchure", "", 0, 10,
            "with tune: f_r/f_b that the lips keep, f_r bending them; 0: f_r as given"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::aim>.row(
            "aim", "cent", -1200, 1200,
            "with tune: aim so far beside f_b, against what sounding loud adds"),
        player(jumps_by(100))},
    Row{member<&Parameters::lip_mass>.row("lip_mass", "", 0.01, 100,
                                          "with tune: times the valve's mass"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::lip_opening>.row("lip_opening", "", 0.01, 100,
                                             "with tune: times theta0"),
        player(jumps(1.25))},
    Row{member<&Parameters::lip_width>.row("lip_width", "", 0.01, 100, "with tune: times width"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::lip_quality>.row("lip_q", "", 0.01, 100, "with tune: times q"),
        player(jumps(1.25))},
    Row{member<&Parameters::lip_limit>.row("lip_limit", "", 0.01, 100, "with tune: times xmax"),
        jumps()},
    Row{member<&Parameters::lip_channel>.row("lip_channel", "", 0.01, 100,
                                             "with tune: times lambda"),
        jumps()},
    Row{member<&Parameters::lip_cup>.row("lip_cup", "", 0.01, 100, "with tune: times cup"),
        jumps()},
    Row{member<&Parameters::embouchure_slope>.row(
            "slope", "", -2, 2,
            "with tune: power of f_b over f_r by which embouchure changes; of a reed, theta0"),
        player(jumps_by(0.05, 0.1))},
    Row{member<&Parameters::highest_mode>.row(
            "highest_mode", "", 0, 100,
            "with tune: highest resonance of the bore that lips sound; 0: any"),
        jumps()},
    Row{member<&Parameters::shortest_tract>.row(
            "shortest_tract", "m", 0, 100,
            "with tune: length to which a singer shortens the bore for high notes; 0: never"),
        jumps()},
    Row{member<&Parameters::steepening>.row(
            "steepening", "", 0, 100,
            "with tune: wavelengths that brassiness counts; 0: lengths of the bore"),
        jumps()},
    Row{member<&Parameters::played_gain>.row("played_gain", "", 0, 100, "with tune: times gain"),
        jumps()},
    Row{member<&Parameters::tongue>.row(
            "tongue_burst", "", 0, 3,
            "with tune: by how much a tongued breath exceeds p_m at first (220 Hz, breath_ref); "
            "0: none"),
        jumps()},
    Row{member<&Parameters::breath_reference>.row(
            "breath_ref", "Pa", 0, 50000,
            "with tune: mouth pressure at which the lips are as given; they follow others; 0: not"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::breath_opening>.row(
            "breath_opening", "", 0, 2,
            "with breath_ref: theta0 times p_m/breath_ref to this power"),
        jumps()},
    Row{member<&Parameters::breath_tension>.row(
            "breath_tension", "", 0, 2,
            "with breath_ref: stiffness and mass times p_m/breath_ref to this power"),
        jumps()},
    Row{member<&Parameters::breath_quality>.row(
            "breath_q", "", -2, 2, "with breath_ref: q times p_m/breath_ref to this power"),
        jumps()},
    Row{member<&Parameters::register_note>.row(
            "register_note", "Hz", 0, 20000,
            "with tune: from here on the register vent of `end` is open; 0: never"),
        jumps()},
    Row{member<&Parameters::lowest_note>.row("lowest_note", "Hz", 0, 20000,
                                             "with tune: f_b below it is refused; 0: no limit"),
        jumps()},
    Row{member<&Parameters::highest_note>.row("highest_note", "Hz", 0, 20000,
                                              "with tune: f_b above it is refused; 0: no limit"),
        jumps()},
    Row{member<&Parameters::gain>.row("gain", "1/Pa", 0, 1000,
                                      "of the sound, before its soft clip"),
        jumps(), Row::Preset::kSetsLoosely},
};

} // namespace tactus::reed
