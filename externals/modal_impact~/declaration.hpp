#pragma once

#include "core/declaration.hpp"

#include <array>
#include <cstddef>
#include <string_view>

/// The parameters, messages, inlets and outlets of [modal_impact~].
namespace tactus::modal_impact {

inline constexpr double kMillimetre = 0.001; ///< m, the unit of positions in messages
inline constexpr double kFarthest = 1e6;     ///< mm, the largest coordinate of a position

inline constexpr std::array<std::string_view, 4> kRadiations{"modal", "raw", "body", "none"};
inline constexpr std::array<std::string_view, 2> kContacts{"coupled", "pulse"};
inline constexpr std::array<std::string_view, 2> kResolveModes{"auto", "off"};
inline constexpr std::array<std::string_view, 3> kLimits{"auto", "on", "off"};
inline constexpr double kAtOnce = 1, kInOrder = 2; ///< of `sync`
/// With limit auto: gains from here on are for measuring, and nothing is limited.
inline constexpr double kMeasuringGain = 0.1;

enum ParameterIndex : std::size_t {
  kRadiation,
  kContact,
  kSize,
  kModes,
  kCull,
  kChoke,
  kGain,
  kLimit,
  kRestitution,
  kSpring,
  kPosition,
  kDoppler,
  kVoices,
  kOut,
  kSync,
  kRestStiffness,
  kRestExponent,
  kRestLoss,
  kRestForce,
  kResolve,
  kVariation,
  kSeed,
};
inline constexpr std::array kParameters{
    not_realtime(Parameter{
        "radiation", "", 0, 0, 3,
        "how the body sounds to a listener: baffled surface mode by mode (low modes of thin bodies "
        "come too loud, a bar's first by 18 dB), recorded or computed surface velocities, free "
        "body by its multipoles, or bare surface velocity",
        kRadiations}),
    Parameter{"contact", "", 0, 0, 1,
              "striker and body coupled, or half-sine pulses for many strikes at once", kContacts},
    not_realtime(Parameter{"size", "", 1, 0.01, 100, "factor of the table's lengths"}),
    not_realtime(Parameter{"modes", "", 0, 0, 20000,
                           "the largest number of modes that sound, and all of a last group of "
                           "near-equal frequencies; 0: all"}),
    Parameter{"cull", "dB", 90, 20, 200,
              "modes quieter (A-weighted) than the strike's loudest by this are left out"},
    not_realtime(
        Parameter{"choke", "s", 0, 0, 100, "decay time by which a hand damps the body; 0: none"}),
    Parameter{"gain", "1/Pa", 0.01, 0, 1000,
              "output for 1 Pa of sound pressure: 100 Pa reach full scale at 0.01"},
    Parameter{"limit", "", 0, 0, 2,
              "soft limit of the sound, within +-1 and linear up to 0.5; auto: on for gains below "
              "0.1, off above, where the outlets are for measuring",
              kLimits},
    Parameter{"restitution", "", 1, 0.01, 1,
              "speed after over speed before on a wall; below 1 it sets the contact's loss"},
    Parameter{"spring", "N/m", 0, 0, 100000,
              "above 0, with pos 1: the contact outlet gives the force of this spring instead"},
    Parameter{"pos", "", 0, 0, 1,
              "1: inlet 2 is the height above the point of a striker that a hand moves"},
    Parameter{"doppler", "", 0, 0, 1, "1: a listener that moves hears the pitch bend"},
    not_realtime(
        Parameter{"voices", "", 8, 1, 64, "contacts at once; one more strike ends the oldest"}),
    not_realtime(
        Parameter{"out", "", 2, 1, 4, "listeners; 1 sounds on both sides at half the cost"}),
    Parameter{
        "sync", "", 0, 0, 2,
        "1: tables and changes are computed at once, as always in a render; 0: in the background; "
        "2: in the background, and strikes and info that come after them wait for them"},
    not_realtime(Parameter{
        "rest_stiffness", "N/m^a", 4e8, 100, 1e13,
        "k of the layer between body and board at each contact point, F = k d^a; default: felt"}),
    not_realtime(Parameter{"rest_exponent", "", 2.3, 1, 5,
                           "exponent a of the layer: 1 a spring, 1.5 hard and round, 2.3 felt"}),
    not_realtime(
        Parameter{"rest_loss", "s/m", 2, 0, 100, "loss of the layer: F = k d^a (1 + loss v)"}),
    not_realtime(Parameter{
        "rest_force", "N", 0, 0, 1000,
        "force that presses body and board together besides the weight, over all points"}),
    not_realtime(Parameter{
        "resolve", "", 0, 0, 1,
        "when the shape has moved: solve its modes anew in the background, or only extrapolate",
        kResolveModes}),
    Parameter{"variation", "", 0, 0, 1,
              "of strikes: 1 scatters speed, point and direction as a hand does, 0 repeats them"},
    seed_parameter<"seed of the variation and of a rub's roughness">(),
};

enum MessageIndex : std::size_t {
  kLoad,
  kHit,
  kHitVertex,
  kHitFace,
  kDrop,
  kBang,
  kNormal,
  kStriker,
  kHardness,
  kPoint,
  kRub,
  kFriction,
  kBoard,
  kRest,
  kListener,
  kMaterial,
  kPreset,
  kShape,
  kControlPoint,
  kSolver,
  kRayleigh,
  kLoss,
  kLossCurve,
  kDamping,
  kReset,
  kInfo,
  kRing,
};
inline constexpr std::array kMessages{
    takes_file(Message{
        "load", "name [-sync]", 1, 2,
        "read a body's table, NAME or NAME.modal.npz: beside the patch, in the search path, "
        "beside the object (bar bell board bowl glass plate tube ...); the old body sounds until "
        "then"}),
    realtime(Message{"hit", "[x y z] v", 1, 4,
                     "strike at x y z mm with v m/s; without a position where the last one was"}),
    realtime(Message{"hitv", "vertex v", 2, 2, "strike at a vertex of the table"}),
    realtime(Message{"hitf", "face u v speed", 4, 4,
                     "strike on a triangle, u and v the weights of its second and third corner"}),
    realtime(Message{"drop", "[x y z] h", 1, 4,
                     "the striker falls h mm onto x y z mm and bounces until it lies"}),
    realtime(Message{"bang", "", 0, 0, "repeat the last strike"}),
    Message{"normal", "[x y z]", 0, 3,
            "direction out of the body, against which strikers move; none: the surface normal"},
    Message{"striker", "mass radius E nu", 4, 4, "a ball: kg, m, Pa (Hertz' contact)"},
    Message{"hardness", "k exponent loss", 1, 3,
            "contact law k d^exponent (1 + loss v) instead of Hertz'; 0: Hertz"},
    Message{"point", "x y z or vertex", 1, 3, "where inlets 1 and 2 meet the body, mm"},
    Message{
        "rub", "[x y z [dx dy dz]]", 0, 6,
        "where inlets 3 and 4 rub the body, mm, and the direction of positive velocity; none: at "
        "the point"},
    Message{"friction", "static dynamic stribeck breakaway stiffness damping viscosity roughness",
            1, 8, "friction law as in contact_friction~, with its defaults for missing numbers"},
    Message{"board", "name [dx dy dz] or none", 1, 4,
            "read the table of a second body, held by supports, that the first lies on; displaced "
            "by dx dy dz mm in its axes"},
    Message{"rest", "[x y z] ...", 0, 24,
            "up to 8 points where body and board touch, mm in the body's axes; none: nowhere"},
    Message{"listener", "i x y z or x1 y1 z1 ...", 3, 12,
            "position of listener i of 1 to 4, or of all from the first on, mm; nearer than 18 cm "
            "sound is up to 0.5 ms late"},
    Message{"material", "E rho", 2, 2, "Pa and kg/m^3; 0: the table's"},
    Message{"preset",
            "aluminium|steel|iron|brass|bronze|copper|lead|glass|ceramic|wood|plastic|"
            "polycarbonate|rubber|table",
            1, 1, "elasticity, density and damping of a material; table: as it was read"},
    Message{
        "shape", "d1 d2 ...", 1, 3 * 4096,
        "displacements of the table's shape parameters, mm, in their order; 0: the table's shape"},
    Message{"cp", "id x y z", 4, 4, "position of a control point of the body's shape, mm"},
    Message{"solver", "path | auto", 1, 1,
            "the program modal_fem that solves shapes anew; auto: beside the object or in PATH; "
            "restarts it"},
    Message{"rayleigh", "a b", 2, 2, "damping (a + b omega^2)/2 in 1/s"},
    Message{"loss", "eta", 1, 1, "the same loss factor at all frequencies"},
    Message{"losscurve", "f1 eta1 f2 eta2 ...", 2, 64, "loss factor over frequency in Hz"},
    Message{"damping", "table | rayleigh a b | loss eta | losscurve f1 eta1 ...", 1, 65,
            "the table's own damping, or the message of that name; as dump says it"},
    realtime(Message{"reset", "", 0, 0, "silence"}),
    Message{"info", "", 0, 0, "body, counts, frequencies and decay times, out of the info outlet"},
    Message{"ring", "", 0, 0,
            "levels of the modes, dB from full scale, by frequency, out of the info outlet"},
};

inline constexpr std::array kArguments{CreationArgument{"load"}};
inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "force", "N", "external force into the body at the point"},
    Port{Port::Kind::kSignal, "height", "m", "with pos 1: of a hand's striker above the point"},
    Port{Port::Kind::kSignal, "normal", "N",
         "normal force of a rubbing surface; 0: it does not touch"},
    Port{Port::Kind::kSignal, "velocity", "m/s", "of the rubbing surface, along its direction"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "left", "", "pressure at listener 1 times gain"},
    Port{Port::Kind::kSignal, "right", "", "pressure at listener 2 times gain"},
    Port{Port::Kind::kSignal, "contact", "N", "force between strikers and body, impulses exact"},
    Port{Port::Kind::kControl, kInfoOutlet, "", "answers to info, ring, get and dump"},
    Port{Port::Kind::kSignal, "third", "",
         "with -out 3 or more: pressure at listener 3 times gain"},
    Port{Port::Kind::kSignal, "fourth", "", "with -out 4: pressure at listener 4 times gain"},
    Port{Port::Kind::kSignal, "friction", "N", "friction force along the body's surface"},
};

} // namespace tactus::modal_impact
