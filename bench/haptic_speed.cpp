// What a servo tick costs: the simulated hand alone, and in scenes that it touches all the time.
//
//   bench_haptic_speed --benchmark_repetitions=9
//
// prints nanoseconds a tick and its share of 1 ms. A hand slides along a
// circle, half of it inside the bodies, with friction. bench_haptic_scene has the worst ticks.
#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/servo.hpp"
#include "tests/core/haptic/scene/meshes.hpp"

#include <benchmark/benchmark.h>

#include <memory>

namespace {

using namespace tactus::haptic;

/// Bodies along a circle of 30 mm, spheres, boxes and disks in turn, and a floor.
std::unique_ptr<Scene> ring_of(int count) {
  auto scene = std::make_unique<Scene>();
  for (int i = 0; i < count; ++i) {
    Body body;
    body.key = static_cast<std::uint64_t>(i + 1);
    const double angle = 6.283185307179586 * i / count;
    body.pose.position = {0.03 * std::cos(angle), 0.03 * std::sin(angle), -0.004};
    body.shape = i == 0       ? Shape(Plane{})
                 : i % 3 == 0 ? Shape(Sphere{0.006})
                 : i % 3 == 1 ? Shape(Box{{0.006, 0.006, 0.005}})
                              : Shape(Disk{0.006, 0.005});
    body.material.friction = 0.3;
    scene->bodies.push_back(body);
  }
  return scene;
}

std::unique_ptr<Scene> ball_of(std::uint32_t around) {
  auto scene = std::make_unique<Scene>();
  Body body;
  body.key = 1;
  body.shape = test::mesh_sphere(0.031, around, around);
  body.material.friction = 0.3;
  scene->bodies.push_back(body);
  return scene;
}

using Maker = std::unique_ptr<Scene> (*)();

void ticks(benchmark::State& state, Maker make) {
  SimulatedDevice device;
  SimulatedDevice::Settings settings;
  settings.hand.hold = HandSettings::Hold::kRigid;
  device.set(settings);
  device.set_path(CirclePath{{0, 0, 0}, 0.03, 1});
  SceneModel model;
  if (make)
    model.publish(make());
  Servo servo;
  servo.attach(device, &model);
  std::uint64_t n = 0;
  double felt = 0;
  for (auto _ : state) {
    servo.step({n, static_cast<double>(n) * 1e-3, 1e-3});
    felt += norm(servo.chain().written);
    ++n;
    SceneEvent event;
    while (model.events().pop(event)) {
    }
  }
  benchmark::DoNotOptimize(felt);
  using Counter = benchmark::Counter;
  state.counters["share_of_1ms"] =
      Counter(1e-3 * static_cast<double>(state.iterations()), Counter::kIsRate | Counter::kInvert);
}

} // namespace

BENCHMARK_CAPTURE(ticks, hand_alone, Maker{});
BENCHMARK_CAPTURE(
    ticks, shapes_16, +[] { return ring_of(16); });
BENCHMARK_CAPTURE(
    ticks, shapes_64, +[] { return ring_of(64); });
BENCHMARK_CAPTURE(
    ticks, triangles_50000, +[] { return ball_of(159); });
BENCHMARK_MAIN();
