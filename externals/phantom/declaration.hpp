#pragma once

#include "core/declaration.hpp"
#include "core/haptic/chain/chain.hpp"

#include <array>
#include <cstddef>

/// Tables of [phantom]'s parameters, messages, inlets and outlets. Each enum is in the order of the
/// table above it.
namespace tactus::phantom {

inline constexpr std::array<std::string_view, 2> kUnits{"newton", "norm"};

inline constexpr std::array kParameters{
    Parameter{"rate", "Hz", 1000, 200, 4000, "servo ticks a second"},
    Parameter{"outrate", "Hz", 1000, 0, 4000, "positions a second at the outlets; 0: only on bang"},
    Parameter{"repeat", "", 0, 0, 1, "1: send positions that have not changed, too"},
    Parameter{"units", "", 0, 0, 1, "of the force inlets; norm: 1 is forcemax", kUnits},
    Parameter{"forcemax", "N", 8, 0, 40, "longest force ever written"},
    Parameter{"slew", "N/ms", 2, 1e-3, 1000, "fastest change of the force"},
    Parameter{"extrap", "ms", 0, 0, 20, "go on along the slope this long after a target"},
    Parameter{"strict", "", 0, 0, 1, "1: force messages must keep coming"},
    Parameter{"resume", "", 0, 0, 1,
              "1: after a freeze of the host a real device's force returns without motors 1"},
    Parameter{"passivity", "", 1, 0, 1, "1: take back energy that the sampled force creates"},
    Parameter{"tank", "J", 5e-3, 0, 1000, "most energy of a contact that a bounce may return"},
    Parameter{"allowance", "W", haptic::kAllowance_w, 0, 10,
              "power that the delay of the patch's forces may create, unbraked"},
    Parameter{"damp", "N s/m", 0, 0, 100, "viscous force added to everything"},
    Parameter{"walls", "N/m", 0, 0, 5000, "stiffness of soft walls at the workspace's faces"},
    not_stored(
        Parameter{"motors", "", 1, 0, 1, "0: no force; 1: back over half a second, ends an estop"}),
    Parameter{"mass", "kg", 0.1, 1e-3, 100, "simulated: of the handle"},
    Parameter{"viscous", "N s/m", 0.5, 0, 1000, "simulated: friction of the handle"},
    Parameter{"stops", "", 1, 0, 1, "simulated: hard stops 5 mm outside the workspace"},
    Parameter{"resolution", "mm", 0, 0, 10, "simulated: encoder step; 0 is exact"},
    Parameter{"noise", "mm", 0, 0, 10, "simulated: reading noise, plus or minus"},
    seed_parameter<"simulated: seed of noise, tremor and wander">(),
    Parameter{"latency", "ticks", 0, 0, 8, "simulated: from the handle to its reading"},
};
enum ParameterIndex : std::size_t {
  kRate,
  kOutRate,
  kRepeat,
  kUnitsParameter,
  kForceMax,
  kSlew,
  kExtrap,
  kStrict,
  kResume,
  kPassivity,
  kTank,
  kAllowance,
  kDamp,
  kWalls,
  kMotors,
  kMass,
  kViscous,
  kStops,
  kResolution,
  kNoise,
  kSeed,
  kLatency,
  kParameterCount
};
static_assert(kParameters.size() == kParameterCount);

inline constexpr std::array kMessages{
    Message{"bang", "", 0, 0, "send position and reported values now"},
    Message{"list", "fx fy fz", 3, 3, "all three forces"},
    Message{"backend", "name ...", 1, 8, "choose the device's driver"},
    Message{"open", "index|serial|path", 0, 1, "connect the device"},
    Message{"close", "", 0, 0, "let the force fall and disconnect"},
    Message{"name", "word", 1, 1, "tells this device from others; devices and dump show it"},
    Message{"devices", "", 0, 0, "list the devices of all drivers; one in use is not asked"},
    Message{"driver", "word ...", 1, 16, "a setting of the device's own driver"},
    Message{"firmware", "file", 1, 1, "what the device's own software sends it at power-up"},
    Message{"home", "", 0, 0, "find the device's zero again"},
    Message{"calibrate", "", 0, 0, "let the device's driver calibrate it"},
    Message{"clock", "auto|logical|wall", 1, 1, "what steps the servo"},
    Message{"workspace", "device | learn 0|1 | xmin ymin zmin xmax ymax zmax", 1, 6,
            "mm; what the outlets' 0..1 stands for"},
    Message{"map", "axes signs", 1, 4, "project axes from the device's, e.g. zxy 1 -1 1"},
    Message{"interp", "auto|off|ms", 1, 1, "way from one force to the next"},
    Message{"watchdog", "hold_ms ramp_ms", 2, 2, "silence before the force falls, and how fast"},
    Message{
        "scene",
        "add name shape ... | mat name k b mu | move name x y z [ms] | del name|all | tool mm | "
        "k N/m | load file",
        2, 16, "bodies that the handle feels; mm, N/m, N s/m"}
        .with_name_behind("load"),
    Message{
        "effect",
        "constant fx fy fz | spring k x y z [N] | viscous b | inertia kg [k b] | friction N [k] "
        "| texture N mm [dx dy dz] | relief mm mm [dx dy dz] | name off | off",
        1, 6, "force effects, several at a time; N, N/m, N s/m, kg, mm"},
    Message{
        "network",
        "string name n ... | membrane name nx ny ... | mass name kg x y z | anchor name [x y z] "
        "| link name name k [b l0 pull|push] | load file | del name|all | touch mm [k b] | grab "
        "name|nearest|off | pluck name fx fy fz ms | listen name axis ... | drag 1/s | gravity "
        "gx gy gz | rate Hz | reset",
        1, 16, "masses and springs that the hand feels and phantom~ plays: docs/network.md"}
        .with_name_behind("load"),
    Message{"torques", "0|1", 1, 1, "1: torque and grip are sent to a device that has them"},
    Message{"torque", "tx ty tz", 3, 3, "on the handle, about x, y, z; N m"},
    Message{"grip", "N", 1, 1, "force of the gripper"},
    Message{
        "estop", "", 0, 0,
        "no force at once, until motors 1; holds for the next phantom of this name or device, too"},
    Message{
        "report", "tag 0|1", 2, 2,
        "mm, vel, force, button, status, jitter, error, hit, contact, release, rot, torque, grip"},
    Message{"stats", "[reset]", 0, 1, "counters and timing of the servo"},
    Message{"trace", "file|stop", 1, 1, "write every tick to a CSV file"},
    Message{"hand", "free | rigid | spring [K B] | person [K B tremor wander yield]", 1, 6,
            "simulated: who holds the handle; N/m, N s/m, mm, mm, ms"},
    takes_file(Message{"path", "file | line ... | circle ... | lissajous ... | array x y z [ms]", 1,
                       10, "simulated: where the hand goes; mm, ms, Hz"})
        .with_name_behind("array"),
    Message{"target", "x y z", 3, 3, "simulated: draw the hand there smoothly; mm"},
    Message{"seek", "ms", 1, 1, "simulated: time on the path"},
    Message{"button", "number 0|1", 2, 2, "simulated: press or let go"},
};
enum MessageIndex : std::size_t {
  kBang,
  kList,
  kBackend,
  kOpen,
  kClose,
  kName,
  kDevices,
  kDriver,
  kFirmware,
  kHome,
  kCalibrate,
  kClock,
  kWorkspace,
  kMap,
  kInterp,
  kWatchdog,
  kScene,
  kEffect,
  kNetwork,
  kTorques,
  kTorque,
  kGrip,
  kEstop,
  kReport,
  kStats,
  kTrace,
  kHand,
  kPath,
  kTarget,
  kSeek,
  kButton,
  kMessageCount
};
static_assert(kMessages.size() == kMessageCount);

inline constexpr std::array kInlets{
    Port{Port::Kind::kControl, "fx", "N", "force to the right, and all messages"},
    Port{Port::Kind::kControl, "fy", "N", "force up"},
    Port{Port::Kind::kControl, "fz", "N", "force towards the user"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kControl, "x", "", "position from left to right, 0..1 over the workspace"},
    Port{Port::Kind::kControl, "y", "", "position from bottom to top, 0..1"},
    Port{Port::Kind::kControl, "z", "", "position from far to near, 0..1"},
};
inline constexpr std::array kArguments{CreationArgument{"backend"}};

} // namespace tactus::phantom
