// What carries the sound of a step? The share of each section of a recipe in the energy that is
// heard, and what changes when it is left out: the level, the octave band and the time after the
// heel's contact that change most.
//
//   bench_footstep_sections [FOLDER] [SECONDS]     recipes of a folder; data/surfaces, 60 s a speed
//
// Walks of .8, 1.4 and 1.8 m/s under 700 N, shoe .4, without the room. A section is left out by its
// level, so that all random draws stay what they are. Shares are of the sum over the sections
// alone; the friction's and the modes' sounds may add up or cancel. Bands and times count that lie
// within 40 dB of the whole; a section is heard when one of the three changes by 1 dB or more.
#include "bench/recipe_sections.hpp"
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
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace {

using namespace tactus::footstep;
using tactus::bench::SoundingSection;

constexpr double kRate = 48000;
constexpr std::array<double, 3> kSpeeds{0.8, 1.4, 1.8};
constexpr double kEnergyThreshold = 1e-4; // of the whole energy: -40 dB
constexpr double kAudibleDb = 1;
constexpr std::size_t kBands = 9; // octaves from 31.25 Hz to 8 kHz
constexpr std::array<double, 8> kWindowEdgesMs{0, 10, 25, 50, 100, 200, 400, 800};
constexpr std::size_t kWindows = kWindowEdgesMs.size() - 1;

double decibels(double ratio) { return 10 * std::log10(std::clamp(ratio, 1e-12, 1e12)); }

/// Energy of a sound: of the whole, in octaves (band-pass filters of second order, 1 octave wide)
/// and in windows of time after the heel's contact.
class Energy {
public:
  Energy() {
    for (std::size_t b = 0; b < kBands; ++b) {
      const double w = 2 * std::numbers::pi * 31.25 * std::pow(2.0, static_cast<double>(b)) / kRate;
      const double alpha = std::sin(w) / (2 * std::numbers::sqrt2);
      filter_[b] = {alpha / (1 + alpha), -2 * std::cos(w) / (1 + alpha), (1 - alpha) / (1 + alpha)};
    }
  }
  void contact() {
    since_ = 0;
    window_ = 0;
  }
  void add(double x) {
    whole += x * x;
    for (std::size_t b = 0; b < kBands; ++b) {
      Filter& f = filter_[b];
      const double y = f.gain * x + f.s1;
      f.s1 = f.s2 - f.a1 * y;
      f.s2 = -f.gain * x - f.a2 * y;
      band[b] += y * y;
    }
    while (window_ < kWindows && since_ >= kWindowEdgesMs[window_ + 1] * kRate / 1000)
      ++window_;
    if (window_ < kWindows)
      window[window_] += x * x;
    ++since_;
  }
  double whole = 0;
  std::array<double, kBands> band{};
  std::array<double, kWindows> window{};

private:
  struct Filter {
    double gain, a1, a2, s1 = 0, s2 = 0;
  };
  std::array<Filter, kBands> filter_{};
  double since_ = 0;
  std::size_t window_ = kWindows; // no contact yet
};

Energy walk(const std::string& text, double speed, double seconds) {
  Recipe recipe;
  if (const std::string error_text = tactus::files::read_recipe(text, recipe);
      !error_text.empty()) {
    std::fprintf(stderr, "%s\n", error_text.c_str());
    std::exit(1);
  }
  tactus::bench::WalkingFoot foot(recipe, {speed}, kRate, 3);
  Energy heard;
  for (double n = 0; n < seconds * kRate; ++n) {
    const double sound = foot.next().pressure_pa;
    if (foot.heel_lands())
      heard.contact();
    heard.add(sound);
  }
  return heard;
}

/// The part that changes most, of those that are heard in the whole, and by how many dB.
struct Change {
  std::size_t part = 0;
  double db = 0;
};

Change largest_change(std::span<const double> with, std::span<const double> without, double whole) {
  Change found;
  for (std::size_t i = 0; i < with.size(); ++i)
    if (with[i] > kEnergyThreshold * whole)
      if (const double db = decibels(without[i] / with[i]); std::abs(db) > std::abs(found.db))
        found = {i, db};
  return found;
}

void report(const std::string& name, const std::string& text, double seconds) {
  const std::vector<SoundingSection> sections = tactus::bench::sounding_sections(text);
  std::vector<std::array<double, kSpeeds.size()>> share(sections.size());
  for (std::size_t v = 0; v < kSpeeds.size(); ++v) {
    double sum = 1e-300;
    for (std::size_t i = 0; i < sections.size(); ++i)
      sum += share[i][v] = walk(tactus::bench::only(text, sections[i]), kSpeeds[v], seconds).whole;
    for (auto& s : share)
      s[v] *= 100 / sum;
  }
  const Energy whole = walk(text, 1.4, seconds);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const Energy rest = walk(tactus::bench::without(text, sections[i]), 1.4, seconds);
    const double level = decibels(rest.whole / whole.whole);
    const Change band = largest_change(whole.band, rest.band, whole.whole);
    const Change window = largest_change(whole.window, rest.window, whole.whole);
    const bool heard =
        std::max({std::abs(level), std::abs(band.db), std::abs(window.db)}) >= kAudibleDb;
    std::printf(
        "%-11s %-8s %6.1f %6.1f %6.1f %8.1f dB %7.1f dB at %4.0f Hz %7.1f dB at %3.0f-%3.0f ms"
        "  %s\n",
        i == 0 ? name.c_str() : "", sections[i].name.c_str(), share[i][0], share[i][1], share[i][2],
        level, band.db, 31.25 * std::pow(2.0, static_cast<double>(band.part)), window.db,
        kWindowEdgesMs[window.part], kWindowEdgesMs[window.part + 1],
        heard ? "heard" : "NOT HEARD");
  }
  std::fflush(stdout);
}

} // namespace

int main(int count, char** arguments) {
  const std::filesystem::path folder = count > 1 ? arguments[1] : "data/surfaces";
  const double seconds = count > 2 ? std::atof(arguments[2]) : 60;
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    if (file.path().extension() == ".txt")
      files.push_back(file.path());
  std::sort(files.begin(), files.end());
  std::printf("%-11s %-8s %20s   left out: %s, octave and time that change most\n", "ground",
              "section", "% at .8 1.4 1.8 m/s", "level");
  for (const auto& path : files) {
    std::ifstream file(path);
    report(path.stem().string(), {std::istreambuf_iterator<char>(file), {}}, seconds);
  }
}
