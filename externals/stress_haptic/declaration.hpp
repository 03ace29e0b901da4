#pragma once

#include "core/declaration.hpp"
#include "core/stress/feedback.hpp"

#include <array>
#include <cstddef>

/// Declaration of [stress_haptic]: inlets, outlets, parameters and messages. Each table has the
/// order of the enum below it; the words of a choice have the order of the enums in core/stress.
namespace tactus::stress_haptic {

inline constexpr std::array<std::string_view, 3> kModes{"mean", "weighted", "axis"};
inline constexpr std::array<std::string_view, 2> kWeightings{"uniform", "volume"};
inline constexpr std::array<std::string_view, 2> kSigns{"signed", "abs"};
inline constexpr std::array<std::string_view, 4> kRenders{"spring", "damper", "both", "off"};
inline constexpr std::array<std::string_view, 2> kStates{"vonmises", "shear"};
inline constexpr std::array<std::string_view, 4> kResolves{"auto", "taylor", "pcg", "full"};
inline constexpr std::array<std::string_view, 2> kNorms{"mean", "sum"};

inline constexpr std::array kParameters{
    Parameter{"mode", "", 0, 0, 2,
              "what is felt: the mean stress, the stress weighted by its sensitivity, or that for "
              "each axis",
              kModes},
    Parameter{"weights", "", 0, 0, 1, "of the elements: all alike, or by volume", kWeightings},
    Parameter{"sens", "", 1, 0, 1, "sensitivities with their sign, or their magnitude", kSigns},
    Parameter{"render", "", 0, 0, 3, "what gamma sets: stiffness, damping, both or no force",
              kRenders},
    Parameter{"state", "", 0, 0, 1, "which stress: von Mises or maximum shear", kStates},
    Parameter{"resolve", "", 0, 0, 3,
              "when the shape has moved: the cheapest solver, Taylor's series alone, conjugate "
              "gradients, or a new factor",
              kResolves},
    Parameter{"norm", "", 0, 0, 1, "mean, or sum as the paper prints equations 1 and 2", kNorms},
    Parameter{"power", "", 1, 1, stress::kMaxPower,
              "q of mode mean: 1 the mean, above it (mean of s^q)^(1/q), which follows the largest "
              "stresses; rounded to a whole number"},
    Parameter{"drag", "", 1, 0, 1, "1: the handle moves the grabbed control point"},
    Parameter{"scale", "", 1, 1e-3, 1000, "motion of the control point over that of the handle"},
    Parameter{"nominal", "N/m", 1000, 0, 100000, "nominal stiffness of the device"},
    Parameter{"share", "", 0.6, 0, 1, "of the nominal stiffness: limit of kmin and kmax"},
    Parameter{"damping", "N s/m", 5, 0, 1000, "limit of bmin and bmax"},
};
enum ParameterIndex : std::size_t {
  kMode,
  kWeights,
  kSens,
  kRender,
  kState,
  kResolve,
  kNorm,
  kPower,
  kDrag,
  kScale,
  kNominal,
  kShare,
  kDamping,
  kParameterCount
};
static_assert(kParameters.size() == kParameterCount);

inline constexpr std::array kMessages{
    takes_file(Message{
        "load", "name", 1, 1,
        "a stress table, NAME or NAME.stress.npz: beside the patch, in the search path, beside the "
        "object"}),
    Message{"cp", "id x y z", 4, 4, "position of a control point, mm"},
    Message{"list", "d ...", 1, 12288, "displacements of all parameters, mm, in the table's order"},
    Message{"grab", "id [0|1]", 1, 2,
            "the control point that is dragged, whose sensitivities weigh; 0 lets go"},
    Message{"release", "", 0, 0, "let go: sensitivities are means over all control points"},
    Message{"reset", "", 0, 0, "the table's shape again"},
    Message{"range", "current | initial | fixed a b", 1, 3,
            "what gamma 0 and 1 stand for: least and largest value of this shape, of the table's "
            "shape, or two numbers (Pa; Pa^2/m in the modes weighted and axis)"},
    Message{"gains", "kmin kmax bmin bmax", 4, 4, "stiffness N/m and damping N s/m at gamma 0, 1"},
    Message{"anchor", "here | x y z", 1, 3, "where the spring has no force, mm"},
    Message{"bang", "", 0, 0, "send gamma, force and info now"},
    Message{"points", "", 0, 0,
            "send workspace and control points to the protocol outlet, for haptic_server"},
    Message{"solver", "path | auto", 1, 1,
            "the program part_stress that solves the part again, or the one that is found beside "
            "the object or in PATH; starts it anew"},
    Message{"draw", "[all]", 0, 1,
            "send the picture to the info outlet: faces that have changed, or all of them"},
};
enum MessageIndex : std::size_t {
  kLoad,
  kCp,
  kList,
  kGrab,
  kRelease,
  kReset,
  kRange,
  kGains,
  kAnchor,
  kBang,
  kPoints,
  kSolver,
  kDraw,
  kMessageCount
};
static_assert(kMessages.size() == kMessageCount);

inline constexpr std::array kInlets{
    Port{Port::Kind::kControl, "shape", "mm", "cp id x y z, or a list of parameters; all messages"},
    Port{Port::Kind::kList, "device", "mm, m/s", "list x y z [vx vy vz] of the handle"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kControl, "gamma", "", "0..1; three numbers in mode axis"},
    Port{Port::Kind::kControl, "force", "N", "list fx fy fz"},
    Port{Port::Kind::kControl, kInfoOutlet, "",
         "gmin gmax raw err method iters ms and more; answers"},
    Port{Port::Kind::kControl, "protocol", "",
         "`hap feedback sequence gamma` and `hap cp ...`, for a haptic_server"},
};
enum OutletIndex : std::size_t { kGammaOutlet, kForceOutlet, kProtocolOutlet = 3 };
inline constexpr std::array kArguments{CreationArgument{"load"}};

} // namespace tactus::stress_haptic
