#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"
#include "tests/approx.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

// What the fifteen grounds in data/surfaces must be, however their numbers are fitted: what sounds
// is what the recipe says happens, no step is lost, shoe and weight do what they do, nothing clips.

using namespace tactus::footstep;
namespace test = tactus::test;

namespace {

constexpr double kRate = 44100, kFullScale = 2, kKnee = 0.7; // Pa; of full scale

std::map<std::string, Recipe> grounds() {
  const auto folder = std::filesystem::path(__FILE__).parent_path() / "../../../data/surfaces";
  std::map<std::string, Recipe> found;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(file.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    REQUIRE(read_recipe(text, found[file.path().stem().string()]) == "");
  }
  REQUIRE(found.size() == 15);
  return found;
}

struct Walk {
  double speed = 1.4, weight = 700, shoe = 0.4;
  bool run = false;
  int steps = kSanitized ? 3 : 10;
};

/// The sound of each step of one foot in the open, and the peaks of its drives.
struct Walked {
  std::vector<std::vector<double>> steps;
  double heel_drive = 0, ball_drive = 0; ///< medians
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Walked walk(const Recipe& recipe, const Walk& how) {
  const auto foot = std::make_unique<Foot>();
  Gait gait;
  foot->prepare(kRate);
  foot->seed(5);
  foot->set_room(0);
  foot->set_shoe(how.shoe);
  foot->set_weight(how.weight);
  foot->stand_on(1, recipe, 1, recipe, 0);
  foot->drive().set({1, 3, 1e6, 0, 0});
  gait.prepare(kRate);
  gait.seed(5);
  gait.set({how.speed, how.weight, how.shoe, how.run ? Style::kRun : Style::kWalk}, 0.04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> soles{};
  Walked walked;
  std::vector<double> heel, ball;
  while (static_cast<int>(walked.steps.size()) <= how.steps) {
    gait.next(soles);
    if (soles[0].heel_landing > 0) {
      walked.steps.emplace_back();
      heel.push_back(0);
      ball.push_back(0);
    }
    const Foot::Out out = foot->next(soles[0]);
    walked.steps.back().push_back(out.heard);
    heel.back() = std::max(heel.back(), std::abs(out.heel_drive));
    ball.back() = std::max(ball.back(), std::abs(out.ball_drive));
  }
  walked.steps.pop_back();
  walked.heel_drive = median(heel);
  walked.ball_drive = median(ball);
  return walked;
}

double energy(const std::vector<double>& sound) {
  double sum = 0;
  for (const double x : sound)
    sum += x * x;
  return sum;
}

double energy(const Walked& walked) {
  double sum = 0;
  for (const auto& step : walked.steps)
    sum += energy(step);
  return sum;
}

double decibels(double ratio) { return 10 * std::log10(std::max(ratio, 1e-20)); }

/// In place, size a power of two (Cooley & Tukey).
void transform(std::vector<std::complex<double>>& x) {
  if (x.size() < 2)
    return;
  std::vector<std::complex<double>> even, odd;
  for (std::size_t i = 0; i < x.size(); ++i)
    (i % 2 ? odd : even).push_back(x[i]);
  transform(even);
  transform(odd);
  for (std::size_t i = 0; i < x.size() / 2; ++i) {
    const auto turned = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i) /
                                            static_cast<double>(x.size())) *
                        odd[i];
    x[i] = even[i] + turned;
    x[i + x.size() / 2] = even[i] - turned;
  }
}

/// Mean frequency of the power above 60 Hz, Hz; median of the steps.
double centroid(const Walked& walked) {
  std::vector<double> found;
  for (const auto& step : walked.steps) {
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

double median_level(const Walked& walked) {
  std::vector<double> levels;
  for (const auto& step : walked.steps)
    levels.push_back(decibels(energy(step)));
  return median(levels);
}

/// Time in which the middle 90 % of a step's energy come, s; median.
double duration(const Walked& walked) {
  std::vector<double> found;
  for (const auto& step : walked.steps) {
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

} // namespace

TEST_CASE("what sounds is what happens: contacts on floors, friction in boards, grains, bubbles" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds())
    for (const double speed : std::vector{0.8, 1.4, 1.8}) {
      const std::string& name = ground.first;
      const Recipe& recipe = ground.second;
      CAPTURE(name);
      CAPTURE(speed);
      Recipe played = recipe;
      std::map<std::string, double> share;
      double whole = 0;
      for (const Section& alone : sections(played)) {
        const double level = *alone.level;
        for (const Section& other : sections(played))
          *other.level = 0;
        *alone.level = level;
        const double found = energy(walk(played, {speed}));
        share[alone.kind] += found;
        whole += found;
        played = recipe;
      }
      for (auto& [kind, part] : share)
        part /= whole;
      if (one_of(name, {"wood", "concrete", "metal"})) {
        CHECK(share["impact"] >= 0.5);
        CHECK(share["rustle"] <= 0.05);
      } else if (one_of(name, {"dirt", "carpet", "creak"})) {
        CHECK(share["impact"] >= 0.25);
      } else if (one_of(name, {"snow", "frozensnow"})) {
        CHECK(share["impact"] >= 0.1);
      } else if (one_of(name, {"gravel", "sand", "dryleaves", "underbrush"})) {
        CHECK(share["grains"] >= 0.5);
      } else if (one_of(name, {"water", "puddle"})) {
        CHECK(share["bubbles"] >= 0.3);
      }
      if (name == "creak")
        CHECK(share["friction"] >= 0.15);
      CHECK(share["rustle"] <= 0.1);
    }
}

TEST_CASE("no step of any ground is lost, however slowly one walks") {
  for (const auto& ground : grounds())
    for (const double speed : {0.3, 0.5, 1.4, 2.5}) {
      const std::string& name = ground.first;
      const Recipe& recipe = ground.second;
      CAPTURE(name);
      CAPTURE(speed);
      const Walked walked = walk(recipe, {speed});
      const double usual = median_level(walked);
      for (const auto& step : walked.steps)
        CHECK(decibels(energy(step)) > usual - 12);
    }
}

TEST_CASE("nothing within walking reaches the knee of the output, running hardly ever" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds()) {
    const std::string& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const auto loudest = [&recipe](const Walk& how) {
      double most = 0;
      for (const auto& step : walk(recipe, how).steps)
        for (const double x : step)
          most = std::max(most, std::abs(x) / kFullScale);
      return most;
    };
    CHECK(loudest({2.5, 1200, 1}) < kKnee);
    CHECK(loudest({2.5, 1200, 0.4}) < kKnee);
    CHECK(loudest({3.5, 700, 0.4, true, 30}) < kKnee);
    CHECK(loudest({1.4}) > 0.005);
  }
}

TEST_CASE("a shoe decides the sound of a hard floor and hardly that of a soft one" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds()) {
    const std::string& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const Walked soft = walk(recipe, {1.4, 700, 0}), hard = walk(recipe, {1.4, 700, 1});
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
  for (const auto& ground : grounds()) {
    const std::string& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const Walked light = walk(recipe, {1.4, 300}), heavy = walk(recipe, {1.4, 1200});
    CHECK(median_level(heavy) > median_level(light) + 2);
    if (one_of(name, {"snow", "gravel", "dryleaves"}))
      CHECK(duration(heavy) > 1.15 * duration(light));
  }
}

TEST_CASE("steps grow louder with the walking speed by 3 to 9 dB for twice the speed" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds()) {
    const std::string& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const double octaves = std::log2(2.0 / 0.7);
    const double growth =
        (median_level(walk(recipe, {2.0})) - median_level(walk(recipe, {0.7}))) / octaves;
    CHECK(growth > (name == "creak" ? 2 : 3)); // boards creak as loudly under a slow foot
    CHECK(growth < 9);
  }
}

TEST_CASE("both actuators are moved by what lands on them, alike on solid ground" *
          doctest::skip(kSanitized)) {
  for (const auto& ground : grounds()) {
    const std::string& name = ground.first;
    const Recipe& recipe = ground.second;
    CAPTURE(name);
    const Walked walked = walk(recipe, {});
    CHECK(walked.heel_drive > 0.05);
    CHECK(walked.ball_drive > 0.05);
    CHECK(std::abs(20 * std::log10(walked.ball_drive / walked.heel_drive)) < 6);
  }
}
