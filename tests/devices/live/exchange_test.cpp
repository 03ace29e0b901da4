#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/network/shapes.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "core/haptic/signal/signal_player.hpp"
#include "devices/servo_thread.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

// Host, servo and audio at work in three threads, for the thread sanitizer. Nothing here depends on
// how fast they run.

using namespace tactus;
using namespace tactus::haptic;

namespace {

std::unique_ptr<const Scene> scene_of(int edit) {
  auto scene = std::make_unique<Scene>();
  for (int i = 0; i < 1 + edit % 5; ++i) {
    Body body;
    body.key = static_cast<std::uint64_t>(i + 1);
    body.shape = Sphere{0.01 + 0.001 * i};
    body.pose.position = {0.01 * i, 0.001 * (edit % 7), 0};
    body.glide_s = 0.003;
    scene->bodies.push_back(body);
  }
  return scene;
}

std::unique_ptr<const Network> network_of(int edit) {
  auto network = std::make_unique<Network>();
  NetworkPart part = make_string({5 + edit % 7, {-0.03, 0, 0}, {0.03, 0, 0}, 1e-2, 5, 1e-3, 0});
  network->masses = std::move(part.masses);
  network->links = std::move(part.links);
  for (std::size_t i = 0; i < network->masses.size(); ++i)
    network->masses[i].key = i + 1;
  network->pickups[0].mass = 2;
  return network;
}

} // namespace

TEST_CASE("host, servo and audio exchange without a lock and without a race") {
  SimulatedDevice device;
  SimulatedDevice::Settings hand;
  device.set(hand);
  device.set_path(CirclePath{{}, 0.02, 0.3});
  SceneModel scene;
  SignalLink link;
  EffectModel effects;
  NetworkModel network;
  LocalModels<3> models{{&scene, &effects, &network}};
  effects.set_scene(scene, models.force_of(0));
  link.set_scene(scene);
  link.set_network(network);
  link.set_workspace({});
  link.configure(SignalLink::Time::kWall, 1000, {});
  Servo servo;
  servo.attach(device, &models, &link);
  devices::ServoThread runner;
  REQUIRE(runner.start(servo, 1e-3) == "");

  std::atomic<bool> ending{false};
  std::thread audio([&] {
    SignalPlayer player;
    player.prepare(48000);
    player.attach(&link);
    double sum = 0;
    while (!ending) {
      player.begin_block(64);
      for (int i = 0; i < 64; ++i)
        sum += player.process({{0.1, 0, 0}, 0.2}).network[0];
      player.end_block(devices::ServoThread::now_s());
      std::this_thread::sleep_for(std::chrono::microseconds(900));
    }
    CHECK(std::isfinite(sum));
  });

  Exchange& exchange = servo.exchange();
  Command command;
  ServoSettings settings;
  std::uint64_t events = 0, newest = 0, zero_force_confirmed = 0;
  bool in_order = true;
  for (int round = 0; round < 500; ++round) {
    command.force_n = {0.001 * round, 0, 0};
    ++command.number;
    command.heartbeat_s = devices::ServoThread::now_s();
    exchange.commands.write(command);
    settings.chain.damping_n_s_per_m = 0.01 * (round % 10);
    exchange.settings.write(settings);
    if (round % 50 == 0)
      exchange.motors.disable();
    else if (round % 50 == 25)
      exchange.motors.enable();
    else if (round % 50 == 30)
      exchange.motors.emergency_stop();
    if (round % 10 == 0)
      ++exchange.statistics_resets;
    zero_force_confirmed += exchange.motors.zero_force_confirmed();
    exchange.tracing = round % 2 == 0;
    scene.publish(scene_of(round));
    network.publish(network_of(round));
    network.queue_action(NetworkModel::Pluck{3, {0, 0, 0.1}, 1e-3});
    EffectSettings felt;
    felt.inertia = {0.01 * (1 + round % 9)};
    felt.relief = {1e-4, 1e-3, {1, 0, 0}};
    effects.set(felt);
    link.set_workspace({{-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05 + 1e-6 * round}});
    exchange.reports.read();
    const std::uint64_t tick = exchange.reports.latest().tick.index;
    in_order = in_order && tick >= newest;
    newest = tick;
    exchange.statistics.read();
    Report report;
    while (exchange.trace.pop(report))
      in_order = in_order && is_finite(report.force_n);
    ServoEvent event;
    while (exchange.events.pop(event))
      ++events;
    SceneEvent contact;
    while (scene.events().pop(contact))
      ++events;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ending = true;
  audio.join();
  CHECK(runner.stop());
  CHECK(in_order);
  CHECK(newest > 10);
  CHECK(events > 0);
  CHECK(zero_force_confirmed > 0);
}
