#pragma once

#include "core/declaration.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <type_traits>

/// Declaration of [greed~]: its parameters, messages, inlets and outlets, and the member of
/// reed::Parameters that each parameter sets. Tables are in the order of kParameters.
namespace tactus::greed {

using reed::Parameters;

inline constexpr std::array<std::string_view, 3> kTypes{"closed", "open", "swing"};
inline constexpr std::array<std::string_view, 2> kBores{"cyl", "cone"};
inline constexpr std::array<std::string_view, 6> kEnds{"open", "clarinet", "saxophone",
                                                       "oboe", "trumpet",  "trombone"};
inline constexpr std::array<std::string_view, 2> kFlows{"implicit", "paper"};
inline constexpr std::array<double, 4> kOversamplings{0, 1, 2, 4};

/// Setter and getter of one member of reed::Parameters, as a message's number.
struct Member {
  void (*set)(Parameters&, double);
  double (*get)(const Parameters&);
};

template <auto member> constexpr Member number() {
  return {[](Parameters& p, double value) { p.*member = value; },
          [](const Parameters& p) { return p.*member; }};
}
/// For switches, enumerations and integers.
template <auto member> constexpr Member whole() {
  return {[](Parameters& p, double value) {
            using Type = std::remove_reference_t<decltype(p.*member)>;
            if constexpr (std::is_same_v<Type, bool>)
              p.*member = value >= 0.5;
            else
              p.*member = static_cast<Type>(static_cast<int>(value));
          },
          [](const Parameters& p) { return static_cast<double>(p.*member); }};
}
/// The valve's type also sets the sign of the rest angle: closed negative, open positive.
constexpr Member type() {
  return {[](Parameters& p, double value) {
            p.type = static_cast<reed::ValveType>(static_cast<int>(value));
            if (p.type == reed::ValveType::kClosed)
              p.rest_angle = -std::abs(p.rest_angle);
            if (p.type == reed::ValveType::kOpen)
              p.rest_angle = std::abs(p.rest_angle);
          },
          [](const Parameters& p) { return static_cast<double>(p.type); }};
}

inline constexpr Parameters kInitial{};

inline constexpr std::array kParameters{
    Parameter{"type", "", 0, 0, 2, "blown closed, blown open, or a swinging door", kTypes},
    Parameter{"theta0", "rad", kInitial.rest_angle, -1.2, 1.2, "rest angle; its sign follows type"},
    Parameter{"arm", "m", kInitial.arm_length, 1e-4, 0.1, "arm length l, from hinge to tip"},
    Parameter{"mass", "kg", kInitial.mass, 1e-9, 0.1, "moving mass m"},
    Parameter{"f_r", "Hz", kInitial.reed_frequency, 1, 20000,
              "reed frequency while the signal f_r is 0"},
    Parameter{"q", "", kInitial.quality, 0.1, 1000, "quality factor Q of the valve"},
    Parameter{"width", "m", kInitial.width, 1e-4, 0.1, "width w of the channel"},
    Parameter{"lambda_m", "m", kInitial.mouth_length, 0, 0.1,
              "length that sees the mouth pressure"},
    Parameter{"lambda_b", "m", kInitial.bore_length, 0, 0.1, "length that sees the bore pressure"},
    Parameter{"mu", "m", kInitial.flow_length, 0, 0.1, "length that sees the flow"},
    Parameter{"lambda", "m", kInitial.channel_length, 1e-6, 0.1, "length of the channel"},
    Parameter{"leak", "m^2", kInitial.leak_area, 0, 1e-4, "area that never closes"},
    Parameter{"rest", "", kInitial.restitution, 0, 1, "restitution of the stop"},
    Parameter{"xmax", "m", kInitial.displacement_limit, 1e-5, 0.05, "limit of the displacement"},
    Parameter{"sweep", "", 1, 0, 1, "1: the moving valve's own volume flow enters the bore"},
    Parameter{"bore", "", 0, 0, 1, "cylinder or cone", kBores},
    Parameter{"length", "m", 0, 0, 20, "bore length; above 0 it stands above the bore frequency"},
    Parameter{"own_length", "m", kInitial.length, 0.005, 20,
              "bore length while neither length nor the signal f_b sets it"},
    Parameter{"radius", "m", kInitial.input_radius, 5e-4, 0.1, "radius at the input"},
    Parameter{"radius_end", "m", kInitial.end_radius, 5e-4, 0.3,
              "radius of the radiating opening; larger imitates a bell"},
    Parameter{"apex", "m", kInitial.apex_distance, 0.01, 10, "cone: from its apex to the input"},
    Parameter{"cup", "m^3", kInitial.cup_volume, 0, 1e-3, "volume of mouthpiece or cup"},
    Parameter{"loss", "", kInitial.wall_loss, 0, 20, "times the theoretical wall loss"},
    Parameter{"refl", "", kInitial.scalar_reflection, 0, 1,
              "above 0: a bare reflection of that size instead of loss and radiation"},
    Parameter{"bell", "Hz", kInitial.bell, 0, 20000,
              "above it bell or open holes let the sound out; 0: a plain open end"},
    Parameter{"bell_q", "", kInitial.bell_quality, 0.1, 100, "how sharply they open"},
    Parameter{"brassiness", "", kInitial.brassiness, 0, 100,
              "bore lengths over which a loud wave steepens before it is radiated"},
    Parameter{"temp", "degC", kInitial.temperature, -20, 50, "temperature of the air"},
    Parameter{"end", "", 0, 0, 5,
              "with tune: an open end, or holes and bell of an instrument, for radius_end and bell",
              kEnds},
    Parameter{"os",
              "",
              0,
              0,
              4,
              "oversampling 1, 2 or 4; 0: 4 for the swinging valve, else 1",
              {},
              kOversamplings},
    Parameter{"flow", "", 0, 0, 1, "jet solved implicitly, or as printed in the paper", kFlows},
    Parameter{"noise", "", kInitial.breath_noise, 0, 1, "breath noise, of the jet's pressure"},
    seed_parameter<"seed of the breath noise">(),
    Parameter{"tune", "", 0, 0, 1, "1: choose the bore so that it plays f_b"},
    Parameter{"ear", "", 1, 0, 1, "1: with tune, correct slowly what is heard out of tune"},
    Parameter{"fingering", "", 0, 0, 127,
              "with tune: MIDI note fingered, in place of the bore frequency; 0: none"},
    Parameter{"tube", "", 0, 0, 1,
              "1: with tune and end trumpet or trombone: f_b is played with valves or slide"},
    Parameter{
        "slide", "", 0, 0, 7,
        "with tune and end trombone: slide position 1 to 7, fractions too; 0: the player's choice"},
    Parameter{"embouchure", "", kInitial.embouchure, 0, 10,
              "with tune: f_r/f_b that the lips keep, f_r bending them; 0: f_r as given"},
    Parameter{"aim", "cent", 0, -1200, 1200,
              "with tune: aim so far beside f_b, against what sounding loud adds"},
    Parameter{"lip_mass", "", 1, 0.01, 100, "with tune: times the valve's mass"},
    Parameter{"lip_opening", "", 1, 0.01, 100, "with tune: times theta0"},
    Parameter{"lip_width", "", 1, 0.01, 100, "with tune: times width"},
    Parameter{"lip_q", "", 1, 0.01, 100, "with tune: times q"},
    Parameter{"lip_limit", "", 1, 0.01, 100, "with tune: times xmax"},
    Parameter{"lip_channel", "", 1, 0.01, 100, "with tune: times lambda"},
    Parameter{"lip_cup", "", 1, 0.01, 100, "with tune: times cup"},
    Parameter{"slope", "", 0, -2, 2,
              "with tune: power of f_b over f_r by which embouchure changes; of a reed, theta0"},
    Parameter{"highest_mode", "", 0, 0, 100,
              "with tune: highest resonance of the bore that lips sound; 0: any"},
    Parameter{"shortest_tract", "m", 0, 0, 100,
              "with tune: length to which a singer shortens the bore for high notes; 0: never"},
    Parameter{"steepening", "", 0, 0, 100,
              "with tune: wavelengths that brassiness counts; 0: lengths of the bore"},
    Parameter{"played_gain", "", 1, 0, 100, "with tune: times gain"},
    Parameter{"tongue_burst", "", 0, 0, 3,
              "with tune: by how much a tongued breath exceeds p_m at first (220 Hz, breath_ref); "
              "0: none"},
    Parameter{
        "breath_ref", "Pa", kInitial.breath_reference, 0, 50000,
        "with tune: mouth pressure at which the lips are as given; they follow others; 0: not"},
    Parameter{"breath_opening", "", kInitial.breath_opening, 0, 2,
              "with breath_ref: theta0 times p_m/breath_ref to this power"},
    Parameter{"breath_tension", "", kInitial.breath_tension, 0, 2,
              "with breath_ref: stiffness and mass times p_m/breath_ref to this power"},
    Parameter{"breath_q", "", kInitial.breath_quality, -2, 2,
              "with breath_ref: q times p_m/breath_ref to this power"},
    Parameter{"register_note", "Hz", kInitial.register_note, 0, 20000,
              "with tune: from here on the register vent of `end` is open; 0: never"},
    Parameter{"lowest_note", "Hz", kInitial.lowest_note, 0, 20000,
              "with tune: f_b below it is refused; 0: no limit"},
    Parameter{"highest_note", "Hz", kInitial.highest_note, 0, 20000,
              "with tune: f_b above it is refused; 0: no limit"},
    Parameter{"gain", "1/Pa", kInitial.gain, 0, 1000, "of the sound, before its soft clip"},
};

inline constexpr std::array<Member, kParameters.size()> kMembers{
    type(),
    number<&Parameters::rest_angle>(),
    number<&Parameters::arm_length>(),
    number<&Parameters::mass>(),
    number<&Parameters::reed_frequency>(),
    number<&Parameters::quality>(),
    number<&Parameters::width>(),
    number<&Parameters::mouth_length>(),
    number<&Parameters::bore_length>(),
    number<&Parameters::flow_length>(),
    number<&Parameters::channel_length>(),
    number<&Parameters::leak_area>(),
    number<&Parameters::restitution>(),
    number<&Parameters::displacement_limit>(),
    whole<&Parameters::sweep>(),
    whole<&Parameters::shape>(),
    number<&Parameters::length_override>(),
    number<&Parameters::length>(),
    number<&Parameters::input_radius>(),
    number<&Parameters::end_radius>(),
    number<&Parameters::apex_distance>(),
    number<&Parameters::cup_volume>(),
    number<&Parameters::wall_loss>(),
    number<&Parameters::scalar_reflection>(),
    number<&Parameters::bell>(),
    number<&Parameters::bell_quality>(),
    number<&Parameters::brassiness>(),
    number<&Parameters::temperature>(),
    whole<&Parameters::end>(),
    whole<&Parameters::oversampling>(),
    whole<&Parameters::flow>(),
    number<&Parameters::breath_noise>(),
    whole<&Parameters::seed>(),
    whole<&Parameters::tune>(),
    whole<&Parameters::correct_pitch>(),
    number<&Parameters::fingering>(),
    whole<&Parameters::tube>(),
    number<&Parameters::slide>(),
    number<&Parameters::embouchure>(),
    number<&Parameters::aim>(),
    number<&Parameters::lip_mass>(),
    number<&Parameters::lip_opening>(),
    number<&Parameters::lip_width>(),
    number<&Parameters::lip_quality>(),
    number<&Parameters::lip_limit>(),
    number<&Parameters::lip_channel>(),
    number<&Parameters::lip_cup>(),
    number<&Parameters::embouchure_slope>(),
    number<&Parameters::highest_mode>(),
    number<&Parameters::shortest_tract>(),
    number<&Parameters::steepening>(),
    number<&Parameters::played_gain>(),
    number<&Parameters::tongue>(),
    number<&Parameters::breath_reference>(),
    number<&Parameters::breath_opening>(),
    number<&Parameters::breath_tension>(),
    number<&Parameters::breath_quality>(),
    number<&Parameters::register_note>(),
    number<&Parameters::lowest_note>(),
    number<&Parameters::highest_note>(),
    number<&Parameters::gain>(),
};

inline constexpr std::array kMessages{
    Message{"preset", "clarinet|sax|oboe|trumpet|trombone|voice|syrinx", 1, 1,
            "all of valve and bore at once"},
    realtime(Message{"reset", "", 0, 0, "valve at rest, air still"}),
    realtime(Message{"tongue", "", 0, 0, "with tune: the note is tongued anew"}),
    Message{"holes", "CLOSED...", 1, 33,
            "with tune and tone holes: register vent and each hole from the reed down, 1 closed, 0 "
            "open, in between partly covered; fingering ends it"},
    Message{
        "valves", "[VALVE...|auto]", 0, 3,
        "with tune and end trumpet: valves pressed, of 1 2 3, or none; auto: the player's choice"},
    realtime(Message{"bang", "", 0, 0, "with tune: the note is tongued anew"}),
};
enum MessageIndex : std::size_t { kPreset, kReset, kTongue, kHoles, kValves, kBang };

inline constexpr std::array kArguments{CreationArgument{"preset"}};

inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "p_m", "Pa", "mouth pressure"},
    Port{Port::Kind::kSignal, "f_r", "Hz", "reed frequency; 0: the parameter f_r"},
    Port{Port::Kind::kSignal, "f_b", "Hz", "bore frequency; 0: the parameter own_length"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "sound", "", "radiated pressure times gain, within +-1"},
    Port{Port::Kind::kSignal, "theta", "rad", "angle of the valve"},
    Port{Port::Kind::kSignal, "p_b", "Pa", "pressure in the bore at the valve"},
    Port{Port::Kind::kSignal, "U", "m^3/s", "volume flow through the valve"},
};

} // namespace tactus::greed
