#pragma once

#include "core/declaration.hpp"

#include <array>
#include <cstddef>

/// Tables of [phantom~]'s parameters, messages, inlets and outlets.
namespace tactus::phantom_signal {

inline constexpr std::array kParameters{
    Parameter{"vel", "", 0, 0, 1, "1: velocities at the outlets vx, vy and vz"},
    Parameter{"delay", "ms", 3, 0, 100,
              "wall clock: how far behind the newest position the outlets play"},
    Parameter{"gate", "", 1, 0, 1,
              "1: vib acts only while the handle touches a body of the scene, along its normal"},
};
enum ParameterIndex : std::size_t { kVel, kDelay, kGate };

inline constexpr std::array kMessages{
    Message{"name", "word", 1, 1, "of the phantom whose servo this is; - is one without a name"},
};
enum MessageIndex : std::size_t { kName };

inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "fx", "N", "force to the right, added to the phantom's"},
    Port{Port::Kind::kSignal, "fy", "N", "force up"},
    Port{Port::Kind::kSignal, "fz", "N", "force towards the user"},
    Port{Port::Kind::kSignal, "vib", "N",
         "vibration along the normal of what is touched, low-passed at 0.4 of the servo's rate"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "x", "", "position from left to right, 0..1 over the workspace"},
    Port{Port::Kind::kSignal, "y", "", "position from bottom to top, 0..1"},
    Port{Port::Kind::kSignal, "z", "", "position from far to near, 0..1"},
    Port{Port::Kind::kControl, kInfoOutlet, "", "status attached|waiting name; answers to get"},
    Port{Port::Kind::kSignal, "vx", "m/s", "with -vel 1: velocity to the right"},
    Port{Port::Kind::kSignal, "vy", "m/s", "velocity up"},
    Port{Port::Kind::kSignal, "vz", "m/s", "velocity towards the user"},
    Port{Port::Kind::kSignal, "net1", "", "first pickup of the phantom's mass-spring network, SI"},
    Port{Port::Kind::kSignal, "net2", "", "second pickup"},
};
inline constexpr std::array kArguments{CreationArgument{"name"}};

} // namespace tactus::phantom_signal
