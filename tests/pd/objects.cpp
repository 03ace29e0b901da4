#include "tests/pd/host.hpp"
#include "tests/pd/probe/probe~.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace tactus::test {
namespace {

void load(const std::string& folder, std::string_view name) {
  std::string setup(name);
  if (setup.back() == '~')
    setup.replace(setup.size() - 1, 1, "_tilde");
  const std::string file = folder + "/" + std::string(name) + TACTUS_MODULE_SUFFIX;
  if (const std::string why = load_module(file, setup + "_setup"); !why.empty()) {
    std::fprintf(stderr, "cannot load %s: %s\n", file.c_str(), why.c_str());
    std::exit(1);
  }
}

} // namespace

const std::vector<ObjectDescription>& objects() {
  static const std::vector<ObjectDescription> all = [] {
    std::vector<ObjectDescription> found = described_objects();
    for (const ObjectDescription& described : found)
      load(TACTUS_STAGE, described.declaration->name);
    load(TACTUS_TEST_OBJECTS, Probe::declaration.name);
    found.push_back({&Probe::declaration, traits_of<Probe>()});
    return found;
  }();
  return all;
}

Buffers plausible_inputs(const Declaration& declaration, double rate, std::size_t samples) {
  Buffers result;
  for (const Port& port : declaration.inlets) {
    if (port.kind != Port::Kind::kSignal)
      continue;
    std::vector<double>& signal = result.emplace_back(samples);
    for (std::size_t n = 0; n < samples; ++n) {
      const double t = 2 * std::numbers::pi * static_cast<double>(n) / rate;
      if (port.unit == "Pa")
        signal[n] = 4000 * std::abs(std::sin(2 * t));
      else if (port.unit == "Hz")
        signal[n] = 300 + 60 * std::sin(3 * t);
      else
        signal[n] = 0.5 + 0.4 * std::sin(220 * t) * std::sin(2.5 * t);
    }
  }
  return result;
}

std::string bad_outlet(const Buffers& outputs, const Declaration& declaration) {
  auto signal = outputs.begin();
  for (const Port& outlet : declaration.outlets) {
    if (outlet.kind != Port::Kind::kSignal)
      continue;
    const double bound = outlet.name == "sound" ? 1 : std::numeric_limits<double>::max();
    if (!std::all_of(signal->begin(), signal->end(),
                     [bound](double x) { return std::abs(x) <= bound; }))
      return std::string(outlet.name);
    ++signal;
  }
  return {};
}

Buffers part_of(const Buffers& whole, std::size_t begin, std::size_t frames) {
  Buffers part;
  for (const std::vector<double>& signal : whole)
    part.emplace_back(signal.begin() + static_cast<std::ptrdiff_t>(begin),
                      signal.begin() + static_cast<std::ptrdiff_t>(begin + frames));
  return part;
}

void append(Buffers& whole, const Buffers& part) {
  whole.resize(part.size());
  for (std::size_t i = 0; i < part.size(); ++i)
    whole[i].insert(whole[i].end(), part[i].begin(), part[i].end());
}

} // namespace tactus::test
