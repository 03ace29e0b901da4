// What a servo tick of a mass-spring network costs, mean and worst, as a share of 1 ms.
//
//   bench_network_speed [RUNS]
//
// One row a network: its masses, links and steps in a tick, nanoseconds for one link in one step,
// then microseconds of CPU time a tick while a hand circles in it and grabs. Each of the 2000 ticks
// is run RUNS times and its least time counts for `mean` and `worst`, which so leave out what other
// programs do to the caches; `99.9 %` and `longest` are of all runs.
#include "core/haptic/network/network_model.hpp"
#include "core/haptic/network/shapes.hpp"
#include "core/haptic/network/stability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>

namespace {

using namespace tactus::haptic;

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Network of(NetworkPart part) {
  Network network;
  network.masses = std::move(part.masses);
  network.links = std::move(part.links);
  std::uint64_t key = 0;
  for (NetworkMass& mass : network.masses)
    mass.key = ++key;
  network.drag_per_s = 1;
  network.pickups[0].mass = network.masses.size() / 2;
  return network;
}

/// A cloth of 14 x 14 masses whose links have a rest length, and the diagonals of its squares.
Network cloth(std::size_t links) {
  NetworkMembrane membrane{14, 14, {-0.05, -0.05, 0}, {0.05, 0.05, 0}, 0.02, 20, 1e-3};
  NetworkPart part = make_membrane(membrane);
  for (NetworkLink& link : part.links) {
    link.rest_length_m = 4e-3;
    link.damping_n_s_per_m = 2e-3;
  }
  for (int reach = 1; reach < 6; ++reach)
    for (int j = 1; j + reach <= 14; ++j)
      for (int i = 1; i + reach <= 14; ++i)
        for (const bool rising : {false, true}) {
          if (part.links.size() >= links)
            return of(part);
          NetworkLink link = part.links[0];
          const int from = rising ? i + reach : i, to = rising ? i : i + reach;
          link.a = static_cast<std::uint16_t>(membrane_index(14, 14, from, j));
          link.b = static_cast<std::uint16_t>(membrane_index(14, 14, to, j + reach));
          link.rest_length_m = 5e-3 * reach;
          part.links.push_back(link);
        }
  return of(part);
}

void measure(const char* name, const Network& network, int runs) {
  const int steps = steps_per_tick(network, max_stable_step(network).step_s, 1e-3).steps;
  std::vector<double> least(2000, 1e9), all;
  double felt = 0;
  for (int run = 0; run < runs; ++run) {
    auto model = std::make_unique<NetworkModel>();
    model->publish(std::make_unique<const Network>(network));
    for (std::size_t n = 0; n < least.size(); ++n) {
      const double t = static_cast<double>(n) * 1e-3;
      State state;
      state.position = {0.03 * std::cos(3 * t), 0.03 * std::sin(3 * t), 0.004 * std::sin(40 * t)};
      if (n == 500)
        model->queue_action(NetworkModel::GrabNearest{});
      const double begin = cpu_s();
      felt += norm(model->force({n, t, 1e-3}, state));
      const double took_us = 1e6 * (cpu_s() - begin);
      least[n] = std::min(least[n], took_us);
      all.push_back(took_us);
    }
  }
  double mean = 0;
  for (const double tick : least)
    mean += tick / static_cast<double>(least.size());
  std::sort(all.begin(), all.end());
  const double worst = *std::max_element(least.begin(), least.end());
  const auto links = static_cast<double>(network.links.size());
  std::printf("%-28s %4zu %5zu %5d %8.2f %8.1f %8.1f %8.1f %8.1f\n", name, network.masses.size(),
              network.links.size(), steps, steps > 0 ? 1e3 * mean / (links * steps) : 0.0, mean,
              worst, all[all.size() * 999 / 1000], felt > 0 ? all.back() : 0.0);
}

} // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 7;
  std::printf("%-28s %4s %5s %5s %8s %8s %8s %8s %8s\n", "network", "mass", "link", "steps",
              "ns/link", "mean", "worst", "99.9 %", "longest");
  measure("string of 40", of(make_string({})), runs);
  NetworkString long_string;
  long_string.count = 200;
  long_string.mass_kg = 5e-3;
  measure("string of 200", of(make_string(long_string)), runs);
  long_string.stiffness_n_per_m = 4 * long_string.tension_n * 201 / 0.1;
  measure("string of 200, rest length", of(make_string(long_string)), runs);
  measure("membrane of 12 x 12", of(make_membrane({})), runs);
  NetworkMembrane large;
  large.nx = large.ny = 14;
  measure("membrane of 14 x 14", of(make_membrane(large)), runs);
  Network all = of(make_membrane(large));
  all.touch.radius_m = 0.2;
  measure("the same, all masses touched", all, runs);
  measure("cloth, 420 links", cloth(420), runs);
  measure("cloth, 700 links", cloth(700), runs);
  measure("cloth, 1000 links", cloth(1000), runs);
}
