#include "bench/walking_foot.hpp"
#include "files/recipe.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

// What the fifteen grounds in data/surfaces must be, however their numbers are fitted: what sounds
// is what the recipe says happens, no step is lost, shoe and weight do what they do, nothing clips.

using namespace tactus::footstep;
using tactus::bench::Walk;

namespace {

constexpr double kRate = 44100, kFullScale = 2, kKnee = 0.7; // Pa; of full scale

const std::map<std::string, Recipe>& grounds() {
  static const std::map<std::string, Recipe> found = [] {
    std::map<std::string, Recipe> read;
    for (const auto& file : std::filesystem::directory_iterator(TACTUS_SURFACES)) {
      std::ifstream stream(file.path());
      const std::string text{std::istreambuf_iterator<char>(stream), {}};
      REQUIRE(tactus::files::read_recipe(text, read[file.path().stem().string()]) == "");
    }
    REQUIRE(read.size() == 15);
    return read;
  }();
  return found;
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const auto& ground : grounds())
    names.push_back(ground.first);
  return names;
}

bool one_of(const std::string& name, std::initializer_list<const char*> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What a sole does in so many steps of a walk: the same on all grounds.
struct Soles {
  Walk how;
  std::uint64_t seed;
  std::vector<SoleState> states;
};

Soles soles_of(const Walk& how, int steps, std::uint64_t seed = 5) {
  Gait gait;
  gait.prepare(kRate);
  gait.seed(seed);
  gait.set({how.speed_m_per_s, how.weight_n, how.shoe, how.style}, 0.04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> feet{};
  Soles soles{how, seed, {}};
  for (;;) {
    gait.next(feet);
    if (feet[0].heel_landing > 0 && steps-- == 0)
      return soles;
    soles.states.push_back(feet[0]);
  }
}

using Sound = std::vector<double>;

/// The sound of each step of one foot in the open.
std::vector<Sound> walk(const Recipe& recipe, const Soles& soles) {
  const auto ground = std::make_unique<Ground>();
  ground->prepare(kRate);
  ground->seed(4 * soles.seed); // as Foot seeds its first ground
  ground->set(recipe, soles.how.shoe);
  ground->set_weight(soles.how.weight_n);
  std::vector<Sound> steps;
  for (const SoleState& sole : soles.states) {
    if (sole.heel_landing > 0)
      steps.emplace_back();
    steps.back().push_back(ground->next(sole).pressure_pa);
  }
  return steps;
}

double energy(const Sound& sound) {
  double sum = 0;
  for (const double x : sound)
    sum += x * x;
  return sum;
}

/// Medians of the steps, and the highest pressure.
struct Heard {
  double level_db, frequency_hz, duration_s, peak_pa = 0;
};

Heard heard(const Recipe& recipe, const Soles& soles) {
  std::vector<double> levels, frequencies, durations;
  Heard found{};
  for (const Sound& step : walk(recipe, soles)) {
    const double whole = energy(step);
    double sum = 0, differences = 0, last = 0;
    int inside = 0; // the time in which the middle 90 % of the energy come
    for (const double x : step) {
      sum += x * x;
      inside += sum > 0.05 * whole && sum < 0.95 * whole;
      differences += (x - last) * (x - last);
      last = x;
      found.peak_pa = std::max(found.peak_pa, std::abs(x));
    }
    levels.push_back(10 * std::log10(std::max(whole, 1e-20)));
    // Of the mean square of f: 2 sin(pi f/rate) is what a difference leaves of a frequency.
    frequencies.push_back(std::asin(std::sqrt(differences / whole) / 2) / std::numbers::pi * kRate);
    durations.push_back(inside / kRate);
  }
  found.level_db = median(levels);
  for (const double level : levels) // no step is lost
    CHECK(level > found.level_db - 12);
  found.frequency_hz = median(frequencies);
  found.duration_s = median(durations);
  return found;
}

/// What shoe, weight and speed do.
void check_laws(const std::vector<std::string>& names, int steps) {
  const Soles in_soft = soles_of({1.4, 700, 0}, steps), in_hard = soles_of({1.4, 700, 1}, steps),
              of_light = soles_of({1.4, 300}, steps), of_heavy = soles_of({1.4, 1200}, steps),
              at_0_7 = soles_of({0.7}, steps), at_2 = soles_of({2.0}, steps);
  for (const std::string& name : names) {
    const Recipe& recipe = grounds().at(name);
    CAPTURE(name);
    const Heard soft = heard(recipe, in_soft), hard = heard(recipe, in_hard),
                light = heard(recipe, of_light), heavy = heard(recipe, of_heavy),
                slow = heard(recipe, at_0_7), fast = heard(recipe, at_2);
    const double ratio = hard.frequency_hz / soft.frequency_hz,
                 louder = hard.level_db - soft.level_db;
    if (one_of(name, {"wood", "concrete", "metal"})) {
      CHECK(ratio >= 2);
      CHECK(louder > 0);
    } else if (one_of(name, {"carpet", "snow", "sand", "dryleaves", "underbrush", "water"})) {
      CHECK(ratio < 1.5);
      CHECK(ratio > 0.7);
      CHECK(std::abs(louder) < 3);
    }
    CHECK(heavy.level_db > light.level_db + 2);
    if (one_of(name, {"snow", "gravel", "dryleaves"}))
      CHECK(heavy.duration_s > 1.15 * light.duration_s);
    // 3 to 9 dB for twice the speed; boards creak as loudly under a slow foot.
    const double growth = (fast.level_db - slow.level_db) / std::log2(2.0 / 0.7);
    CHECK(growth > (name == "creak" ? 2 : 3));
    CHECK(growth < 9);
    CHECK(soft.peak_pa > 0.005 * kFullScale);
    CHECK(heavy.peak_pa < kKnee * kFullScale);
  }
}

/// A section by its level: every random draw stays.
struct Section {
  std::string kind;
  double* level;
};

std::vector<Section> sections(Recipe& recipe) {
  std::vector<Section> found;
  if (recipe.solid.present)
    found.push_back({"impact", &recipe.solid.level});
  if (recipe.friction.present)
    found.push_back({"friction", &recipe.friction.level});
  for (std::size_t i = 0; i < recipe.clouds; ++i) {
    auto& settings = recipe.cloud[i].settings;
    constexpr std::array<const char*, 3> kKinds{"grains", "bubbles", "rustle"};
    found.push_back({kKinds[static_cast<std::size_t>(settings.kind)], &settings.level});
  }
  return found;
}

/// The parts of the sections in the sum of their energies, each section alone.
std::map<std::string, double> shares(const Recipe& recipe, const Soles& soles) {
  std::map<std::string, double> share;
  double whole = 0;
  Recipe played = recipe;
  for (const Section& alone : sections(played)) {
    const double level = *alone.level;
    for (const Section& other : sections(played))
      *other.level = 0;
    *alone.level = level;
    double found = 0;
    for (const Sound& step : walk(played, soles))
      found += energy(step);
    share[alone.kind] += found;
    whole += found;
    played = recipe;
  }
  for (auto& kind : share)
    kind.second /= whole;
  return share;
}

/// Shares of a few steps scatter: those of each walk are to be there, their mean as large as said.
void check_shares(const std::vector<std::string>& names, double speed, int steps, int seeds,
                  double max_rustle = 0.1) {
  for (const std::string& name : names) {
    std::map<std::string, double> mean, least;
    for (int seed = 1; seed <= seeds; ++seed)
      for (const auto& [kind, part] :
           shares(grounds().at(name), soles_of({speed}, steps, static_cast<std::uint64_t>(seed)))) {
        mean[kind] += part / seeds;
        double& lowest = least.try_emplace(kind, 1).first->second;
        lowest = std::min(lowest, part);
      }
    CAPTURE(name);
    CAPTURE(speed);
    const auto carries = [&](const char* kind, double part) {
      CAPTURE(kind);
      CHECK(mean[kind] >= part);
      CHECK(least[kind] >= part / 4);
    };
    CHECK(mean["rustle"] <= max_rustle);
    if (one_of(name, {"wood", "concrete", "metal"})) {
      carries("impact", 0.5);
      CHECK(mean["rustle"] <= max_rustle / 2);
    } else if (one_of(name, {"dirt", "carpet", "creak"})) {
      carries("impact", 0.25);
    } else if (one_of(name, {"snow", "frozensnow"})) {
      carries("impact", 0.1);
    } else if (one_of(name, {"gravel", "sand", "dryleaves", "underbrush"})) {
      carries("grains", 0.5);
    } else if (one_of(name, {"water", "puddle"})) {
      carries("bubbles", 0.3);
    }
    if (name == "creak")
      carries("friction", 0.15);
  }
}

/// Both actuators are moved by what lands on them, alike on solid ground.
void check_drives(const std::vector<std::string>& names, std::size_t steps) {
  for (const std::string& name : names) {
    CAPTURE(name);
    tactus::bench::WalkingFoot foot(grounds().at(name), {}, kRate, 5);
    std::vector<double> heel, ball; // highest of each step
    while (heel.size() <= steps) {
      const Foot::Out out = foot.next();
      if (foot.heel_lands()) {
        heel.push_back(0);
        ball.push_back(0);
      }
      heel.back() = std::max(heel.back(), std::abs(out.heel_drive));
      ball.back() = std::max(ball.back(), std::abs(out.ball_drive));
    }
    const double under_heel = median(heel), under_ball = median(ball);
    CHECK(under_heel > 0.05);
    CHECK(under_ball > 0.05);
    CHECK(std::abs(20 * std::log10(under_ball / under_heel)) < 6);
  }
}

} // namespace

TEST_CASE("what sounds is what happens: contacts on floors, friction in boards, grains, bubbles") {
  check_shares({"creak", "sand", "water"}, 1.4, 2, 1, 0.15);
}
TEST_CASE("what sounds on all grounds is what happens, at any speed" *
          doctest::test_suite("slow")) {
  for (const double speed : {0.8, 1.4, 1.8})
    check_shares(all_names(), speed, 4, 4);
}

TEST_CASE("steps grow louder with speed, weight and a hard shoe, and none is lost") {
  check_laws({"wood", "snow"}, 2);
}
TEST_CASE("on all grounds shoe, weight and speed do what they do, and no step is lost" *
          doctest::test_suite("slow")) {
  check_laws(all_names(), 10);
  for (const double speed : {0.3, 0.5, 1.4, 2.5}) {
    const Soles soles = soles_of({speed}, 10);
    for (const auto& ground : grounds())
      heard(ground.second, soles);
  }
}

TEST_CASE("nothing within walking reaches the knee of the output, running hardly ever" *
          doctest::test_suite("slow")) {
  for (const std::uint64_t seed : {5U, 6U, 7U})
    for (const Walk& how : {Walk{2.5, 1200, 1}, {2.5, 1200, 0.4}, {3.5, 700, 0.4, Style::kRun}}) {
      const Soles soles = soles_of(how, how.style == Style::kRun ? 15 : 10, seed);
      for (const auto& ground : grounds()) {
        CAPTURE(ground.first);
        CHECK(heard(ground.second, soles).peak_pa < kKnee * kFullScale);
      }
    }
}

TEST_CASE("heel and ball drive their actuators alike") { check_drives({"concrete", "sand"}, 2); }
TEST_CASE("heel and ball drive their actuators alike on all grounds" *
          doctest::test_suite("slow")) {
  check_drives(all_names(), 10);
}

TEST_CASE("all fifteen grounds sound when walked on, stay finite under any input and end in "
          "silence") {
  const double odd[] = {std::numeric_limits<double>::infinity(), 1e300, -1e300, 1e-310, 3};
  constexpr double kSlow = 16000;
  for (const auto& ground : grounds()) {
    CAPTURE(ground.first);
    const auto foot = std::make_unique<Foot>();
    foot->prepare(kSlow);
    foot->set_grounds(1, ground.second, 1, ground.second, 0);
    Gait gait;
    gait.prepare(kSlow);
    gait.step(0);
    std::array<SoleState, Gait::kFeet> feet{};
    double peak_amplitude = 0;
    bool finite = true;
    const auto play = [&](const SoleState& sole) {
      const Foot::Out out = foot->next(sole);
      finite = finite && std::isfinite(out.pressure_pa + out.heel_drive + out.ball_drive);
      return std::abs(out.pressure_pa);
    };
    const auto fall_silent = [&] {
      for (int n = 0, quiet = 0; n < 12 * kSlow && quiet < 0.1 * kSlow; ++n)
        quiet = play({}) < 1e-9 ? quiet + 1 : 0;
      return play({});
    };
    for (int n = 0; n < kSlow / 2; ++n) {
      gait.next(feet);
      peak_amplitude = std::max(peak_amplitude, play(feet[0]));
    }
    CHECK(peak_amplitude > 0.01);
    CHECK(peak_amplitude < 30);
    CHECK(fall_silent() < 1e-9);
    for (int n = 0; n < 700; ++n) {
      SoleState sole;
      sole.heel_n = n % 5 == 0 ? std::nan("") : odd[n % 5];
      sole.ball_n = odd[(n / 3) % 5];
      sole.heel_slope = odd[(n / 5) % 5];
      sole.ball_slope = n % 7 == 0 ? std::nan("") : odd[(n / 11) % 5];
      sole.heel_landing = n % 100 == 0 ? odd[(n / 100) % 5] : 0;
      sole.ball_landing = n % 130 == 0 ? odd[(n / 130) % 5] : 0;
      play(sole);
    }
    CHECK(fall_silent() < 1e-3);
    CHECK(finite);
  }
}
