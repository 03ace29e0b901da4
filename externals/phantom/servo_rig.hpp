#pragma once

#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/network/network_model.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "core/haptic/servo/servo.hpp"
#include "core/haptic/signal/signal_link.hpp"
#include "externals/phantom/live_connections.hpp"

#include <memory>

namespace tactus::phantom {

/// Everything that a servo's steps touch, in one piece that lives as long as the thread which takes
/// them: a thread that hangs in a call of a driver keeps its rig, and the object goes on with
/// another. Models that the servo runs belong here, not into the object.
struct ServoRig {
  haptic::SceneModel scene{};
  haptic::EffectModel effects{};
  haptic::NetworkModel network{};
  haptic::LocalModels<3> local_models{{&scene, &effects, &network}}; ///< passive by themselves
  haptic::ActiveEffects active_effects{effects};
  std::shared_ptr<haptic::SignalLink> signals = std::make_shared<haptic::SignalLink>();
  haptic::LocalModels<2> patch_models{{signals.get(), &active_effects}}; ///< the patch's wish
  std::shared_ptr<haptic::Backend> device{};                             ///< a real one
  haptic::Servo servo{};
  TerminationGuard guard{servo.exchange().motors};

  ServoRig() {
    effects.set_scene(scene, local_models.force_of(0));
    signals->set_scene(scene);
    signals->set_network(network);
  }
};

} // namespace tactus::phantom
