// Plays tactus' virtual reed for measurement: one note a line on standard input,
//   FILE PRESET RATE SECONDS PRESSURE_PA REED_HZ BORE_HZ [NAME VALUE]...
// with the parameters of [greed~] by their message names. The mouth pressure rises over 20 ms.
// FILE receives doubles: sound, p_b and U one after the other.
#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/parameter_rows.hpp"
#include "core/reed/instrument/presets.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

bool set(tactus::reed::Parameters& parameters, const std::string& name, double value) {
  for (const tactus::reed::Row& row : tactus::reed::kRows)
    if (row.name == name) {
      row.set(&parameters, value);
      return true;
    }
  return false;
}

bool play(std::istringstream& line) {
  std::string file, preset, name;
  double rate = 0, seconds = 0, pressure = 0, reed = 0, bore = 0, value = 0;
  line >> file >> preset >> rate >> seconds >> pressure >> reed >> bore;
  const auto found = tactus::reed::find_preset(preset);
  if (!line || !found)
    return false;
  tactus::reed::Parameters parameters = *found;
  while (line >> name >> value)
    if (!set(parameters, name, value))
      return false;

  tactus::reed::Instrument instrument;
  instrument.set(parameters);
  instrument.prepare(rate, 64);
  const std::size_t samples = static_cast<std::size_t>(rate * seconds);
  const std::vector<double> reeds(samples, reed), bores(samples, bore);
  std::vector<double> mouth(samples), sound(samples), theta(samples), p_b(samples), flow(samples);
  for (std::size_t i = 0; i < samples; ++i)
    mouth[i] = pressure * std::min(1.0, static_cast<double>(i) / (0.02 * rate));
  instrument.process<double>({mouth, reeds, bores}, {sound, theta, p_b, flow});
  std::ofstream out(file, std::ios::binary);
  for (const auto* signal : {&sound, &p_b, &flow})
    out.write(reinterpret_cast<const char*>(signal->data()),
              static_cast<std::streamsize>(samples * sizeof(double)));
  return out.good();
}

} // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    if (!play(words)) {
      std::fprintf(stderr, "render_reed: cannot play: %s\n", line.c_str());
      return 1;
    }
  }
}
