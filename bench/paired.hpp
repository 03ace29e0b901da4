#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

/// What the speed programs share: players, objects whose block() makes kBlock samples, timed alone
/// and against each other.
namespace tactus::bench {

inline constexpr std::size_t kBlock = 64;

/// Adds a row with the player's nanoseconds a sample. The player must live until the end.
template <class Player> void add(const std::string& name, Player& player) {
  benchmark::RegisterBenchmark(name.c_str(), [&player](benchmark::State& state) {
    for (auto round : state) {
      static_cast<void>(round);
      player.block();
    }
    const double samples = static_cast<double>(state.iterations()) * static_cast<double>(kBlock);
    state.counters["ns_a_sample"] = benchmark::Counter(
        1e-9 * samples, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  });
}

/// Median over many rounds of the ratio of the two players' times, each round one after the other.
inline double paired_ratio(const std::function<void()>& a, const std::function<void()>& b) {
  constexpr int kRounds = 401, kBlocks = 40;
  using Clock = std::chrono::steady_clock;
  const auto time = [](const std::function<void()>& play) {
    const auto start = Clock::now();
    for (int n = 0; n < kBlocks; ++n)
      play();
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  std::vector<double> ratios;
  for (int n = 0; n < kRounds; ++n) {
    const double first = time(a), second = time(b), again = time(a);
    ratios.push_back(0.5 * (first + again) / second);
  }
  std::nth_element(ratios.begin(), ratios.begin() + kRounds / 2, ratios.end());
  return ratios[kRounds / 2];
}

template <class A, class B> void print_ratio(const char* what, A& a, B& b) {
  std::printf("%-58s %.2f\n", what, paired_ratio([&] { a.block(); }, [&] { b.block(); }));
}

} // namespace tactus::bench
