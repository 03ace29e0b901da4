#pragma once

#include "core/declaration.hpp"

#include <array>
#include <cstddef>
#include <string_view>

/// Declaration of [footstep~]: inlets, outlets, parameters and messages.
namespace tactus::footstep {

inline constexpr std::array<std::string_view, 2> kSources{"gait", "sensors"};
inline constexpr std::array<std::string_view, 5> kStyleNames{"walk", "run", "sneak", "upstairs",
                                                             "downstairs"};
inline constexpr std::array<std::string_view, 2> kSides{"left", "right"};
inline constexpr std::array<std::string_view, 2> kUnits{"newton", "weight"};

enum ParameterIndex : std::size_t {
  kSource,
  kWalk,
  kSpeed,
  kRun,
  kWeight,
  kShoe,
  kFeet,
  kVariation,
  kUnit,
  kMix,
  kGain,
  kDriveGain,
  kSensitivity,
  kLimit,
  kDelay,
  kCommon,
  kSeed,
  kRoom,
  kGait,
};
inline constexpr std::array kParameters{
    Parameter{"source", "", 0, 0, 1, "whose steps: a walker's, made here, or the inlets' forces",
              kSources},
    Parameter{"walk", "", 0, 0, 1,
              "1: the walker sets off and walks on; 0: halts with one more step and stands"},
    Parameter{"speed", "m/s", 1.4, 0.3, 8,
              "of the walker on level ground; sneaking and stairs are slower, as people are"},
    Parameter{"run", "", 0, 0, 1, "1: gait run, at 1.5 m/s or more; 0: gait walk"},
    Parameter{"weight", "N", 700, 1, 10000, "of the body; forces count relative to it"},
    Parameter{"shoe", "", 0.4, 0, 1, "hardness of the sole: 0 soft or barefoot, 1 hard"},
    Parameter{"feet", "", 1, 1, 2, "feet that sound"},
    Parameter{"variation", "", 0.04, 0, 0.5,
              "of the walker from step to step (3 to 5 % in people)"},
    Parameter{"unit", "", 0, 0, 1, "of the inlets: newtons, or body weights", kUnits},
    Parameter{"mix", "", 0, 0, 1, "0: the first surface, 1: the second"},
    Parameter{"gain", "", 1, 0, 1000, "of the sound"},
    Parameter{"drive_gain", "", 1, 0, 1000, "of the drives"},
    Parameter{"sensitivity", "g", 3, 0.01, 100, "acceleration of the actuator at a drive of 1"},
    Parameter{"limit", "g", 3, 0, 3, "largest acceleration"},
    Parameter{"delay", "ms", 0, 0, 200, "of the drives, to wait for a slower path"},
    Parameter{"common", "", 0, 0, 1,
              "of the drives: 0 each plays what is under it, 1 both the whole foot by their force"},
    seed_parameter<"seed of everything that is random">(),
    Parameter{"room", "", 1, 0, 10,
              "times the room's answer that a surface comes with; 0: in the open"},
    Parameter{"gait", "", 0, 0, 4, "how the walker walks", kStyleNames},
};

enum MessageIndex : std::size_t {
  kSurface,
  kStep,
  kBang,
  kTurn,
  kJump,
  kScuff,
  kDrag,
  kCalibrate,
  kEqualise,
  kSurfaces,
  kReset
};
inline constexpr std::array kMessages{
    takes_file(Message{
        "surface",
        "[left|right] "
        "wood|creak|underbrush|snow|frozensnow|sand|gravel|metal|highgrass|dryleaves|concrete|"
        "dirt|puddle|water|carpet|file.txt [another [mix]]",
        1, 4, "the ground, or two and how much of the second; of both feet, or of one"}),
    realtime(Message{"step", "[left|right]", 0, 1,
                     "one step; a foot that is down lands once more beside it"}),
    realtime(Message{"bang", "", 0, 0, "one step; with feet 2 the feet in turn"}),
    realtime(
        Message{"turn", "[degrees]", 0, 1,
                "the next step pivots by 1 to 180 degrees (90): the ball slides under the load"}),
    realtime(Message{
        "jump", "[m]", 0, 1,
        "crouches, jumps on both feet 0.01 to 1 m high (0.3), lands; a walker halts before"}),
    realtime(Message{"scuff", "[left|right]", 0, 1,
                     "the ball strikes and slides 15 cm, in that foot's next swing or at once"}),
    realtime(Message{
        "drag", "[left|right] [m [m/s]]", 0, 3,
        "that foot slides 0.01 to 20 m (0.5) at 0.02 to 5 m/s (0.5) under 30 % of the weight; "
        "of a walker for its next swing"}),
    Message{"calibrate", "heel|ball [reading N reading N ...]", 1, 65,
            "at least five rising points from what the sensor reads to newtons; none: as it is"},
    Message{"equalise", "[f1 dB1 f2 dB2 ...]", 0, 32,
            "undoes the actuator's response at these Hz; none: flat"},
    Message{"surfaces", "", 0, 0, "names of the fifteen, out of the info outlet"},
    realtime(Message{"reset", "", 0, 0, "silence within 5 ms, both feet in the air"}),
};

inline constexpr std::array kArguments{CreationArgument{"surface"}};
inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "heel", "N", "source sensors: force under the (left) heel"},
    Port{Port::Kind::kSignal, "ball", "N", "force under the ball of the (left) foot"},
    Port{Port::Kind::kSignal, "heel_2", "N", "feet 2: right heel"},
    Port{Port::Kind::kSignal, "ball_2", "N", "feet 2: ball of the right foot"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "sound", "", "of the (left) foot, within +-1"},
    Port{Port::Kind::kSignal, "heel_drive", "", "to the actuator under the heel"},
    Port{Port::Kind::kSignal, "ball_drive", "", "to the actuator under the ball"},
    Port{Port::Kind::kSignal, "force", "N", "under the foot"},
    Port{Port::Kind::kSignal, "sound_2", "", "feet 2: of the right foot"},
    Port{Port::Kind::kSignal, "heel_drive_2", "", "feet 2: right heel"},
    Port{Port::Kind::kSignal, "ball_drive_2", "", "feet 2: right ball"},
    Port{Port::Kind::kSignal, "force_2", "N", "feet 2: under the right foot"},
    Port{Port::Kind::kControl, "info", "",
         "step left|right heel|ball (with m/s), heel_up|toe_off; answers"},
};

} // namespace tactus::footstep
