#pragma once

#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/network/network_model.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "core/haptic/servo/servo.hpp"
#include "core/haptic/signal/signal_link.hpp"
#include "externals/phantom/servo/termination_guard.hpp"

#include <memory>

namespace tactus::phantom {

/// A servo with all models that its steps use. It lives as long as the thread that runs the steps:
/// a thread that hangs in a call of a driver keeps its rig, and the object continues with a new
/// one. Therefore the models of the servo belong to the rig and not to the object.
struct ServoRig {
  haptic::SceneModel scene{};
  haptic::EffectModel effects{};
  haptic::NetworkModel network{};
  haptic::LocalModels<3> local_models{{&scene, &effects, &network}}; ///< passive models
  haptic::ActiveEffects active_effects{effects};
  std::shared_ptr<haptic::SignalLink> signals = std::make_shared<haptic::SignalLink>();
  haptic::LocalModels<2> patch_models{{signals.get(), &active_effects}}; ///< forces of the patch
  std::shared_ptr<haptic::Backend> device{};                             ///< a real device
  haptic::Servo servo{};
  TerminationGuard guard{servo.exchange().motors};

  ServoRig() {
    effects.set_scene(scene, local_models.force_of(0));
    signals->set_scene(scene);
    signals->set_network(network);
  }
  /// Passes the limits that the models need from the device's capabilities.
  void set_limits(const haptic::Caps& caps) noexcept {
    scene.set_continuous_force(caps.continuous_force_n);
    effects.set_damping_limit(caps.damping_limit_n_s_per_m);
  }
};

} // namespace tactus::phantom
