// tactus_reed_study PRESET [options] > trials.csv
//
// Measures whether the force helps. Simulated hands without any knowledge of the notes explore the
// plane of mouth pressure and reed frequency, from a silent start, with and without force; one line
// a trial:
//   preset,hand,stiffness,yield,gain,ceiling,feel,seed,playing,losses,first_s,silence_s,
//   force_n,playing_force_n,speed_mm_s,places
// The columns are explained in trial.hpp and docs/results/reed_study.md. A seed is one person with
// one start and one search, whatever is felt, so trials of one seed are pairs.
//
//   --feel NAME...        off reeds growth height guidance; otherwise all
//   --hand searches|wanders
//   --ceiling N...        largest force; otherwise 1 2
//   --gain N              of the slopes, N for a slope of 1 per side; otherwise 0.3
//   --stiffness N/M...    of the hand; otherwise 200
//   --damping NS/M        of the hand; otherwise 2
//   --yield S             time in which the hand gives way to a force, 0: never; otherwise 1
//   --seeds FIRST LAST    otherwise 1 20
//   --seconds S           otherwise 60
//   --part I/N            every N-th trial from the I-th on (1 <= I <= N), for batches
//   --trace               the course of each trial instead: feel,seed,t,y,z,f_p,force_y,force_z
#include "core/reed/instrument/presets.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "programs/part.hpp"
#include "programs/reed_study/trial.hpp"

#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace {

using namespace tactus;

struct Options {
  std::string preset;
  std::vector<study::Feel> feels;
  std::vector<double> ceilings{1, 2}, stiffnesses{200};
  study::TrialSettings trial{};
  std::size_t first = 1, last = 20;
  programs::Part part;
  bool trace = false;
};

std::optional<study::Feel> feel_named(std::string_view name) {
  for (std::size_t i = 0; i < study::kFeels.size(); ++i)
    if (study::kFeels[i] == name)
      return static_cast<study::Feel>(i);
  return std::nullopt;
}

/// The words after an option, up to the next option.
std::span<char*> values_of(std::span<char*> arguments, std::size_t option) {
  std::size_t end = option + 1;
  while (end < arguments.size() && std::string_view(arguments[end]).substr(0, 2) != "--")
    ++end;
  return arguments.subspan(option + 1, end - option - 1);
}

/// All words as numbers; empty if a word is wrong or if there are too few or too many.
std::vector<double> numbers(std::span<char*> arguments, std::size_t max_count, double low,
                            double high) {
  std::vector<double> found;
  for (const char* word : arguments) {
    const auto value = to_number(word, low, high);
    if (!value || found.size() == max_count)
      return {};
    found.push_back(*value);
  }
  return found;
}

/// Sets an option. Returns an empty text, or a sentence if the option is not valid.
std::string parse_option(std::string_view option, std::span<char*> values, Options& options) {
  constexpr std::size_t kMany = 20;
  std::vector<double> v;
  if (option == "--feel") {
    for (const char* name : values) {
      const auto feel = feel_named(name);
      if (!feel)
        return "--feel " + std::string(name) + ": expected off, reeds, growth, height or guidance";
      options.feels.push_back(*feel);
    }
  } else if (option == "--hand") {
    const std::string_view name = values.size() == 1 ? values[0] : "";
    if (name != "searches" && name != "wanders")
      return "--hand: expected searches or wanders";
    options.trial.exploration.strategy =
        name == "wanders" ? study::Strategy::kWanders : study::Strategy::kSearches;
  } else if (option == "--ceiling") {
    options.ceilings = numbers(values, kMany, 0.01, 20);
    if (options.ceilings.empty())
      return "--ceiling: expected 0.01..20 N";
  } else if (option == "--gain") {
    if ((v = numbers(values, 1, 0, 1000)).empty())
      return "--gain: expected 0..1000 N";
    options.trial.gain_n = v[0];
  } else if (option == "--stiffness") {
    options.stiffnesses = numbers(values, kMany, 1, 5000);
    if (options.stiffnesses.empty())
      return "--stiffness: expected 1..5000 N/m";
  } else if (option == "--damping") {
    if ((v = numbers(values, 1, 0, 100)).empty())
      return "--damping: expected 0..100 N s/m";
    options.trial.hand.damping_n_s_per_m = v[0];
  } else if (option == "--yield") {
    if ((v = numbers(values, 1, 0, 100)).empty())
      return "--yield: expected 0..100 s";
    options.trial.hand.yield_s = v[0];
  } else if (option == "--seeds") {
    if ((v = numbers(values, 2, 1, 1e6)).size() != 2 || v[0] > v[1])
      return "--seeds: expected the first and the last in 1..1000000";
    options.first = static_cast<std::size_t>(v[0]);
    options.last = static_cast<std::size_t>(v[1]);
  } else if (option == "--seconds") {
    if ((v = numbers(values, 1, 1, 3600)).empty())
      return "--seconds: expected 1..3600";
    options.trial.duration_s = v[0];
  } else if (option == "--part") {
    const auto part = programs::to_part(values.size() == 1 ? values[0] : "");
    if (!part)
      return "--part: expected i/n with 1 <= i <= n";
    options.part = *part;
  } else if (option == "--trace" && values.empty()) {
    options.trace = true;
  } else {
    return "unknown option " + std::string(option);
  }
  return "";
}

std::string parse(std::span<char*> arguments, Options& options) {
  if (arguments.empty() || !reed::find_preset(arguments[0]))
    return "no preset given: expected clarinet, sax, oboe, trumpet, trombone, voice or syrinx";
  options.preset = arguments[0];
  for (std::size_t i = 1; i < arguments.size();) {
    const auto values = values_of(arguments, i);
    std::string refusal = parse_option(arguments[i], values, options);
    if (!refusal.empty())
      return refusal;
    i += 1 + values.size();
  }
  if (options.feels.empty())
    for (std::size_t i = 0; i < study::kFeels.size(); ++i)
      options.feels.push_back(static_cast<study::Feel>(i));
  return "";
}

/// For the two instruments of the reed patch, its planes; for others, the range in which notes lie.
reed::ControlRange plane_of(const std::string& preset, const reed::Parameters& parameters) {
  if (preset == "trumpet")
    return {0, 8000, 80, 900};
  if (preset == "clarinet")
    return {0, 5000, 1000, 3500};
  return reed::range_for(parameters);
}

void print(const Options& options, const study::TrialSettings& trial, const study::World& world) {
  const std::string_view feel = study::kFeels[static_cast<std::size_t>(trial.feel)];
  const auto seed = static_cast<unsigned long long>(trial.seed);
  if (options.trace) {
    std::vector<study::Sample> samples;
    (void)run(world, trial, &samples);
    for (const auto& s : samples)
      std::printf("%s,%llu,%.2f,%.4f,%.4f,%.3f,%.3f,%.3f\n", feel.data(), seed, s.time_s, s.y, s.z,
                  s.playability, s.force_y_n, s.force_z_n);
    return;
  }
  const study::TrialResult r = run(world, trial);
  const char* hand =
      trial.exploration.strategy == study::Strategy::kWanders ? "wanders" : "searches";
  std::printf("%s,%s,%g,%g,%g,%g,%s,%llu,%.6f,%d,%.4f,%.4f,%.4f,%.4f,%.3f,%d\n",
              options.preset.c_str(), hand, trial.hand.stiffness_n_per_m, trial.hand.yield_s,
              trial.gain_n, trial.ceiling_n, feel.data(), seed, r.playing, r.losses, r.first_s,
              r.silence_s, r.force_n, r.playing_force_n, 1e3 * r.speed_m_per_s, r.played_cells);
}

} // namespace

int main(int argc, char** argv) {
  Options options;
  const std::string refusal =
      parse(std::span(argv + 1, static_cast<std::size_t>(argc - 1)), options);
  if (!refusal.empty()) {
    std::fprintf(stderr, "tactus_reed_study: %s\n", refusal.c_str());
    return 1;
  }
  const reed::Parameters parameters = *reed::find_preset(options.preset);
  const study::World world(parameters, plane_of(options.preset, parameters));
  if (options.part.part == 1)
    std::puts(options.trace ? "feel,seed,t,y,z,f_p,force_y,force_z"
                            : "preset,hand,stiffness,yield,gain,ceiling,feel,seed,playing,losses,"
                              "first_s,silence_s,force_n,playing_force_n,speed_mm_s,places");
  std::size_t number = 0;
  study::TrialSettings trial = options.trial;
  for (const double stiffness : options.stiffnesses)
    for (const study::Feel feel : options.feels)
      for (const double ceiling : options.ceilings) {
        if (feel == study::Feel::kOff && ceiling != options.ceilings.front())
          continue; // without force there is no ceiling
        for (trial.seed = options.first; trial.seed <= options.last; ++trial.seed) {
          if (number++ % options.part.parts != options.part.part - 1)
            continue;
          trial.hand.stiffness_n_per_m = stiffness;
          trial.feel = feel;
          trial.ceiling_n = feel == study::Feel::kOff ? 0 : ceiling;
          print(options, trial, world);
          std::fflush(stdout);
        }
      }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
