#pragma once

#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo.hpp"
#include "core/haptic/signal_link.hpp"
#include "externals/phantom/live_connections.hpp"

#include <memory>

namespace tactus::phantom {

/// Everything that a servo's steps touch, in one piece that lives as long as the thread which takes
/// them: a thread that hangs in a call of a driver keeps its rig, and the object goes on with
/// another. Models that the servo runs belong here, not into the object.
struct ServoRig {
  haptic::SceneModel scene{};
  std::shared_ptr<haptic::SignalLink> signals = std::make_shared<haptic::SignalLink>();
  std::shared_ptr<haptic::Backend> device{}; ///< a real one
  haptic::Servo servo{};
  TerminationGuard guard{servo.exchange().motors};

  ServoRig() { signals->watch(scene); }
};

} // namespace tactus::phantom
