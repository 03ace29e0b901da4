#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/network/shapes.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "core/haptic/signal/signal_player.hpp"
#include "tests/core/haptic/rig.hpp"
#include "tests/core/haptic/scene/meshes.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>

namespace {
std::atomic<long> allocations{0}, frees{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1))
    return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  ++frees;
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  ++frees;
  std::free(memory);
}

using namespace tactus::haptic;
using Hosted = test::HostedServo<SimulatedDevice>;

// Not named *_test.cpp: operator new cannot be combined with other files
// (cmake/CombinedSources.cmake).

TEST_CASE("a servo with scene, effects, network and signals allocates and frees nothing while they "
          "are edited, for any hand and requests") {
  const long none = allocations;
  CHECK(std::make_unique<int>(1) != nullptr);
  CHECK(allocations == none + 1); // the counter counts

  Hosted rig;
  SceneModel scene;
  EffectModel effects;
  NetworkModel network;
  LocalModels<3> models{{&scene, &effects, &network}};
  effects.set_scene(scene, models.force_of(0));
  SignalLink link;
  link.set_scene(scene);
  link.set_network(network);
  link.configure(SignalLink::Time::kLogical, 1000,
                 {[](void* self) {
                    static_cast<Hosted*>(self)->step({1, 2, 3});
                  },
                  &rig});
  rig.servo.attach(rig.device, &models, &link);
  rig.servo.exchange().tracing = true;
  rig.device.set_path(CirclePath{{}, 0.03, 0.5});
  SignalPlayer player;
  player.prepare(48000);
  player.attach(&link);
  const auto ball = test::mesh_sphere(0.025, 30, 30);
  for (int edit = 0; edit < 40; ++edit) {
    SimulatedDevice::Settings simulation;
    simulation.noise_m = 1e-5;
    simulation.hand.hold = static_cast<HandSettings::Hold>(edit % 4);
    rig.device.set(simulation);
    auto bodies = std::make_unique<Scene>();
    for (std::uint64_t i = 0; i < 16; ++i) {
      const double angle = static_cast<double>(i);
      bodies->bodies.push_back(
          {i + 1 + static_cast<std::uint64_t>(edit) / 4,
           i == 0   ? Shape(ball)
           : i == 1 ? Shape(Plane{})
                    : Shape(Sphere{0.01}),
           {{0.02 * std::cos(angle), 0.02 * std::sin(angle), -0.001 * edit}, {}},
           {500, 0, 0.3}});
    }
    scene.publish(std::move(bodies));
    auto masses = std::make_unique<Network>();
    NetworkPart part = make_string({20 + edit, {-0.05, 0, 0}, {0.05, 0, 0}, 1e-3, 10, 1e-3, 0});
    masses->masses = part.masses;
    masses->links = part.links;
    for (std::size_t i = 0; i < masses->masses.size(); ++i)
      masses->masses[i].key = i + 1;
    masses->pickups[0].mass = 5;
    network.publish(std::move(masses));
    EffectSettings settings;
    settings.inertia = {0.1 * (edit + 1)};
    settings.friction = {0.5};
    settings.relief = {1e-4, 1e-3, {1, 0, 0}};
    effects.set(settings);
    const long allocated = allocations, freed = frees;
    for (int block = 0; block < 30; ++block) {
      rig.set({});
      if (block % 2)
        rig.servo.exchange().motors.enable();
      else
        rig.servo.exchange().motors.emergency_stop();
      rig.device.set_button(1, block % 3 == 0);
      network.queue_action(NetworkModel::Pluck{3, {0, 0, 1}, 1e-3});
      network.queue_action(NetworkModel::GrabNearest{});
      player.begin_block(64);
      for (int n = 0; n < 64; ++n)
        static_cast<void>(player.process({{0.1, 0, 0}, 0.1}));
      player.end_block(0);
    }
    CHECK(allocations == allocated);
    CHECK(frees == freed);
  }
  CHECK(rig.tick >= 1560);
}
