// What a foot costs at 48 kHz: a foot alone runs at 100 times real time where it takes 1 % of a
// core.
#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"
#include "files/recipe.hpp"

#include <benchmark/benchmark.h>

#include <array>
#include <memory>
#include <string_view>
#include <vector>

using namespace tactus::footstep;

namespace {

constexpr double kRate = 48000;

/// 12 modes and grains that come 200 times a second on average.
constexpr std::string_view kTwelveModes = "[solid]\nmodes 12\nfrequency 120\nratio 1.4\nt60 0.2\n"
                                          "[grains]\ncount 220\nheel 0.6\nball 0.4\ndecay 0.1\n"
                                          "length 0.003\n";

/// The same in a room and with a rustle, as grounds in data/surfaces have them.
constexpr std::string_view kRoomRecipe = "[solid]\nmodes 12\nfrequency 120\nratio 1.4\nt60 0.2\n"
                                         "[grains]\ncount 220\nheel 0.6\nball 0.4\ndecay 0.1\n"
                                         "length 0.003\n[rustle]\ndecay 0.1\n"
                                         "[room]\nlevel -12\nt60 0.4\n";

struct Walker48k {
  Walker48k(std::uint64_t seed, std::string_view text) : foot(std::make_unique<Foot>()) {
    Recipe recipe;
    static_cast<void>(tactus::files::read_recipe(text, recipe));
    foot->prepare(kRate);
    foot->seed(seed);
    foot->set_grounds(1, recipe, 1, recipe, 0);
    gait.prepare(kRate);
    gait.seed(seed);
    gait.walk(true);
  }
  double next() noexcept {
    gait.next(feet);
    return foot->next(feet[0]).pressure_pa;
  }
  std::unique_ptr<Foot> foot;
  Gait gait;
  std::array<SoleState, Gait::kFeet> feet{};
};

/// Seconds of sound made in a second.
void count(benchmark::State& state, double samples) {
  state.counters["times_real_time"] =
      benchmark::Counter(samples / kRate, benchmark::Counter::kIsRate);
}

void one_foot(benchmark::State& state) {
  Walker48k walker(1, kTwelveModes);
  for (auto _ : state)
    for (int n = 0; n < 4800; ++n)
      benchmark::DoNotOptimize(walker.next());
  count(state, 4800.0 * static_cast<double>(state.iterations()));
}
BENCHMARK(one_foot);

void one_foot_with_rustle_and_room(benchmark::State& state) {
  Walker48k walker(1, kRoomRecipe);
  for (auto _ : state)
    for (int n = 0; n < 4800; ++n)
      benchmark::DoNotOptimize(walker.next());
  count(state, 4800.0 * static_cast<double>(state.iterations()));
}
BENCHMARK(one_foot_with_rustle_and_room);

void forty_walkers(benchmark::State& state) {
  std::vector<Walker48k> crowd;
  for (std::uint64_t i = 0; i < 40; ++i)
    crowd.emplace_back(i, kTwelveModes);
  for (auto _ : state)
    for (int n = 0; n < 480; ++n)
      for (Walker48k& walker : crowd)
        benchmark::DoNotOptimize(walker.next());
  count(state, 480.0 * static_cast<double>(state.iterations()));
}
BENCHMARK(forty_walkers);

/// As a patch runs them: one object after the other, 64 samples each.
void forty_walkers_in_blocks(benchmark::State& state) {
  constexpr int kBlock = 64;
  std::vector<Walker48k> crowd;
  for (std::uint64_t i = 0; i < 40; ++i)
    crowd.emplace_back(i, kTwelveModes);
  for (auto _ : state)
    for (Walker48k& walker : crowd)
      for (int n = 0; n < kBlock; ++n)
        benchmark::DoNotOptimize(walker.next());
  count(state, kBlock * static_cast<double>(state.iterations()));
}
BENCHMARK(forty_walkers_in_blocks);

void gait_of_two_feet(benchmark::State& state) {
  Gait gait;
  gait.prepare(kRate);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> feet{};
  for (auto _ : state)
    for (int n = 0; n < 4800; ++n) {
      gait.next(feet);
      benchmark::DoNotOptimize(feet);
    }
  count(state, 4800.0 * static_cast<double>(state.iterations()));
}
BENCHMARK(gait_of_two_feet);

void one_foot_in_silence(benchmark::State& state) {
  Walker48k walker(1, kTwelveModes);
  walker.gait.walk(false);
  for (auto _ : state)
    for (int n = 0; n < 4800; ++n)
      benchmark::DoNotOptimize(walker.next());
  count(state, 4800.0 * static_cast<double>(state.iterations()));
}
BENCHMARK(one_foot_in_silence);

} // namespace

BENCHMARK_MAIN();
