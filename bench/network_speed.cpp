// What a servo tick of a mass-spring network costs, mean and worst, as a share of 1 ms.
//
//   bench_network_speed [SECONDS]
//
// One row a network: its masses, links and steps in a tick, nanoseconds for one link in one step,
// and the mean, the 99.9 % quantile and the longest of its ticks while a hand circles in it and
// grabs. CPU time of this thread, so that other programs do not count.
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

void measure(const char* name, const Network& network, double seconds) {
  auto model = std::make_unique<NetworkModel>();
  model->publish(std::make_unique<const Network>(network));
  const int steps = steps_per_tick(network, max_stable_step(network).step_s, 1e-3).steps;
  std::vector<double> ticks;
  double felt = 0, total = 0;
  for (std::uint64_t n = 0; total < seconds || n < 2000; ++n) {
    const double t = static_cast<double>(n) * 1e-3;
    State state;
    state.position = {0.03 * std::cos(3 * t), 0.03 * std::sin(3 * t), 0.004 * std::sin(40 * t)};
    if (n == 500)
      model->act({NetworkModel::Action::Kind::kGrabNearest, 0, {}, 0});
    const double begin = cpu_s();
    felt += norm(model->force({n, t, 1e-3}, state));
    const double took = cpu_s() - begin;
    total += took;
    if (n > 100) // the first fill the caches
      ticks.push_back(took);
  }
  std::sort(ticks.begin(), ticks.end());
  const auto at = [&ticks](double share) {
    return 1e6 * ticks[static_cast<std::size_t>(share * static_cast<double>(ticks.size() - 1))];
  };
  double mean = 0;
  for (const double tick : ticks)
    mean += 1e6 * tick / static_cast<double>(ticks.size());
  const auto links = static_cast<double>(network.links.size());
  std::printf("%-28s %4zu %5zu %5d %8.2f %8.1f %8.1f %8.1f %7.1f %%\n", name,
              network.masses.size(), network.links.size(), steps,
              steps > 0 ? 1e3 * mean / (links * steps) : 0.0, mean, at(0.999), at(1), at(0.999) / 10);
  if (felt < 0)
    std::puts("");
}

} // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 0.5;
  std::printf("%-28s %4s %5s %5s %8s %8s %8s %8s %9s\n", "network", "mass", "link", "steps",
              "ns/link", "mean us", "99.9 %", "longest", "of 1 ms");
  measure("string of 40", of(make_string({})), seconds);
  NetworkString long_string;
  long_string.count = 200;
  long_string.mass_kg = 5e-3;
  measure("string of 200", of(make_string(long_string)), seconds);
  long_string.stiffness_n_per_m = 4 * long_string.tension_n * 201 / 0.1;
  measure("string of 200, rest length", of(make_string(long_string)), seconds);
  measure("membrane of 12 x 12", of(make_membrane({})), seconds);
  NetworkMembrane large;
  large.nx = large.ny = 14;
  measure("membrane of 14 x 14", of(make_membrane(large)), seconds);
  measure("cloth, 420 links", cloth(420), seconds);
  measure("cloth, 700 links", cloth(700), seconds);
  measure("cloth, 1000 links", cloth(1000), seconds);
}
