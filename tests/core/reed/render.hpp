#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/player/player.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

/// Plays an instrument and measures what comes out, for the tests.
namespace tactus::reed::test {

struct Recording {
  double rate = 48000;
  std::vector<double> sound, theta, bore_pressure, flow;
};

/// The three inlets, sample by sample.
struct Controls {
  std::vector<double> pressure, reed, bore;
};

inline double hertz(double key) { return 440 * std::exp2((key - 69) / 12); }

/// A preset in a player's hands.
inline Parameters with_player(const char* preset) {
  Parameters p = find_preset(preset).value();
  p.tune = true;
  return p;
}

inline Instrument make_instrument(const Parameters& p, double rate = 48000) {
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(rate, 64);
  return instrument;
}

/// Mouth pressure rises straight to its value within ramp_s and stays.
inline std::vector<double> ramp(double pressure, double seconds, double rate,
                                double ramp_s = 0.02) {
  std::vector<double> signal(static_cast<std::size_t>(seconds * rate));
  for (std::size_t n = 0; n < signal.size(); ++n)
    signal[n] = pressure * std::min(1.0, static_cast<double>(n) / (ramp_s * rate));
  return signal;
}

inline Player make_player(const Parameters& p, double rate = 48000) {
  BoreDesign bore;
  bore.set(p, rate);
  Player player;
  player.prepare(rate);
  player.set(p, bore);
  return player;
}

/// In blocks of `block` samples; 0: in one.
inline Recording play(Instrument& instrument, const Controls& in, double rate = 48000,
                      std::size_t block = 0) {
  const std::size_t size = in.pressure.size();
  Recording r;
  r.rate = rate;
  for (auto* signal : {&r.sound, &r.theta, &r.bore_pressure, &r.flow})
    signal->resize(size);
  for (std::size_t at = 0, count = 0; at < size; at += count) {
    count = block > 0 ? std::min(block, size - at) : size;
    const auto piece = [at, count](auto& x) { return std::span(x).subspan(at, count); };
    instrument.process<double>(
        {piece(in.pressure), piece(in.reed), piece(in.bore)},
        {piece(r.sound), piece(r.theta), piece(r.bore_pressure), piece(r.flow)});
  }
  return r;
}

inline Recording play(Instrument& instrument, std::vector<double> pressure, double rate,
                      double reed_frequency = 0, double bore_frequency = 0) {
  const std::size_t size = pressure.size();
  return play(instrument,
              {std::move(pressure), std::vector<double>(size, reed_frequency),
               std::vector<double>(size, bore_frequency)},
              rate);
}

inline Recording play(const Parameters& parameters, double pressure, double seconds,
                      double rate = 48000, double ramp_s = 0.02, double bore_frequency = 0) {
  Instrument instrument = make_instrument(parameters, rate);
  return play(instrument, ramp(pressure, seconds, rate, ramp_s), rate, 0, bore_frequency);
}

/// A note in Hz blown at a steady pressure.
inline Recording play_note(const Parameters& p, double pressure, double seconds, double note,
                           double rate = 48000) {
  return play(p, pressure, seconds, rate, 0.02, note);
}

inline std::span<const double> part(const Recording& r, const std::vector<double>& signal,
                                    double from, double to) {
  const auto first = static_cast<std::size_t>(from * r.rate);
  return {signal.data() + first, static_cast<std::size_t>((to - from) * r.rate)};
}

inline double mean(std::span<const double> x) {
  double sum = 0;
  for (double v : x)
    sum += v;
  return sum / static_cast<double>(x.size());
}

inline double rms(std::span<const double> x) {
  const double m = mean(x);
  double sum = 0;
  for (double v : x)
    sum += (v - m) * (v - m);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

/// Between two samples.
inline double largest_step(std::span<const double> x) {
  double step = 0;
  for (std::size_t i = 1; i < x.size(); ++i)
    step = std::max(step, std::abs(x[i] - x[i - 1]));
  return step;
}

/// Windowed Fourier sum at one frequency, scaled to a sine's amplitude (4-term Blackman-Harris).
inline Complex component(std::span<const double> x, double rate, double frequency) {
  const double size = static_cast<double>(x.size()), m = mean(x);
  Complex sum = 0;
  const Complex turn = tactus::math::polar(1.0, -2 * std::numbers::pi * frequency / rate);
  const Complex step = tactus::math::polar(1.0, 2 * std::numbers::pi / size);
  Complex phase = 1, window_phase = 1;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double c1 = window_phase.real(), c2 = 2 * c1 * c1 - 1, c3 = 4 * c1 * c1 * c1 - 3 * c1;
    sum += (x[n] - m) * (0.35875 - 0.48829 * c1 + 0.14128 * c2 - 0.01168 * c3) * phase;
    phase *= turn;
    window_phase *= step;
  }
  return 2.0 * sum / (0.35875 * size);
}

/// Where a function with one maximum between two bounds has it, by golden-section search.
template <class F> double maximum_of(const F& f, double low, double high, int steps) {
  const double ratio = 0.6180339887498949;
  double a = high - ratio * (high - low), b = low + ratio * (high - low), fa = f(a), fb = f(b);
  for (int i = 0; i < steps; ++i) {
    const bool left = fa > fb;
    (left ? high : low) = left ? b : a;
    (left ? b : a) = left ? a : b;
    (left ? fb : fa) = left ? fa : fb;
    double& next = left ? a : b;
    next = left ? high - ratio * (high - low) : low + ratio * (high - low);
    (left ? fa : fb) = f(next);
  }
  return 0.5 * (low + high);
}

/// Pitch: the strongest bin between the bounds, refined.
inline double pitch(std::span<const double> x, double rate, double lowest, double highest) {
  const auto level = [&](double f) { return abs(component(x, rate, f)); };
  // The main lobe is eight bins wide: every second one will do.
  const double step = 2 * rate / static_cast<double>(x.size());
  double best = lowest, size = -1;
  for (double f = lowest; f < highest; f += step)
    if (const double here = level(f); here > size) {
      size = here;
      best = f;
    }
  return maximum_of(level, best - step, best + step, 24);
}

inline double cents(double a, double b) { return 1200 * std::log2(a / b); }

/// Level of a harmonic relative to the fundamental, dB.
inline double harmonic_db(std::span<const double> x, double rate, double f0, int n) {
  return 20 * std::log10(abs(component(x, rate, n * f0)) / abs(component(x, rate, f0)));
}

} // namespace tactus::reed::test
