// How loud and how strong are the steps of each ground?
//
//   bench_footstep_levels [FOLDER] [--calibrate]     recipes of a folder; data/surfaces
//
// Levels are A-weighted with the time constant Fast (IEC 61672), the highest of each step, of one
// foot in the open at the walker's ears (gain 1: full scale is 2 Pa); median over the steps of 30
// s.
// --calibrate writes `level`, `felt` and `felt_ball` of each recipe of a known name so that a walk
// of 1.4 m/s under 700 N in shoe 0.4 has the level of the table below and the median peaks of its
// drives are 0.4 under the heel and 3 dB less under the ball.
#include "bench/walking_foot.hpp"
#include "files/recipe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace tactus::footstep;
using tactus::bench::Walk;

constexpr double kRate = 48000, kSeconds = 30, kFullScale = 2, kKnee = 0.7, kTargetDrive = 0.4,
                 kBallDrive = 0.7;

/// dB(A) of a step in hard rubber at 1.4 m/s. Walking noise in a room is 50 to 75 dB(A) by floor
/// covering; which ground is louder than which is our ear's judgement, good to some 5 dB.
const std::map<std::string, double> kReferenceLevel{
    {"wood", 54},     {"creak", 58},  {"underbrush", 62}, {"snow", 58},      {"frozensnow", 50},
    {"sand", 56},     {"gravel", 60}, {"metal", 52.5},    {"highgrass", 48}, {"dryleaves", 61},
    {"concrete", 47}, {"dirt", 53},   {"puddle", 60},     {"water", 61},     {"carpet", 49}};

/// A-weighting from its poles at 20.6 (twice), 107.7, 737.9 and 12194 Hz (twice), bilinear, 0 dB at
/// 1 kHz.
class WeightA {
public:
  double next(double x) {
    for (std::size_t i = 0; i < kPoles.size(); ++i) {
      const double g = std::tan(std::numbers::pi * kPoles[i] / kRate);
      const double change = g / (1 + g) * (x - state_[i]);
      const double low = state_[i] + change;
      state_[i] = low + change;
      x = kPoles[i] > 5000 ? low : x - low;
    }
    return 1.2589 * x; // +2.0 dB
  }

private:
  static constexpr std::array<double, 6> kPoles{20.6, 20.6, 107.7, 737.9, 12194, 12194};
  std::array<double, 6> state_{};
};

/// Of each step.
struct Steps {
  std::vector<double> level_db, peak, heel_drive, ball_drive, centroid;
};

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values.empty()
             ? 0
             : values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

Steps walk(const Recipe& recipe, const Walk& how) {
  tactus::bench::WalkingFoot foot(recipe, how, kRate, 3);
  WeightA weight;
  const double kept = std::exp(-1 / (0.125 * kRate));
  double power = 0, highest = 0, peak = 0, heel = 0, ball = 0, slope = 0, energy = 0, before = 0;
  Steps steps;
  bool begun = false;
  for (double n = 0; n < kSeconds * kRate; ++n) {
    const Foot::Out out = foot.next();
    if (foot.heel_lands()) {
      if (begun && peak > 0) {
        steps.level_db.push_back(10 * std::log10(highest / 4e-10));
        steps.peak.push_back(peak);
        steps.heel_drive.push_back(heel);
        steps.ball_drive.push_back(ball);
        // Of the energy spectrum: from the mean square of the derivative.
        steps.centroid.push_back(std::sqrt(slope / energy) * kRate / (2 * std::numbers::pi));
      }
      begun = true;
      highest = peak = heel = ball = slope = energy = 0;
    }
    const double a = weight.next(out.pressure_pa);
    power = kept * power + (1 - kept) * a * a;
    highest = std::max(highest, power);
    peak = std::max(peak, std::abs(out.pressure_pa));
    heel = std::max(heel, std::abs(out.heel_drive));
    ball = std::max(ball, std::abs(out.ball_drive));
    energy += out.pressure_pa * out.pressure_pa;
    slope += (out.pressure_pa - before) * (out.pressure_pa - before);
    before = out.pressure_pa;
  }
  return steps;
}

/// The recipe's text with another number for a key before the first section, which stands below
/// `level` if it is new.
std::string with(const std::string& text, const std::string& key, double value) {
  const bool is_new = text.find('\n' + key + ' ') > text.find("\n[");
  std::istringstream lines(text);
  std::ostringstream out;
  char number[32];
  std::snprintf(number, sizeof number, "%.3g", value);
  bool written = false;
  for (std::string line; std::getline(lines, line);) {
    const std::string first = line.substr(0, line.find(' '));
    if (written || first != (is_new ? "level" : key)) {
      out << line << '\n';
      continue;
    }
    if (is_new)
      out << line << '\n';
    out << key << ' ' << number << '\n';
    written = true;
  }
  return out.str();
}

Recipe recipe_of(const std::string& text, const std::string& path) {
  Recipe recipe;
  if (const std::string error_text = tactus::files::read_recipe(text, recipe);
      !error_text.empty()) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), error_text.c_str());
    std::exit(1);
  }
  return recipe;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void calibrate(const std::filesystem::path& path) {
  const auto target_level = kReferenceLevel.find(path.stem().string());
  if (target_level == kReferenceLevel.end())
    return;
  std::string text = text_of(path);
  const Recipe recipe = recipe_of(text, path.string());
  const Steps steps = walk(recipe, {});
  const double factor = std::pow(10, (target_level->second - quantile(steps.level_db, 0.5)) / 20);
  const double heel = quantile(steps.heel_drive, 0.5), ball = quantile(steps.ball_drive, 0.5);
  text = with(text, "felt_ball", recipe.felt_ball * kBallDrive * heel / ball);
  text = with(text, "felt", recipe.felt * kTargetDrive / (factor * heel));
  text = with(text, "level", recipe.level * factor);
  std::ofstream(path) << text;
}

void print(const std::filesystem::path& path) {
  const Recipe recipe = recipe_of(text_of(path), path.string());
  const auto level = [&](const Walk& how) { return quantile(walk(recipe, how).level_db, 0.5); };
  const Steps usual = walk(recipe, {});
  std::printf("%-11s", path.stem().c_str());
  for (const double speed : {0.5, 0.8, 1.4, 1.8, 2.5})
    std::printf(" %5.1f", level({speed}));
  std::printf("  %5.1f", level({3.5, 700, 0.4, Style::kRun}));
  std::printf("  %+5.1f %+5.1f", level({1.4, 300}) - quantile(usual.level_db, 0.5),
              level({1.4, 1200}) - quantile(usual.level_db, 0.5));
  const Steps soft = walk(recipe, {1.4, 700, 0}), hard = walk(recipe, {1.4, 700, 1});
  std::printf("  %5.0f %5.0f %+5.1f", quantile(soft.centroid, 0.5), quantile(hard.centroid, 0.5),
              quantile(hard.level_db, 0.5) - quantile(soft.level_db, 0.5));
  double min_level = 0;
  for (const double speed : {0.3, 0.5, 1.4, 2.5}) {
    const Steps steps = walk(recipe, {speed});
    min_level = std::min(min_level, quantile(steps.level_db, 0) - quantile(steps.level_db, 0.5));
  }
  std::printf("  %5.1f", min_level);
  const Steps heavy = walk(recipe, {2.5, 1200, 1}),
              run = walk(recipe, {3.5, 700, 0.4, Style::kRun});
  double over = 0;
  for (const double p : run.peak)
    over += p > kKnee * kFullScale ? 100.0 / static_cast<double>(run.peak.size()) : 0;
  std::printf("  %5.2f %5.2f %5.1f", quantile(usual.peak, 0.5) / kFullScale,
              quantile(heavy.peak, 1) / kFullScale, over);
  const double heel = quantile(usual.heel_drive, 0.5), ball = quantile(usual.ball_drive, 0.5);
  std::printf("  %5.2f %5.2f %+5.1f\n", heel, ball, 20 * std::log10(ball / heel));
}

} // namespace

int main(int count, char** arguments) {
  std::filesystem::path folder = "data/surfaces";
  bool set = false;
  for (int i = 1; i < count; ++i)
    if (std::string(arguments[i]) == "--calibrate")
      set = true;
    else
      folder = arguments[i];
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    if (file.path().extension() == ".txt")
      files.push_back(file.path());
  std::sort(files.begin(), files.end());
  if (set)
    for (const auto& path : files)
      calibrate(path);
  std::printf("dB(A) of a step at m/s, running; for 300, 1200 N; shoe 0, 1: centroid in Hz, dB(A);"
              " quietest step under the median, dB;\npeak of full scale at 1.4 m/s, and the highest"
              " of 1200 N in steel at 2.5 m/s; running steps over the knee, %%; drives\n");
  std::printf("%-11s %5.1f %5.1f %5.1f %5.1f %5.1f  %5s  %5s %5s  %5s %5s %5s  %5s  %5s %5s %5s  "
              "%5s %5s %5s\n",
              "", 0.5, 0.8, 1.4, 1.8, 2.5, "run", "300", "1200", "soft", "hard", "dB", "least",
              "peak", "heavy", "run%", "heel", "ball", "dB");
  for (const auto& path : files)
    print(path);
}
