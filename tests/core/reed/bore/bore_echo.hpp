#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/bore/tone_hole_end.hpp"
#include "tests/core/reed/render.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

/// Input impedance of the bore as it runs: what comes back of one sample that is sent into it.
namespace tactus::reed::test {

/// Delay line, losses and holes; with a vent the line is divided there, as in ReedBank.
inline std::vector<double> echo_of(const Parameters& p, const Termination& end, double length,
                                   double rate, std::size_t size, bool vented = false) {
  constexpr int kBlock = 8;
  BoreDesign design;
  design.set(p, rate);
  design.set_end(&end);
  const RoundTrip trip = design.round_trip(length);
  RegisterVent vent = RegisterVent::of(p);
  vent.separation = 0; // small waves
  const BoreDesign::Parts parts = design.parts(trip, length, vent.position);
  BoreLine<double, 64> line, below;
  line.prepare(max_delay(rate));
  below.prepare(max_delay(rate));
  RoundTripFilter<double> losses, above_losses;
  VentFilter<double> filter;
  filter.set(vent, rate);
  ToneHoleEnd<double> holes;
  holes.set(rate, 1, p.input_radius);
  holes.finger(&end);
  std::vector<double> echo;
  while (echo.size() < size) {
    BoreLine<double, 64>& last = vented ? below : line;
    double* const wave = line.next();
    double* const bore_end_wave = last.next();
    last.read(vented ? parts.below.delay : trip.delay, 0, bore_end_wave, kBlock);
    {
      RoundTripFilter<double>::BlockFilter block_filter(losses, vented ? parts.below : trip, 0);
      for (int i = 0; i < kBlock; ++i)
        bore_end_wave[i] = block_filter.incident(bore_end_wave[i]);
    }
    holes.reflect(bore_end_wave, kBlock);
    if (vented) {
      line.read(parts.above.delay, 0, wave, kBlock);
      RoundTripFilter<double>::BlockFilter block_filter(above_losses, parts.above, 0);
      filter.pass(block_filter, wave, bore_end_wave, {1, 0}, kBlock);
      below.advance(kBlock);
    }
    for (int i = 0; i < kBlock; ++i) {
      echo.push_back(wave[i]);
      wave[i] = echo.size() == 1 ? 1 : 0;
    }
    line.advance(kBlock);
  }
  return echo;
}

/// 20 log of |Z_in|/Z_0 at a frequency.
inline double level(const Parameters& p, const std::vector<double>& echo, double rate, double hz) {
  Complex round_trip = 0, turn = 1;
  const Complex step = tactus::math::polar(1.0, -2 * std::numbers::pi * hz / rate);
  for (const double x : echo) {
    round_trip += x * turn;
    turn *= step;
  }
  Complex y = (1.0 - round_trip) / (1.0 + round_trip);
  if (p.shape == BoreShape::kCone) // 1/(s M) in units of 1/Z_0
    y += air_at(p.temperature).sound_speed /
         (Complex(0, 2 * std::numbers::pi * hz) * p.apex_distance);
  return -20 * std::log10(abs(y));
}

struct ImpedancePeak {
  double hz, level; // dB over the input's Z_0
};

/// The highest point within 3 % of a frequency, to a hundredth of a cent.
inline ImpedancePeak peak_near(const Parameters& p, const std::vector<double>& echo, double rate,
                               double hz) {
  const auto height = [&](double f) { return level(p, echo, rate, f); };
  const double at = maximum_of(height, 0.97 * hz, 1.03 * hz, 18);
  return {at, height(at)};
}

/// A row of bore_reference.hpp or bell_reference.hpp.
struct ImpedanceReference {
  BoreEnd end = BoreEnd::kOpen;
  std::string fingering; // MIDI number, a letter for each hole, or "bell"
  double length = 0;     // of the line, m
  std::vector<ImpedancePeak> peaks;
};

/// From the reed down: c closed, o open, h half, q three quarters covered.
inline std::vector<double> state_of(std::string_view letters) {
  std::vector<double> closed;
  for (const char letter : letters)
    closed.push_back(letter == 'c' ? 1 : letter == 'h' ? 0.5 : letter == 'q' ? 0.75 : 0);
  return closed;
}

inline std::vector<ImpedanceReference> read_references(std::string_view rows) {
  constexpr std::string_view kNames[] = {"open", "clarinet", "saxophone",
                                         "oboe", "trumpet",  "trombone"};
  std::vector<ImpedanceReference> references;
  std::istringstream words{std::string(rows)};
  for (std::string word; words >> word;)
    if (const auto* const name = std::find(std::begin(kNames), std::end(kNames), word);
        name != std::end(kNames)) {
      references.push_back({static_cast<BoreEnd>(name - kNames), {}, 0, {}});
      words >> references.back().fingering >> references.back().length;
    } else {
      references.back().peaks.push_back({std::stod(word), 0});
      words >> references.back().peaks.back().level;
    }
  return references;
}

} // namespace tactus::reed::test
