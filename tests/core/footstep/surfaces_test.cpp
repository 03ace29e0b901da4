#include "bench/walking_foot.hpp"
#include "files/recipe.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

// What the fifteen grounds in data/surfaces must be, however their numbers are fitted: what sounds
// is what the recipe says happens, no step is lost, shoe and weight do what they do, nothing clips.

using namespace tactus::footstep;
using tactus::bench::Walk;
using tactus::files::read_recipe;

namespace {

constexpr double kRate = 44100, kFullScale = 2, kKnee = 0.7; // Pa; of full scale

const std::map<std::string, Recipe>& grounds() {
  static const std::map<std::string, Recipe> found = [] {
    std::map<std::string, Recipe> read;
    for (const auto& file : std::filesystem::directory_iterator(TACTUS_SURFACES)) {
      std::ifstream stream(file.path());
      const std::string text{std::istreambuf_iterator<char>(stream), {}};
      REQUIRE(read_recipe(text, read[file.path().stem().string()]) == "");
    }
    REQUIRE(read.size() == 15);
    return read;
  }();
  return found;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What a sole does in so many steps of a walk: the same on all grounds.
struct Soles {
  Walk how;
  std::uint64_t seed = 5;
  std::vector<SoleState> states;
};

Soles soles_of(const Walk& how, int steps = kSanitized ? 3 : 10, std::uint64_t seed = 5) {
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

double energy(const std::vector<Sound>& steps) {
  double sum = 0;
  for (const Sound& step : steps)
    sum += energy(step);
  return sum;
}

double decibels(double ratio) { return 10 * std::log10(std::max(ratio, 1e-20)); }

/// In place, size a power of two (Cooley & Tukey).
void transform(std::vector<std::complex<double>>& x) {
  const std::size_t size = x.size();
  for (std::size_t i = 1, j = 0; i < size; ++i) { // bits of the index in reverse
    std::size_t bit = size / 2;
    for (; j & bit; bit /= 2)
      j ^= bit;
    j ^= bit;
    if (i < j)
      std::swap(x[i], x[j]);
  }
  for (std::size_t half = 1; half < size; half *= 2) {
    const auto turn = std::polar(1.0, -std::numbers::pi / static_cast<double>(half));
    std::complex<double> factor = 1;
    for (std::size_t k = 0; k < half; ++k, factor *= turn)
      for (std::size_t i = k; i < size; i += 2 * half) {
        const auto turned = factor * x[i + half];
        x[i + half] = x[i] - turned;
        x[i] += turned;
      }
  }
}

/// Mean frequency of the power above 60 Hz, Hz; median of the steps.
double centroid(const std::vector<Sound>& steps) {
  std::vector<double> found;
  for (const Sound& step : steps) {
    std::vector<std::complex<double>> spectrum(65536);
    for (std::size_t n = 0; n < std::min(step.size(), spectrum.size()); ++n)
      spectrum[n] = step[n];
    transform(spectrum);
    double sum = 0, moment = 0;
    for (std::size_t k = 90; k < spectrum.size() / 2; ++k) {
      sum += std::norm(spectrum[k]);
      moment += std::norm(spectrum[k]) * static_cast<double>(k) * kRate / 65536;
    }
    found.push_back(moment / sum);
  }
  return median(found);
}

double median_level(const std::vector<Sound>& steps) {
  std::vector<double> levels;
  for (const Sound& step : steps)
    levels.push_back(decibels(energy(step)));
  return median(levels);
}

/// Time in which the middle 90 % of a step's energy come, s; median.
double duration(const std::vector<Sound>& steps) {
  std::vector<double> found;
  for (const Sound& step : steps) {
    const double whole = energy(step);
    double sum = 0;
    int inside = 0;
    for (const double x : step) {
      sum += x * x;
      inside += sum > 0.05 * whole && sum < 0.95 * whole;
    }
    found.push_back(inside / kRate);
  }
  return median(found);
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

bool one_of(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
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
    const double found = energy(walk(played, soles));
    share[alone.kind] += found;
    whole += found;
    played = recipe;
  }
  for (auto& [kind, part] : share)
    part /= whole;
  return share;
}

} // namespace

TEST_CASE("what sounds is what happens: contacts on floors, friction in boards, grains, bubbles" *
          doctest::skip(kSanitized)) {
  // Shares of a few steps scatter: those of each walk are to be there, their mean as large as said.
  constexpr std::uint64_t kSeeds = 4;
  constexpr int kSteps = 4;
  for (const double speed : {0.8, 1.4, 1.8}) {
    std::map<std::string, std::map<std::string, double>> mean, min_share;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const Soles soles = soles_of({speed}, kSteps, seed);
      for (const auto& [name, recipe] : grounds())
        for (const auto& [kind, part] : shares(recipe, soles)) {
          mean[name][kind] += part / kSeeds;
          min_share[name].try_emplace(kind, 1).first->second =
              std::min(part, min_share[name].try_emplace(kind, 1).first->second);
        }
    }
    for (auto& ground : mean) { // clang 14 captures no structured bindings
      const std::string& name = ground.first;
      auto& share = ground.second;
      CAPTURE(name);
      CAPTURE(speed);
      const auto carries = [&](const char* kind, double part) {
        CAPTURE(kind);
        CHECK(share[kind] >= part);
        CHECK(min_share[name][kind] >= part / 4);
      };
      if (one_of(name, {"wood", "concrete", "metal"})) {
        carries("impact", 0.5);
        CHECK(share["rustle"] <= 0.05);
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
      CHECK(share["rustle"] <= 0.1);
    }
  }
}

TEST_CASE("no step of any ground is lost, however slowly one walks") {
  for (const double speed : {0.3, 0.5, 1.4, 2.5}) {
    if (kSanitized && speed != 1.4)
      continue; // the slower, the more samples of the same
    const Soles soles = soles_of({speed});
    for (const auto& ground : grounds()) {
      const auto& name = ground.first;
      const Recipe& recipe = ground.second;
      CAPTURE(name);
      CAPTURE(speed);
      const std::vector<Sound> steps = walk(recipe, soles);
      const double usual = median_level(steps);
      for (const Sound& step : steps)
        CHECK(decibels(energy(step)) > usual - 12);
    }
  }
}

TEST_CASE("nothing within walking reaches the knee of the output, running hardly ever" *
          doctest::skip(kSanitized)) {
  const std::vector<std::uint64_t> seeds{5, 6, 7};
  const auto of_seeds = [&seeds](const Walk& how, int steps) {
    std::vector<Soles> found;
    for (const std::uint64_t seed : seeds)
      found.push_back(soles_of(how, steps, seed));
    return found;
  };
  const auto hard = of_seeds({2.5, 1200, 1}, 10), heavy = of_seeds({2.5, 1200, 0.4}, 10),
             run = of_seeds({3.5, 700, 0.4, Style::kRun}, 15);
  const std::vector<Soles> usual{soles_of({})};
  for (const auto& ground : grounds()) {
    const auto& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const auto peak_amplitude = [&recipe](const std::vector<Soles>& walks) {
      double peak = 0;
      for (const Soles& soles : walks)
        for (const Sound& step : walk(recipe, soles))
          for (const double x : step)
            peak = std::max(peak, std::abs(x) / kFullScale);
      return peak;
    };
    CHECK(peak_amplitude(hard) < kKnee);
    CHECK(peak_amplitude(heavy) < kKnee);
    CHECK(peak_amplitude(run) < kKnee);
    CHECK(peak_amplitude(usual) > 0.005);
  }
}

TEST_CASE("a shoe decides the sound of a hard floor and hardly that of a soft one" *
          doctest::skip(kSanitized)) {
  const Soles in_soft = soles_of({1.4, 700, 0}), in_hard = soles_of({1.4, 700, 1});
  for (const auto& ground : grounds()) {
    const auto& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const std::vector<Sound> soft = walk(recipe, in_soft), hard = walk(recipe, in_hard);
    const double ratio = centroid(hard) / centroid(soft);
    const double louder = median_level(hard) - median_level(soft);
    if (one_of(name, {"wood", "concrete", "metal"})) {
      CHECK(ratio >= 2);
      CHECK(louder > 0);
    } else if (one_of(name, {"carpet", "snow", "sand", "dryleaves", "underbrush", "water"})) {
      CHECK(ratio < 1.5);
      CHECK(ratio > 0.7);
      CHECK(std::abs(louder) < 3);
    }
  }
}

TEST_CASE("a heavier walker is louder, and longer in snow, gravel and leaves" *
          doctest::skip(kSanitized)) {
  const Soles of_light = soles_of({1.4, 300}), of_heavy = soles_of({1.4, 1200});
  for (const auto& ground : grounds()) {
    const auto& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const std::vector<Sound> light = walk(recipe, of_light), heavy = walk(recipe, of_heavy);
    CHECK(median_level(heavy) > median_level(light) + 2);
    if (one_of(name, {"snow", "gravel", "dryleaves"}))
      CHECK(duration(heavy) > 1.15 * duration(light));
  }
}

TEST_CASE("steps grow louder with the walking speed by 3 to 9 dB for twice the speed" *
          doctest::skip(kSanitized)) {
  const Soles fast = soles_of({2.0}), slow = soles_of({0.7});
  const double octaves = std::log2(2.0 / 0.7);
  for (const auto& ground : grounds()) {
    const auto& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const double growth =
        (median_level(walk(recipe, fast)) - median_level(walk(recipe, slow))) / octaves;
    CHECK(growth > (name == "creak" ? 2 : 3)); // boards creak as loudly under a slow foot
    CHECK(growth < 9);
  }
}

TEST_CASE("both actuators are moved by what lands on them, alike on solid ground" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds()) {
    const auto& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    tactus::bench::WalkingFoot foot(recipe, {}, kRate, 5);
    std::vector<double> heel, ball; // highest of each step
    while (heel.size() <= 10) {
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
