#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/network/shapes.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "core/haptic/servo/servo.hpp"
#include "core/haptic/signal/signal_player.hpp"
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

TEST_CASE("ten thousand servo ticks allocate nothing, for any hand and requests") {
  const long none = allocations;
  CHECK(std::make_unique<int>(1) != nullptr);
  CHECK(allocations == none + 1); // the counter counts

  SimulatedDevice device;
  SimulatedDevice::Settings simulation;
  simulation.noise_m = 1e-5;
  Servo servo;
  device.set(simulation);
  servo.attach(device);
  servo.exchange().tracing = true;
  for (const auto hold : {HandSettings::Hold::kFree, HandSettings::Hold::kRigid,
                          HandSettings::Hold::kSpring, HandSettings::Hold::kPerson}) {
    simulation.hand.hold = hold;
    device.set(simulation);
    const long before = allocations;
    for (std::uint64_t k = 0; k < 2500; ++k) {
      Command command;
      command.force_n = {1, 2, 3};
      command.number = k + 1;
      command.heartbeat_s = static_cast<double>(k) * 1e-3;
      servo.exchange().commands.write(command);
      servo.exchange().settings.write({});
      if (k % 2)
        servo.exchange().motors.enable();
      else
        servo.exchange().motors.emergency_stop();
      device.set_button(1, k % 3 == 0);
      servo.step({k, command.heartbeat_s, 1e-3});
    }
    CHECK(allocations == before);
  }
}

TEST_CASE("a servo in a scene that is edited, stepped by audio, allocates and frees nothing") {
  SimulatedDevice device;
  device.set({});
  device.set_path(CirclePath{{}, 0.03, 0.5});
  SceneModel model;
  SignalLink link;
  link.set_scene(model);
  Servo servo;
  servo.attach(device, &model, &link);
  struct Stepping {
    Servo* servo;
    std::uint64_t tick;
  } stepping{&servo, 0};
  link.configure(SignalLink::Time::kLogical, 1000,
                 {[](void* self) {
                    auto& s = *static_cast<Stepping*>(self);
                    s.servo->step({s.tick, static_cast<double>(s.tick) * 1e-3, 1e-3});
                    ++s.tick;
                  },
                  &stepping});
  SignalPlayer player;
  player.prepare(48000);
  player.attach(&link);
  for (int edit = 0; edit < 40; ++edit) {
    auto scene = std::make_unique<Scene>();
    for (std::uint64_t i = 0; i < 16; ++i) {
      Body body;
      body.key = i + 1 + static_cast<std::uint64_t>(edit) / 4;
      body.shape = i == 0   ? Shape(test::mesh_sphere(0.025, 30, 30))
                   : i == 1 ? Shape(Plane{})
                            : Shape(Sphere{0.01});
      body.pose.position = {0.02 * std::cos(static_cast<double>(i)),
                            0.02 * std::sin(static_cast<double>(i)), -0.001 * edit};
      body.material.friction = 0.3;
      scene->bodies.push_back(body);
    }
    model.publish(std::move(scene));
    const long before = allocations, freed = frees;
    for (int block = 0; block < 75; ++block) {
      player.begin_block(64);
      for (int n = 0; n < 64; ++n)
        static_cast<void>(player.process({{0.1, 0, 0}, 0.1}));
      player.end_block(0);
    }
    CHECK(allocations == before);
    CHECK(frees == freed);
  }
  CHECK(stepping.tick >= 3900);
}

TEST_CASE("a servo with a network and all effects, both edited, allocates and frees nothing") {
  SimulatedDevice device;
  device.set({});
  device.set_path(CirclePath{{}, 0.03, 0.5});
  SceneModel scene;
  EffectModel effects;
  NetworkModel network;
  LocalModels<3> models{{&scene, &effects, &network}};
  effects.set_scene(scene, models.force_of(0));
  SignalLink link;
  link.set_network(network);
  link.configure(SignalLink::Time::kWall, 1000, {});
  Servo servo;
  servo.attach(device, &models, &link);
  std::uint64_t tick = 0;
  for (int edit = 0; edit < 20; ++edit) {
    auto next = std::make_unique<Network>();
    NetworkPart part = make_string({20 + edit, {-0.05, 0, 0}, {0.05, 0, 0}, 1e-3, 10, 1e-3, 0});
    next->masses = part.masses;
    next->links = part.links;
    for (std::size_t i = 0; i < next->masses.size(); ++i)
      next->masses[i].key = i + 1;
    next->pickups[0].mass = 5;
    network.publish(std::move(next));
    EffectSettings settings;
    settings.inertia = {0.1 * (edit + 1)};
    settings.friction = {0.5};
    settings.relief = {1e-4, 1e-3, {1, 0, 0}};
    effects.set(settings);
    const long before = allocations, freed = frees;
    for (int n = 0; n < 100; ++n, ++tick) {
      network.queue_action({NetworkModel::Action::Kind::kPluck, 3, {0, 0, 1}, 1e-3});
      network.queue_action({NetworkModel::Action::Kind::kGrabNearest, 0, {}, 0});
      servo.step({tick, static_cast<double>(tick) * 1e-3, 1e-3});
    }
    CHECK(allocations == before);
    CHECK(frees == freed);
  }
}
