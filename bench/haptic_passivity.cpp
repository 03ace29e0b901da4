// Does the passivity controller ever make things worse? A sampled wall, with the controller and
// without, over stiffness, rate, encoder, latency, velocity and hand; docs/results/passivity.md
// shows the worst rows.
//
//   bench_haptic_passivity [--quick] [--csv FILE]
//
// prints, for each latency: of the cases that are stable without the controller, and of the others
// over many bounces, how often its force rms is above 1.1 times that without, and the worst; of the
// flights that gain energy without it, how often they still do, and the worst; the largest force
// into the wall or outside it; and the largest change of force over the slew limit.
#include "tests/core/haptic/chain/sampled_wall.hpp"

#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace tactus::haptic::test;
using Scene = WallCase::Scene;
using Velocity = WallCase::Velocity;

constexpr double kSameForce_n = 2e-3; // an rms below this is rest, whatever the ratio; as is less
                                      // than one step of the encoder makes at that stiffness
constexpr double kMaxForceRatio = 1.1, kMaxExitEnergy = 1.05;
// A handle that is thrown off comes back after 0.1 to 1 s, and tremor is random: of such cases the
// last quarter of 2 s holds two or three bounces, and its rms changes by a quarter with their
// number.
constexpr double kManyBounces_s = 20;

const char* name_of(Velocity velocity) {
  constexpr const char* names[] = {"ideal", "estimated", "noisy", "difference"};
  return names[static_cast<int>(velocity)];
}

std::string set_geometry(const WallCase& c) {
  char text[200];
  std::snprintf(text, sizeof text, "%g N/m, %g Hz, encoder %g mm, velocity %s, ",
                c.stiffness_n_per_m, c.rate_hz, c.encoder_m * 1e3, name_of(c.velocity));
  std::string line = text;
  switch (c.scene) {
  case Scene::kFlight:
    std::snprintf(text, sizeof text, "free at %g m/s", c.value);
    break;
  case Scene::kPush:
    std::snprintf(text, sizeof text, "free, pushed by %g N", c.value);
    break;
  case Scene::kSpring:
  case Scene::kPerson:
  case Scene::kStroke:
    std::snprintf(text, sizeof text, "%s %g N/m %g N s/m, %g mm in",
                  c.scene == Scene::kSpring   ? "hand"
                  : c.scene == Scene::kPerson ? "person"
                                              : "hand that strokes",
                  c.hand_n_per_m, c.hand_n_s_per_m, c.value * 1e3);
    break;
  }
  return line + text;
}

struct Hand {
  Scene scene;
  double value, stiffness, damping;
};
constexpr Hand kHands[] = {
    {Scene::kFlight, 0.05, 0, 0},      {Scene::kFlight, 0.2, 0, 0},
    {Scene::kFlight, 0.5, 0, 0},       {Scene::kPush, 1, 0, 0},
    {Scene::kPush, 0.2, 0, 0},         {Scene::kSpring, 0.005, 50, 0.5},
    {Scene::kSpring, 0.005, 200, 0.5}, {Scene::kSpring, 0.005, 200, 2},
    {Scene::kSpring, 0.005, 1000, 2},  {Scene::kSpring, 0.002, 1000, 0.5},
    {Scene::kPerson, 0, 200, 2},       {Scene::kPerson, 0.002, 200, 2},
    {Scene::kStroke, 0.005, 200, 2},
};

struct Tally {
  long cases = 0, worse = 0;
  double worst = 0;
  std::string where = "-";
  void add(double value, double limit, const std::string& row) {
    ++cases;
    worse += value > limit;
    if (value > worst) {
      worst = value;
      where = row;
    }
  }
};

struct Sweep {
  Tally force, loud, exits;
  double max_slew = 0, max_force = 0, max_pull = 0;
};

Sweep sweep(int latency, bool declared, bool quick, std::FILE* csv) {
  const std::vector<double> stiffness =
      quick ? std::vector<double>{50, 300, 1000, 4000}
            : std::vector<double>{50, 100, 200, 300, 500, 1000, 2000, 3000, 4000};
  const std::vector<double> rates =
      quick ? std::vector<double>{500, 1000} : std::vector<double>{500, 1000, 2000, 4000};
  const std::vector<double> encoders =
      quick ? std::vector<double>{0, 3.4e-5} : std::vector<double>{0, 1e-5, 3.4e-5, 1e-4};
  Sweep result;
  for (const double k : stiffness)
    for (const double rate : rates)
      for (const double encoder : encoders)
        for (const Velocity velocity :
             {Velocity::kIdeal, Velocity::kEstimated, Velocity::kNoisy, Velocity::kDifference})
          for (const Hand& hand : kHands) {
            WallCase c;
            c.stiffness_n_per_m = k;
            c.rate_hz = rate;
            c.encoder_m = encoder;
            c.latency_ticks = latency;
            c.declared = declared;
            c.velocity = velocity;
            c.scene = hand.scene;
            c.value = hand.value;
            c.hand_n_per_m = hand.stiffness;
            c.hand_n_s_per_m = hand.damping;
            WallResult off = run_wall(c, false), on = run_wall(c, true);
            const bool is_quiet = off.stable();
            if (!is_quiet && c.scene != Scene::kFlight) {
              off = run_wall(c, false, kManyBounces_s);
              on = run_wall(c, true, kManyBounces_s);
            }
            result.max_slew = std::max(result.max_slew, on.max_slew);
            result.max_force = std::max(result.max_force, on.max_force_n);
            result.max_pull = std::max(result.max_pull, on.max_pull_n);
            if (csv)
              std::fprintf(csv, "%d,%d,\"%s\",%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", latency,
                           declared, set_geometry(c).c_str(), is_quiet, off.force_rms_n,
                           on.force_rms_n, off.motion_m, on.motion_m, off.exit_energy,
                           on.exit_energy);
            if (c.scene == Scene::kFlight) {
              if (off.exit_energy > 1)
                result.exits.add(on.exit_energy, kMaxExitEnergy, set_geometry(c));
            } else {
              (is_quiet ? result.force : result.loud)
                  .add(on.force_rms_n <= std::max(kSameForce_n, k * encoder)
                           ? 0.0
                           : on.force_rms_n / std::max(off.force_rms_n, 1e-9),
                       kMaxForceRatio, set_geometry(c));
            }
          }
  return result;
}

} // namespace

int main(int count, char** words) {
  bool quick = false;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> csv{nullptr, &std::fclose};
  for (int i = 1; i < count; ++i) {
    if (std::strcmp(words[i], "--quick") == 0) {
      quick = true;
    } else if (std::strcmp(words[i], "--csv") == 0 && i + 1 < count) {
      csv.reset(std::fopen(words[++i], "w"));
      if (!csv) {
        std::fprintf(stderr, "bench_haptic_passivity: %s cannot be written\n", words[i]);
        return 1;
      }
    } else {
      std::fprintf(stderr, "usage: bench_haptic_passivity [--quick] [--csv FILE]\n");
      return 2;
    }
  }
  if (csv)
    std::fputs("latency_ticks,declared,case,stable_off,force_rms_off_n,force_rms_on_n,"
               "motion_off_m,motion_on_m,exit_energy_off,exit_energy_on\n",
               csv.get());
  std::printf(
      "| latency, ticks | quiet without it: force rms above 1.1 times | worst | not quiet: above "
      "1.1 times | worst | flights that gain energy without it: above 1.05 | worst | force into "
      "the "
      "wall or outside | largest slew | largest force |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  std::string worst_rows;
  for (const bool declared : {false, true})
    for (int latency = 0; latency < 4; ++latency) {
      const Sweep s = sweep(latency, declared, quick, csv.get());
      const std::string name =
          std::to_string(latency) + (declared ? ", declared" : ", not declared");
      std::printf("| %s | %ld of %ld | %.2f | %ld of %ld | %.2f | %ld of %ld | %.2f | %.2g N | "
                  "%.6f of it | %.6f N |\n",
                  name.c_str(), s.force.worse, s.force.cases, s.force.worst, s.loud.worse,
                  s.loud.cases, s.loud.worst, s.exits.worse, s.exits.cases, s.exits.worst,
                  s.max_pull, s.max_slew, s.max_force);
      std::fflush(stdout);
      worst_rows += name + ": " + s.force.where + "; " + s.loud.where + "; " + s.exits.where + "\n";
    }
  std::printf("\nThe worst rows, of quiet cases, of others and of flights:\n%s",
              worst_rows.c_str());
}
