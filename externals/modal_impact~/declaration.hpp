#pragma once

#include "core/declaration.hpp"

#include <array>
#include <cstddef>
#include <string_view>

/// What [modal_impact~] says of itself.
namespace tactus::modal_impact {

inline constexpr std::array<std::string_view, 4> kRadiations{"modal", "raw", "body", "none"};
inline constexpr std::array<std::string_view, 2> kContacts{"coupled", "pulse"};
inline constexpr std::array<std::string_view, 2> kResolveModes{"auto", "off"};

enum ParameterIndex : std::size_t {
  kRadiation,
  kContact,
  kSize,
  kModes,
  kCull,
  kChoke,
  kGain,
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
};
inline constexpr std::array kParameters{
    Parameter{
        "radiation", "", 0, 0, 3,
        "how the body sounds to a listener: baffled surface mode by mode, recorded or computed "
        "surface velocities, free body by its multipoles, or bare surface velocity",
        kRadiations},
    Parameter{"contact", "", 0, 0, 1,
              "striker and body coupled, or a pulse of known shape for many blows at once",
              kContacts},
    Parameter{"size", "", 1, 0.01, 100, "times the table's lengths"},
    Parameter{"modes", "", 0, 0, 20000, "most modes that sound; 0: all"},
    Parameter{"cull", "dB", 90, 20, 200,
              "a mode quieter to the ear than the blow's loudest by this is left out"},
    Parameter{"choke", "s", 0, 0, 100, "decay time of a hand that damps the body; 0: none"},
    Parameter{"gain", "1/Pa", 0.01, 0, 1000,
              "full scales for 1 Pa of sound pressure: 100 Pa reach full scale at 0.01"},
    Parameter{"restitution", "", 1, 0.01, 1,
              "speed after over speed before on a wall; below 1 it sets the contact's loss"},
    Parameter{"spring", "N/m", 0, 0, 100000,
              "above 0, with pos: inlet 2 is answered by this spring in the force outlet"},
    Parameter{"pos", "", 0, 0, 1, "1: inlet 2 is the height of a led striker above the point"},
    Parameter{"doppler", "", 0, 0, 1, "1: a listener that moves hears the pitch bend"},
    Parameter{"voices", "", 8, 1, 64, "contacts at once; a blow more ends the oldest"},
    Parameter{"out", "", 2, 1, 4, "listeners; 1 sounds on both sides at half the cost"},
    Parameter{"sync", "", 0, 0, 1,
              "1: tables and changes are worked out at once, so that renders repeat; 0: beside"},
    Parameter{"rest_stiffness", "N/m^a", 4e8, 100, 1e13,
              "k of what lies between body and board at each point of rest, k d^a: felt"},
    Parameter{"rest_exponent", "", 2.3, 1, 5, "its a: 1 a spring, 1.5 hard and round, 2.3 felt"},
    Parameter{"rest_loss", "s/m", 2, 0, 100, "its loss: force k d^a (1 + loss v)"},
    Parameter{"rest_force", "N", 0, 0, 1000,
              "what presses body and board together besides the weight, all points together"},
    Parameter{"resolve", "", 0, 0, 1,
              "when the shape has moved: its modes are solved anew beside, or extrapolated alone",
              kResolveModes},
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
  kReset,
  kInfo,
  kRing,
};
inline constexpr std::array kMessages{
    Message{"load", "file.npz [-sync]", 1, 2,
            "read a body's table; the old body goes on until then"},
    Message{"hit", "[x y z] v", 1, 4,
            "blow at x y z mm with v m/s; without a place where the last one was"},
    Message{"hitv", "vertex v", 2, 2, "blow at a vertex of the table"},
    Message{"hitf", "face u v speed", 4, 4,
            "blow on a triangle, u and v the weights of its second and third corner"},
    Message{"drop", "[x y z] h", 1, 4,
            "the striker falls h mm onto x y z mm and bounces until it lies"},
    Message{"bang", "", 0, 0, "the last blow again"},
    Message{"normal", "[x y z]", 0, 3,
            "direction out of the body that blows go against; none: the surface's"},
    Message{"striker", "mass radius E nu", 4, 4, "a ball: kg, m, Pa (Hertz' contact)"},
    Message{"hardness", "k exponent loss", 1, 3,
            "contact law k d^exponent (1 + loss v) instead of Hertz'; 0: Hertz"},
    Message{"point", "x y z or vertex", 1, 3, "where inlets 1 and 2 meet the body, mm"},
    Message{"rub", "x y z [dx dy dz]", 3, 6,
            "where inlets 3 and 4 rub the body, mm, and the direction that its velocity counts in"},
    Message{"friction", "static dynamic stribeck breakaway stiffness damping viscosity roughness",
            1, 8, "law of what rubs, as of contact_friction~; what is not given is as there"},
    Message{"board", "file.npz [dx dy dz] or none", 1, 4,
            "read the table of a second body, held by supports, that the first lies on; displaced "
            "by dx dy dz mm in its axes"},
    Message{"rest", "[x y z] ...", 0, 24,
            "up to 8 points where body and board touch, mm in the body's axes; none: nowhere"},
    Message{"listener", "i x y z", 4, 4,
            "places listener i of 1 to 4, mm; nearer than 18 cm all sounds up to 0.5 ms late"},
    Message{"material", "E rho", 2, 2, "Pa and kg/m^3; 0: the table's"},
    Message{"preset",
            "aluminium|steel|iron|brass|bronze|copper|lead|glass|ceramic|wood|plastic|"
            "polycarbonate|rubber|table",
            1, 1, "elasticity, density and damping of a material"},
    Message{
        "shape", "d1 d2 ...", 1, 3 * 4096,
        "displacements of the table's shape parameters, mm, in their order; 0: the table's shape"},
    Message{"cp", "id x y z", 4, 4, "position of a control point of the body's shape, mm"},
    Message{"solver", "path | auto", 1, 1,
            "the program modal_fem that solves the shape anew, or the one that is found beside the "
            "object or in PATH; starts it anew"},
    Message{"rayleigh", "a b", 2, 2, "damping (a + b omega^2)/2 in 1/s"},
    Message{"loss", "eta", 1, 1, "the same loss factor at all frequencies"},
    Message{"losscurve", "f1 eta1 f2 eta2 ...", 2, 64, "loss factor over frequency in Hz"},
    Message{"reset", "", 0, 0, "silence"},
    Message{"info", "", 0, 0, "body, counts, frequencies and decay times, out of the info outlet"},
    Message{
        "ring", "", 0, 0,
        "levels of the modes that ring, dB from full scale, by frequency, out of the info outlet"},
};

inline constexpr std::array kArguments{CreationArgument{"load"}};
inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "force", "N", "pushes into the body at the point"},
    Port{Port::Kind::kSignal, "height", "m", "with pos 1: of a led striker above the point"},
    Port{Port::Kind::kSignal, "normal", "N",
         "how hard a surface that rubs presses; 0: it does not touch"},
    Port{Port::Kind::kSignal, "velocity", "m/s", "of the surface that rubs, along its direction"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "left", "", "pressure at listener 1 times gain"},
    Port{Port::Kind::kSignal, "right", "", "pressure at listener 2 times gain"},
    Port{Port::Kind::kSignal, "contact", "N", "force between strikers and body, impulses exact"},
    Port{Port::Kind::kControl, kInfoOutlet, "", "answers to info, ring, get and dump"},
    Port{Port::Kind::kSignal, "third", "",
         "with -out 3 or more: pressure at listener 3 times gain"},
    Port{Port::Kind::kSignal, "fourth", "", "with -out 4: pressure at listener 4 times gain"},
    Port{Port::Kind::kSignal, "friction", "N", "force of what rubs along the body's surface"},
};

} // namespace tactus::modal_impact
