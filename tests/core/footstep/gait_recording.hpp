#pragma once

#include "core/footstep/gait.hpp"
#include "core/footstep/ground_reaction.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <vector>

/// Plays a gait and keeps what it does.
namespace tactus::footstep {

struct Event {
  double t;
  std::size_t foot;
  Phase phase;
  double speed;
};

/// What a gait does, sample by sample.
struct Recording {
  double rate = 8000;
  std::vector<std::array<SoleState, 2>> samples;
  std::vector<Event> events;

  [[nodiscard]] double total(std::size_t n) const { return force(n, 0) + force(n, 1); }
  [[nodiscard]] double force(std::size_t n, std::size_t foot) const {
    return samples[n][foot].heel_n + samples[n][foot].ball_n;
  }
  [[nodiscard]] double time(std::size_t n) const { return static_cast<double>(n) / rate; }
  [[nodiscard]] std::size_t at(double t) const {
    return std::min(static_cast<std::size_t>(t * rate), samples.size() - 1);
  }
  /// Integral of both feet's force less the weight, over the mass: a change of velocity, m/s.
  [[nodiscard]] double velocity(double from, double to, double weight) const {
    double sum = 0;
    for (std::size_t n = at(from); n < at(to); ++n)
      sum += (total(n) - weight) / rate;
    return sum * kGravity / weight;
  }
  /// Events of one kind, of both feet or of one.
  [[nodiscard]] std::vector<Event> of(Phase phase, double from = 0, int foot = -1) const {
    std::vector<Event> found;
    std::copy_if(events.begin(), events.end(), std::back_inserter(found), [&](const Event& e) {
      return e.phase == phase && e.t >= from &&
             (foot < 0 || e.foot == static_cast<std::size_t>(foot));
    });
    return found;
  }
};

/// What a gait is told when.
struct Act {
  double t;
  std::function<void(Gait&)> act;
};
inline const Act kWalk{0, [](Gait&gait) { gait.walk(true); }},
    kHalt{0, [](Gait&gait) { gait.walk(false); }};

inline Recording play(const Walker& walker, double seconds, const std::vector<Act>& acts,
                      double rate = 8000, double variation = 0, bool smooth = true) {
  Gait gait;
  gait.prepare(rate);
  gait.set(walker, variation);
  Recording made;
  made.rate = rate;
  std::array<SoleState, 2> feet{};
  std::array<std::array<double, 2>, 2> before{};
  double worst = 0, largest = 1, min_force = 0;
  for (int n = 0; n < seconds * rate; ++n) {
    for (const Act& one : acts)
      if (n == std::ceil(one.t * rate - 1e-6))
        one.act(gait);
    gait.next(feet);
    made.samples.push_back(feet);
    for (std::size_t i = 0; i < 2; ++i) {
      const SoleState& sole = feet[i];
      min_force = std::min({min_force, sole.heel_n, sole.ball_n});
      worst = std::max(worst, std::abs(sole.heel_slope - (sole.heel_n - before[i][0]) * rate));
      worst = std::max(worst, std::abs(sole.ball_slope - (sole.ball_n - before[i][1]) * rate));
      largest = std::max({largest, std::abs(sole.heel_slope), std::abs(sole.ball_slope)});
      before[i] = {sole.heel_n, sole.ball_n};
      const double t = n / rate;
      if (sole.heel_landing > 0)
        made.events.push_back({t, i, Phase::kHeelDown, sole.heel_landing});
      if (sole.ball_landing > 0)
        made.events.push_back({t, i, Phase::kBallDown, sole.ball_landing});
      if (sole.heel_up)
        made.events.push_back({t, i, Phase::kHeelUp, 0});
      if (sole.toe_off)
        made.events.push_back({t, i, Phase::kToeOff, 0});
    }
  }
  CHECK(min_force == 0);
  if (smooth)                      // no landing has ended another
    CHECK(worst < 1e-6 * largest); // slopes are the forces' differences, also where a foot lends
  return made;
}

} // namespace tactus::footstep
