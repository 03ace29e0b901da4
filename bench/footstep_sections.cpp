// What carries the sound of a step? The share of each section of a recipe in the energy that is
// heard, and what is heard less when it is left out: of the level, and of the octave band that
// loses most.
//
//   bench_footstep_sections [FOLDER] [SECONDS]     recipes of a folder; data/surfaces, 60 s a speed
//
// Walks of .8, 1.4 and 1.8 m/s under 700 N, shoe .4, without the room. A section is left out by its
// level, so that all draws of chance stay what they are. Shares are of the sum over the sections
// alone; the friction's and the modes' sounds may add up or cancel.
#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace {

using namespace tactus::footstep;
using tactus::particle::CloudSettings;

constexpr double kRate = 48000;
constexpr std::size_t kBands = 9; // octaves from 31.5 Hz to 8 kHz

/// Power of a sound in octaves: band-pass filters of second order, 1 octave wide.
class Octaves {
public:
  Octaves() {
    for (std::size_t b = 0; b < kBands; ++b) {
      const double w = 2 * std::numbers::pi * 31.25 * std::pow(2.0, static_cast<double>(b)) / kRate;
      const double alpha = std::sin(w) / (2 * std::numbers::sqrt2);
      filter_[b] = {alpha / (1 + alpha), -2 * std::cos(w) / (1 + alpha), (1 - alpha) / (1 + alpha)};
    }
  }
  void add(double x) {
    energy[kBands] += x * x;
    for (std::size_t b = 0; b < kBands; ++b) {
      Filter& f = filter_[b];
      const double y = f.gain * x + f.s1;
      f.s1 = f.s2 - f.a1 * y;
      f.s2 = -f.gain * x - f.a2 * y;
      energy[b] += y * y;
    }
  }
  std::array<double, kBands + 1> energy{}; ///< of the bands, and of the whole

private:
  struct Filter {
    double gain, a1, a2, s1 = 0, s2 = 0;
  };
  std::array<Filter, kBands> filter_{};
};

/// One section of a recipe.
struct Section {
  std::string name;
  double* level;
};

std::vector<Section> sections_of(Recipe& recipe) {
  std::vector<Section> found;
  if (recipe.solid.present)
    found.push_back({"impact", &recipe.solid.level});
  if (recipe.friction.present)
    found.push_back({"friction", &recipe.friction.level});
  for (std::size_t i = 0; i < recipe.clouds; ++i) {
    CloudSettings& cloud = recipe.cloud[i].settings;
    constexpr std::array<const char*, 3> kNames{"grains", "bubbles", "rustle"};
    found.push_back({kNames[static_cast<std::size_t>(cloud.kind)], &cloud.level});
  }
  return found;
}

Octaves walk(const Recipe& recipe, double speed, double seconds) {
  const auto foot = std::make_unique<Foot>();
  Gait gait;
  foot->prepare(kRate);
  foot->seed(3);
  foot->set_room(0);
  foot->set_shoe(0.4);
  foot->set_weight(700);
  foot->stand_on(1, recipe, 1, recipe, 0);
  gait.prepare(kRate);
  gait.seed(3);
  gait.set({speed, 700, 0.4}, 0.04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> soles{};
  Octaves heard;
  for (double n = 0; n < seconds * kRate; ++n) {
    gait.next(soles);
    heard.add(foot->next(soles[0]).heard);
  }
  return heard;
}

double decibels(double ratio) { return 10 * std::log10(std::max(ratio, 1e-12)); }

} // namespace

int main(int count, char** words) {
  const std::filesystem::path folder = count > 1 ? words[1] : "data/surfaces";
  const double seconds = count > 2 ? std::atof(words[2]) : 60;
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    if (file.path().extension() == ".txt")
      files.push_back(file.path());
  std::sort(files.begin(), files.end());
  std::printf("%-12s %-8s %23s %12s %16s\n", "ground", "section", "share at .8, 1.4, 1.8",
              "left out:", "octave of most");
  for (const auto& path : files) {
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    Recipe recipe;
    if (const std::string complaint = read_recipe(text, recipe); !complaint.empty()) {
      std::fprintf(stderr, "%s: %s\n", path.c_str(), complaint.c_str());
      return 1;
    }
    const std::vector<Section> sections = sections_of(recipe);
    constexpr std::array<double, 3> kSpeeds{0.8, 1.4, 1.8};
    std::vector<std::array<double, 3>> share(sections.size());
    std::vector<std::array<double, 2>> lost(sections.size());
    for (std::size_t v = 0; v < kSpeeds.size(); ++v) {
      std::vector<double> levels, alone;
      for (const Section& s : sections)
        levels.push_back(*s.level);
      double sum = 0;
      for (std::size_t i = 0; i < sections.size(); ++i) {
        for (std::size_t j = 0; j < sections.size(); ++j)
          *sections[j].level = i == j ? levels[j] : 0;
        alone.push_back(walk(recipe, kSpeeds[v], seconds).energy[kBands]);
        sum += alone.back();
      }
      for (std::size_t j = 0; j < sections.size(); ++j)
        *sections[j].level = levels[j];
      for (std::size_t i = 0; i < sections.size(); ++i)
        share[i][v] = alone[i] / sum;
      if (kSpeeds[v] != 1.4)
        continue;
      const auto whole = walk(recipe, kSpeeds[v], seconds).energy;
      for (std::size_t i = 0; i < sections.size(); ++i) {
        *sections[i].level = 0;
        const auto without = walk(recipe, kSpeeds[v], seconds).energy;
        *sections[i].level = levels[i];
        lost[i][0] = decibels(without[kBands] / whole[kBands]);
        for (std::size_t b = 0; b < kBands; ++b)
          if (whole[b] > 1e-4 * whole[kBands]) // of a band that is heard at all
            lost[i][1] = std::min(lost[i][1], decibels(without[b] / whole[b]));
      }
    }
    for (std::size_t i = 0; i < sections.size(); ++i)
      std::printf("%-12s %-8s %7.2f %7.2f %7.2f %9.1f dB %13.1f dB\n",
                  i == 0 ? path.stem().c_str() : "", sections[i].name.c_str(), 100 * share[i][0],
                  100 * share[i][1], 100 * share[i][2], lost[i][0], lost[i][1]);
  }
}
