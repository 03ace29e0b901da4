// Plays tactus' virtual reed and measures the notes: one a line on standard input,
//   PRESET RATE BORE_HZ FROM TO SWELL T:PRESSURE,T:PRESSURE,... [NAME VALUE]...
// with the parameters of [greed~] by their message names. The mouth pressure runs straight from
// point to point (s, Pa). One line of numbers comes out for each: cents, foreign tone dB and Hz, H1
// in the bore dB, rms, rms in the bore Pa, centroid Hz, right (0 or 1), time to half and to a tenth
// of the level s, largest rms of 20 ms, H1..H10 dB; with SWELL 1 in front of H1 the frames' worst
// foreign tone dB, cents and number in the wrong register.
#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/parameter_rows.hpp"
#include "core/reed/instrument/presets.hpp"
#include "tests/core/reed/note_measure.hpp"

#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace tactus::reed;

bool set(Parameters& parameters, const std::string& name, double value) {
  for (const Row& row : kRows)
    if (row.name == name) {
      row.set(&parameters, value);
      return true;
    }
  return false;
}

std::vector<double> contour(const std::string& points, double rate) {
  std::vector<double> signal;
  std::istringstream words(points);
  double t0 = 0, p0 = 0;
  for (std::string word; std::getline(words, word, ',');) {
    double t = 0, p = 0;
    if (std::sscanf(word.c_str(), "%lf:%lf", &t, &p) != 2)
      return {};
    while (static_cast<double>(signal.size()) < t * rate) {
      const double share =
          t > t0 ? (static_cast<double>(signal.size()) / rate - t0) / (t - t0) : 1.0;
      signal.push_back(p0 + share * (p - p0));
    }
    t0 = t;
    p0 = p;
  }
  return signal;
}

bool play(std::istringstream& line) {
  std::string preset, points, name;
  double rate = 0, bore = 0, from = 0, to = 0, value = 0;
  int swelling = 0;
  line >> preset >> rate >> bore >> from >> to >> swelling >> points;
  const auto found = find_preset(preset);
  if (!line || !found)
    return false;
  Parameters parameters = *found;
  parameters.tune = true;
  while (line >> name >> value)
    if (!set(parameters, name, value))
      return false;
  const std::vector<double> mouth = contour(points, rate);
  if (mouth.empty())
    return false;

  Instrument instrument;
  instrument.set(parameters);
  instrument.prepare(rate, 64);
  const test::Recording r = test::play(instrument, mouth, rate, 0, bore);
  const test::NoteMeasure note = test::measure_note(r, bore, from, to);
  double top = 0;
  for (const double level : test::envelope(r.sound, rate, 50))
    top = std::max(top, level);
  std::printf("%.2f %.1f %.1f %.1f %.5g %.5g %.1f %d %.4f %.4f %.5g", note.cents,
              note.inharmonic_db, note.inharmonic_hz, note.first_db, note.rms, note.bore_rms,
              note.centroid_hz, note.in_register() ? 1 : 0, test::time_to(r, bore, 0.5 * note.rms),
              test::time_to(r, bore, 0.1 * note.rms), top);
  if (swelling != 0) {
    const test::SwellMeasure swell = test::measure_swell(r, bore);
    std::printf(" %.1f %.2f %d", swell.inharmonic_db, swell.cents, swell.wrong_register);
  }
  for (const double h : note.harmonics)
    std::printf(" %.1f", h);
  std::printf("\n");
  return true;
}

} // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    if (!play(words)) {
      std::fprintf(stderr, "measure_reed: cannot play: %s\n", line.c_str());
      return 1;
    }
    std::fflush(stdout);
  }
}
