#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/rows.hpp"

#include <array>
#include <limits>
#include <string_view>

/// One row per parameter of a reed instrument: the member of Parameters, name, unit, range, how a
/// change is made while the instrument sounds, and how presets treat it.
namespace tactus::reed {

/// How a changed parameter takes effect while the instrument sounds. It glides or jumps if the
/// change is within a factor or a difference. Larger changes are made in silence. After the silence
/// the note continues or, if the change exceeds the second limit, starts from rest.
struct Change {
  static constexpr double kAny = std::numeric_limits<double>::max();
  bool glide = false;
  double factor = kAny, step = kAny;                     ///< limits of the quantity itself
  double continued_factor = kAny, continued_step = kAny; ///< limits beyond which the note starts
                                                         ///< from rest
  bool of_player = false;                                ///< limits apply only with `tune`
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
  /// How a preset treats the parameter: it sets the parameter; it sets it, but other values still
  /// count as the preset; or it leaves it.
  enum class Preset { kSets, kSetsAdjustable, kLeaves };
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
            "type", kTypes, "type of the valve: blown closed, blown open, or a swinging door"),
        restarts()},
    Row{member<&Parameters::rest_angle>.row("theta0", "rad", -1.2, 1.2,
                                            "rest angle of the valve; `type` sets its sign"),
        glides_by(0.1)},
    Row{member<&Parameters::arm_length>.row("arm", "m", 1e-4, 0.1,
                                            "arm length l, from hinge to tip"),
        glides(1.25, 2)},
    Row{member<&Parameters::mass>.row("mass", "kg", 1e-9, 0.1, "moving mass m of the valve"),
        glides(1.25, 2)},
    Row{member<&Parameters::reed_frequency>.row(
            "f_r", "Hz", 1, 20000,
            "natural frequency of the valve, used while the signal f_r is 0"),
        glides(1.25)},
    Row{member<&Parameters::quality>.row("q", "", 0.1, 1000, "quality factor Q of the valve"),
        jumps(10)},
    Row{member<&Parameters::width>.row("width", "m", 1e-4, 0.1, "width w of the channel"),
        glides(1.25, 2)},
    Row{member<&Parameters::mouth_length>.row(
            "lambda_m", "m", 0, 0.1, "length of the valve on which the mouth pressure acts"),
        glides(1.25, 2)},
    Row{member<&Parameters::bore_length>.row("lambda_b", "m", 0, 0.1,
                                             "length of the valve on which the bore pressure acts"),
        glides(1.25, 2)},
    Row{member<&Parameters::flow_length>.row("mu", "m", 0, 0.1,
                                             "length of the valve on which the flow acts"),
        glides(1.25)},
    Row{member<&Parameters::channel_length>.row("lambda", "m", 1e-6, 0.1,
                                                "length of the channel under the valve"),
        glides(1.25)},
    Row{member<&Parameters::leak_area>.row("leak", "m^2", 0, 1e-4, "leak area that never closes"),
        glides(1.25)},
    Row{member<&Parameters::restitution>.row("rest", "", 0, 1, "restitution of the stop"),
        glides()},
    Row{member<&Parameters::displacement_limit>.row("xmax", "m", 1e-5, 0.05,
                                                    "largest displacement of the valve"),
        glides(1.25)},
    Row{member<&Parameters::sweep>.row(
            "sweep", "switch: 1 adds the volume flow displaced by the moving valve"),
        fades()},
    Row{member<&Parameters::shape>.row("bore", kBores, "shape of the bore: cylinder or cone"),
        restarts()},
    Row{member<&Parameters::length_override>.row(
            "length", "m", 0, 20, "bore length; above 0 it overrides the bore frequency"),
        jumps(1.25, 2), Row::Preset::kSetsAdjustable},
    Row{member<&Parameters::length>.row(
            "own_length", "m", 0.005, 20,
            "bore length used if neither `length` nor the signal f_b sets it"),
        glides(1.25)},
    Row{member<&Parameters::input_radius>.row("radius", "m", 5e-4, 0.1, "bore radius at the input"),
        glides(1.25, 2)},
    Row{member<&Parameters::end_radius>.row(
            "radius_end", "m", 5e-4, 0.3,
            "radius of the radiating opening; a larger one imitates a bell"),
        glides(1.25)},
    Row{member<&Parameters::apex_distance>.row("apex", "m", 0.01, 10,
                                               "distance from the cone's apex to the input"),
        glides(1.25, 2)},
    Row{member<&Parameters::cup_volume>.row("cup", "m^3", 0, 1e-3, "volume of mouthpiece or cup"),
        glides(1.25)},
    Row{member<&Parameters::wall_loss>.row("loss", "", 0, 20,
                                           "factor on the theoretical wall loss"),
        glides(1.25)},
    Row{member<&Parameters::scalar_reflection>.row(
            "refl", "", 0, 1,
            "frequency-independent reflection that replaces loss and radiation; 0: off"),
        glides(1.25, 2)},
    Row{member<&Parameters::bell>.row("bell", "Hz", 0, 20000,
                                      "cut-off frequency of bell or open holes; 0: plain open end"),
        glides(1.25)},
    Row{member<&Parameters::bell_quality>.row("bell_q", "", 0.1, 100,
                                              "quality factor at the cut-off frequency `bell`"),
        glides(1.25)},
    Row{member<&Parameters::brassiness>.row(
            "brassiness", "", 0, 100,
            "steepening of loud waves: number of bore lengths over which they steepen"),
        glides(1.25)},
    Row{member<&Parameters::temperature>.row("temp", "degC", -20, 50, "temperature of the air"),
        glides(), Row::Preset::kLeaves},
    Row{member<&Parameters::end>.row("end", kEnds,
                                     "end of the bore with `tune 1`: open, or an instrument's "
                                     "holes and bell in place of `radius_end` and `bell`"),
        fades()},
    Row{member<&Parameters::oversampling>.row(
            "os", kOversamplings, "oversampling factor; 0: 4 for the swinging valve, else 1"),
        jumps(), Row::Preset::kLeaves},
    Row{member<&Parameters::flow>.row("flow", kFlows,
                                      "solver of the flow: implicit, or explicit as in the paper"),
        fades(), Row::Preset::kLeaves},
    Row{member<&Parameters::breath_noise>.row("noise", "", 0, 1,
                                              "breath noise, relative to the jet's pressure"),
        glides(), Row::Preset::kLeaves},
    Row{member<&Parameters::seed>.seed<"seed of the breath noise">(), jumps(),
        Row::Preset::kLeaves},
    Row{member<&Parameters::tune>.row(
            "tune", "switch: 1 lets a simulated player set bore and lips so that f_b sounds"),
        restarts(), Row::Preset::kLeaves},
    Row{member<&Parameters::correct_pitch>.row(
            "ear", "pitch tracker, used with `tune 1`; 1: on, corrects the sounding pitch"),
        player(fades()), Row::Preset::kLeaves},
    Row{member<&Parameters::fingering>.row(
            "fingering", "", 0, 127, "fingered MIDI note with `tune 1`, replaces f_b; 0: none"),
        jumps(), Row::Preset::kSetsAdjustable},
    Row{member<&Parameters::tube>.row(
            "tube",
            "switch with `tune 1` and `end trumpet` or `trombone`: 1 plays f_b by valves or slide"),
        player(fades())},
    Row{member<&Parameters::slide>.row(
            "slide", "", 0, 7,
            "slide position 1 to 7 with `tune 1` and `end trombone`; 0: the player chooses"),
        jumps(), Row::Preset::kSetsAdjustable},
    Row{member<&Parameters::embouchure>.row(
            "embouchure", "", 0, 10,
            "ratio f_r/f_b of the lips with `tune 1`; the signal f_r changes it; 0: given f_r"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::aim>.row("aim", "cent", -1200, 1200,
                                     "offset of the player's target from f_b with `tune 1`, to "
                                     "cancel the shift of loud notes"),
        player(jumps_by(100))},
    Row{member<&Parameters::lip_mass>.row("lip_mass", "", 0.01, 100,
                                          "factor on `mass` with `tune 1`"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::lip_opening>.row("lip_opening", "", 0.01, 100,
                                             "factor on `theta0` with `tune 1`"),
        player(jumps(1.25))},
    Row{member<&Parameters::lip_width>.row("lip_width", "", 0.01, 100,
                                           "factor on `width` with `tune 1`"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::lip_quality>.row("lip_q", "", 0.01, 100, "factor on `q` with `tune 1`"),
        player(jumps(1.25))},
    Row{member<&Parameters::lip_limit>.row("lip_limit", "", 0.01, 100,
                                           "factor on `xmax` with `tune 1`"),
        jumps()},
    Row{member<&Parameters::lip_channel>.row("lip_channel", "", 0.01, 100,
                                             "factor on `lambda` with `tune 1`"),
        jumps()},
    Row{member<&Parameters::lip_cup>.row("lip_cup", "", 0.01, 100, "factor on `cup` with `tune 1`"),
        jumps()},
    Row{member<&Parameters::embouchure_slope>.row(
            "slope", "", -2, 2,
            "exponent of f_b/f_r in a factor on `embouchure` (reeds: on `theta0`) with `tune 1`"),
        player(jumps_by(0.05, 0.1))},
    Row{member<&Parameters::highest_mode>.row(
            "highest_mode", "", 0, 100,
            "highest bore resonance that lips play with `tune 1`; 0: any"),
        jumps()},
    Row{member<&Parameters::shortest_tract>.row(
            "shortest_tract", "m", 0, 100,
            "shortest bore length of a singer on high notes with `tune 1`; 0: not shortened"),
        jumps()},
    Row{member<&Parameters::steepening>.row(
            "steepening", "", 0, 100,
            "unit of `brassiness` in wavelengths, with `tune 1`; 0: one bore length"),
        jumps()},
    Row{member<&Parameters::played_gain>.row("played_gain", "", 0, 100,
                                             "factor on `gain` with `tune 1`"),
        jumps()},
    Row{member<&Parameters::tongue>.row("tongue_burst", "", 0, 3,
                                        "initial overshoot of a tongued breath as a fraction of "
                                        "p_m, with `tune 1`, at 220 Hz and `breath_ref`; 0: none"),
        jumps()},
    Row{member<&Parameters::breath_reference>.row(
            "breath_ref", "Pa", 0, 50000,
            "reference mouth pressure with `tune 1`: lips as given; they follow other pressures; "
            "0: they do not follow"),
        player(jumps(1.25, 2))},
    Row{member<&Parameters::breath_opening>.row(
            "breath_opening", "", 0, 2, "exponent of p_m/`breath_ref` in a factor on `theta0`"),
        jumps()},
    Row{member<&Parameters::breath_tension>.row(
            "breath_tension", "", 0, 2,
            "exponent of p_m/`breath_ref` in a factor on stiffness and mass"),
        jumps()},
    Row{member<&Parameters::breath_quality>.row("breath_q", "", -2, 2,
                                                "exponent of p_m/`breath_ref` in a factor on `q`"),
        jumps()},
    Row{member<&Parameters::register_note>.row(
            "register_note", "Hz", 0, 20000,
            "lowest note with open register vent with `tune 1`; 0: never open"),
        jumps()},
    Row{member<&Parameters::lowest_note>.row(
            "lowest_note", "Hz", 0, 20000,
            "lowest f_b that the player accepts with `tune 1`; 0: no limit"),
        jumps()},
    Row{member<&Parameters::highest_note>.row(
            "highest_note", "Hz", 0, 20000,
            "highest f_b that the player accepts with `tune 1`; 0: no limit"),
        jumps()},
    Row{member<&Parameters::gain>.row("gain", "1/Pa", 0, 1000,
                                      "gain of the sound, before its soft clip"),
        jumps(), Row::Preset::kSetsAdjustable},
};

} // namespace tactus::reed
