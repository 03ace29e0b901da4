// tactus_reed_map PRESET [options] > map.csv
//
// Where an instrument plays, over mouth pressure and reed frequency, one line per node:
//   y,z,pressure_pa,reed_hz,f_p,growth_per_s,frequency_hz,free
// f_p by playing the node from rest for 0.7 s; growth rate and frequency of the dominant mode by
// linear theory; free is 0 where the valve rests against its stop or limit, so that no note starts.
//
//   --range P_LO P_HI F_LO F_HI   Pa and Hz; otherwise a range in which the preset plays
//   --bore HZ                     bore frequency; otherwise the preset's own length
//   --nodes COLUMNS ROWS          along pressure and along frequency; otherwise 61 61
//   --part I/N                    only the I-th of N shares of the rows (1 <= I <= N), for batches
#include "core/reed/instrument/presets.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "core/reed/playability/playability_map.hpp"
#include "programs/part.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace {

using namespace tactus::reed;

constexpr const char* kUsage =
    R"(tactus_reed_map PRESET [--range P_LO P_HI F_LO F_HI] [--bore HZ] [--nodes COLUMNS ROWS]
                [--part I/N] > map.csv

Prints where an instrument plays, over mouth pressure and reed frequency, one line per node.

  PRESET   clarinet, sax, oboe, trumpet, trombone, voice or syrinx
  --range  mouth pressure, Pa, and reed frequency, Hz (a range in which the preset plays)
  --bore   frequency of the bore, 8..4000 Hz (from the preset's own length)
  --nodes  2..2000 nodes along pressure and along frequency (61 61)
  --part   share I of N of the rows, for batches
)";

struct Order {
  Parameters parameters{};
  ControlRange range{};
  double bore_frequency = 0;
  std::size_t columns = 61, rows = 61;
  tactus::programs::Part part;
};

int refuse(const std::string& sentence) {
  std::fprintf(stderr, "tactus_reed_map: %s\n", sentence.c_str());
  return 1;
}

/// Reads the numbers that follow an option, each within low..high. Returns false if one is missing
/// or outside.
bool take(std::span<char*> words, std::size_t at, std::span<double> values, double low,
          double high) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value =
        at + 1 + i < words.size() ? tactus::to_number(words[at + 1 + i], low, high) : std::nullopt;
    if (!value)
      return false;
    values[i] = *value;
  }
  return true;
}

/// Reads the command line. Returns an empty text, or a sentence if the command line is not valid.
std::string read(std::span<char*> words, Order& order) {
  if (words.empty())
    return "no preset given: expected clarinet, sax, oboe, trumpet, trombone, voice or syrinx";
  const auto preset = find_preset(words[0]);
  if (!preset)
    return "preset " + std::string(words[0]) +
           ": expected clarinet, sax, oboe, trumpet, trombone, voice or syrinx";
  order.parameters = *preset;
  order.range = range_for(*preset);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string_view option = words[i];
    double v[4] = {};
    if (option == "--range") {
      if (!take(words, i, std::span(v, 4), -50e3, 50e3) || v[0] >= v[1] || v[2] < 1 || v[2] >= v[3])
        return "--range: expected p_lo < p_hi in Pa and 1 <= f_lo < f_hi in Hz";
      order.range = {v[0], v[1], v[2], v[3]};
      i += 4;
    } else if (option == "--bore") {
      if (!take(words, i, std::span(v, 1), 8, 4000))
        return "--bore: expected 8..4000 Hz";
      order.bore_frequency = v[0];
      i += 1;
    } else if (option == "--nodes") {
      if (!take(words, i, std::span(v, 2), 2, 2000))
        return "--nodes: expected two numbers in 2..2000";
      order.columns = static_cast<std::size_t>(v[0]);
      order.rows = static_cast<std::size_t>(v[1]);
      i += 2;
    } else if (option == "--part") {
      const auto part = tactus::programs::to_part(i + 1 < words.size() ? words[i + 1] : "");
      if (!part)
        return "--part: expected i/n with 1 <= i <= n";
      order.part = *part;
      i += 1;
    } else {
      return "unknown option " + std::string(option) + "; see --help";
    }
  }
  return "";
}

} // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--help")
    return std::fputs(kUsage, stdout) < 0 ? 1 : 0;
  Order order;
  const std::string refusal = read(std::span(argv + 1, static_cast<std::size_t>(argc - 1)), order);
  if (!refusal.empty())
    return refuse(refusal);

  PlayabilityMapSettings settings;
  settings.parameters = order.parameters;
  settings.range = order.range;
  settings.bore_frequency = order.bore_frequency;
  PlayabilityMap map;
  map.begin(settings, order.columns, order.rows);
  const double length = map.length();
  const LinearStability theory(clamped(order.parameters), length);
  const std::size_t first = (order.part.part - 1) * order.rows / order.part.parts * order.columns;
  const std::size_t end = order.part.part * order.rows / order.part.parts * order.columns;
  if (order.part.part == 1)
    std::puts("y,z,pressure_pa,reed_hz,f_p,growth_per_s,frequency_hz,free");
  for (std::size_t n = first; n < end;) {
    const std::size_t done = std::min(map.advance(n), end);
    for (; n < done; ++n) {
      const std::size_t i = n % order.columns, k = n / order.columns;
      const double y = map.field().y_of(i), z = map.field().z_of(k);
      const double pressure = order.range.pressure(y), reed = order.range.frequency(z);
      const Mode mode = theory.dominant_mode(pressure, reed);
      std::printf("%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d\n", y, z, pressure, reed,
                  map.field().node(i, k), mode.growth_rate, mode.frequency_hz,
                  theory.equilibrium(pressure, reed).free ? 1 : 0);
    }
  }
  return std::fflush(stdout) == 0 ? 0 : refuse("cannot write to standard output");
}
