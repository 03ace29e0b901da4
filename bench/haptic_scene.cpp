// The worst tick of a scene, in scenes made to be slow and with a handle that leaps.
//
//   bench_haptic_scene                                  some two minutes
//   bench_haptic_scene --benchmark_filter=unlimited     the same without the work limit: slow
//
// prints for each scene in us the median tick, the 99.9th percentile and the longest, and the share
// of the ticks that reached the work limit. A tick has 1000 us at 1 kHz. Times are CPU time of the
// thread. The same 4000 ticks run five times, and of each tick the shortest time counts: it does
// the same work each time, and what an interrupt or a neighbour adds is not its own.
//
// leap: to a random position in a cube of 60 mm at every tick, which is 60 m/s. stroke: at up to 2
// m/s, a fast hand. glide: leaps, and all bodies move all the time.
#include "core/dsp/random.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "tests/core/haptic/scene/meshes.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <vector>

namespace {

using namespace tactus::haptic;
using tactus::Random;
using tactus::Vec3;

constexpr std::size_t kTicks = 4000;
constexpr int kRuns = 5;
constexpr double kCube_m = 0.06;

Vec3 random_point(Random& random, double side_m) {
  const auto one = [&] { return side_m * (random.uniform() - 0.5); };
  const double x = one(), y = one();
  return {x, y, one()};
}

Rotation random_rotation(Random& random) {
  const auto one = [&] { return random.uniform() - 0.5; };
  const double w = one(), x = one(), y = one();
  return Rotation::of(w, x, y, one());
}

Body body(std::uint64_t key, Shape shape, Pose pose = {}) {
  return {key, std::move(shape), pose, {500, 1, 0.5}, 0};
}

/// 64 thin disks, one above the other, a little turned.
Scene disks() {
  Scene scene;
  Random random(1);
  for (int i = 0; i < 64; ++i)
    scene.bodies.push_back(
        body(static_cast<std::uint64_t>(i + 1), Disk{0.05, 1e-4},
             {{0, 0, (i - 31.5) * 1e-3},
              Rotation::of(1, 0.01 * random.uniform(), 0.01 * random.uniform(), 0)}));
  return scene;
}

/// 64 spheres, or boxes, that overlap each other.
template <class Solid> Scene heap(const Solid& solid) {
  Scene scene;
  Random random(2);
  for (int i = 0; i < 64; ++i) {
    const Vec3 at = random_point(random, kCube_m);
    scene.bodies.push_back(
        body(static_cast<std::uint64_t>(i + 1), solid, {at, random_rotation(random)}));
  }
  return scene;
}

/// Eight meshes through one another.
Scene meshes(const MeshSurface& mesh) {
  Scene scene;
  Random random(3);
  for (int i = 0; i < 8; ++i) {
    const Vec3 at = random_point(random, 0.01);
    scene.bodies.push_back(
        body(static_cast<std::uint64_t>(i + 1), mesh, {at, random_rotation(random)}));
  }
  return scene;
}

/// A round plate of slivers that all meet in its middle.
MeshSurface fan(std::uint32_t count) {
  std::vector<Vec3> corners{{}};
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count;
    corners.push_back({0.03 * std::cos(angle), 0.03 * std::sin(angle), 0});
    triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
  }
  return {std::make_shared<const TriangleMesh>(corners, triangles)};
}

/// Large triangles anyhow, so that every box of the tree overlaps many others.
MeshSurface soup(std::uint32_t count) {
  Random random(4);
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int corner = 0; corner < 3; ++corner)
      corners.push_back(random_point(random, kCube_m));
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return {std::make_shared<const TriangleMesh>(corners, triangles)};
}

Scene with_tool(Scene scene, double radius_m) {
  scene.tool_radius_m = radius_m;
  return scene;
}

enum class Motion { kJump, kStroke, kGlide };

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Times {
  std::vector<double> tick_s;
  std::size_t limited = 0;
};

/// The CPU time of every tick of one run, always of the same motion.
Times run(Scene scene, Motion motion, std::int64_t work_per_tick) {
  const auto model = std::make_unique<SceneModel>(work_per_tick);
  model->publish(std::make_unique<const Scene>(scene));
  Random random(5);
  Times times;
  Vec3 at{0, 0.2, 0}, aim = at;
  for (std::size_t n = 0; n < kTicks; ++n) {
    if (motion == Motion::kGlide && n % 50 == 0) {
      for (Body& one : scene.bodies) {
        const Vec3 to = random_point(random, kCube_m);
        one.pose = {to, random_rotation(random)};
        one.glide_s = 0.05;
      }
      model->publish(std::make_unique<const Scene>(scene));
    }
    if (motion == Motion::kStroke) {
      if (n % 60 == 0)
        aim = random_point(random, kCube_m);
      at += limited(aim - at, 2e-3);
    } else {
      at = random_point(random, kCube_m);
    }
    State handle;
    handle.position = at;
    const double begin_s = thread_cpu_s();
    benchmark::DoNotOptimize(model->force({n, static_cast<double>(n) * 1e-3, 1e-3}, handle));
    times.tick_s.push_back(thread_cpu_s() - begin_s);
    times.limited += !model->complete();
    SceneEvent event;
    while (model->events().pop(event)) {
    }
  }
  return times;
}

void worst(benchmark::State& state, Scene (*make)(), Motion motion, std::int64_t work_per_tick) {
  const Scene scene = make();
  Times best;
  for (auto _ : state)
    for (int i = 0; i < kRuns; ++i) {
      const Times times = run(scene, motion, work_per_tick);
      if (i == 0)
        best = times;
      for (std::size_t n = 0; n < kTicks; ++n)
        best.tick_s[n] = std::min(best.tick_s[n], times.tick_s[n]);
    }
  std::sort(best.tick_s.begin(), best.tick_s.end());
  const auto quantile = [&](double q) {
    return 1e6 * best.tick_s[static_cast<std::size_t>(q * static_cast<double>(kTicks - 1))];
  };
  state.counters["median_us"] = quantile(0.5);
  state.counters["p99.9_us"] = quantile(0.999);
  state.counters["worst_us"] = quantile(1);
  state.counters["limited"] = static_cast<double>(best.limited) / static_cast<double>(kTicks);
}

const MeshSurface& ball_50000() {
  static const MeshSurface mesh = test::mesh_sphere(0.025, 159, 158);
  return mesh;
}

Scene ball() {
  Scene scene;
  scene.bodies.push_back(body(1, ball_50000()));
  return scene;
}

struct Row {
  const char* name;
  Scene (*make)();
};
constexpr Row kRows[] = {
    {"disks_64", [] { return disks(); }},
    {"spheres_64", [] { return heap(Sphere{0.012}); }},
    {"boxes_64",
     [] {
       return heap(Box{{0.02, 0.004, 0.01}});
     }},
    {"ball_50000", [] { return ball(); }},
    {"balls_8x50000", [] { return meshes(ball_50000()); }},
    {"fans_8x50000", [] { return meshes(fan(50000)); }},
    {"soups_8x500", [] { return meshes(soup(500)); }},
    {"disks_64_tool", [] { return with_tool(disks(), 0.004); }},
    {"boxes_64_tool",
     [] {
       return with_tool(heap(Box{{0.02, 0.004, 0.01}}), 0.004);
     }},
    {"ball_50000_tool", [] { return with_tool(ball(), 0.004); }},
    {"balls_8x50000_tool", [] { return with_tool(meshes(ball_50000()), 0.004); }},
    {"fans_8x50000_tool", [] { return with_tool(meshes(fan(50000)), 0.004); }},
};
constexpr std::pair<const char*, Motion> kMotions[] = {
    {"leap", Motion::kJump}, {"stroke", Motion::kStroke}, {"glide", Motion::kGlide}};

} // namespace

int main(int argc, char** argv) {
  bool unlimited = false; // only when it is asked for
  for (int i = 1; i < argc; ++i)
    unlimited = unlimited || std::string(argv[i]).find("unlimited") != std::string::npos;
  for (const Row& row : kRows)
    for (const auto& [motion_name, motion] : kMotions)
      benchmark::RegisterBenchmark(
          (std::string(row.name) + "/" + motion_name + (unlimited ? "/unlimited" : "")).c_str(),
          worst, row.make, motion, unlimited ? WorkLimit::kUnlimited : SceneModel::kWorkPerTick)
          ->Iterations(1);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
