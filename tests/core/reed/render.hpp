#pragma once

#include "core/reed/instrument/instrument.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

/// Plays an instrument and measures what comes out, for the tests.
namespace tactus::reed::test {

struct Recording {
  double rate = 48000;
  std::vector<double> sound, theta, bore_pressure, flow;
};

/// Mouth pressure rises straight to its value within ramp_s and stays.
inline std::vector<double> ramp(double pressure, double seconds, double rate,
                                double ramp_s = 0.02) {
  std::vector<double> signal(static_cast<std::size_t>(seconds * rate));
  for (std::size_t n = 0; n < signal.size(); ++n)
    signal[n] = pressure * std::min(1.0, static_cast<double>(n) / (ramp_s * rate));
  return signal;
}

inline Recording play(Instrument& instrument, std::span<const double> pressure, double rate,
                      double reed_frequency = 0, double bore_frequency = 0) {
  Recording r;
  r.rate = rate;
  const std::size_t size = pressure.size();
  r.sound.resize(size);
  r.theta.resize(size);
  r.bore_pressure.resize(size);
  r.flow.resize(size);
  const std::vector<double> reed(size, reed_frequency), bore(size, bore_frequency);
  instrument.process<double>({pressure, reed, bore}, {r.sound, r.theta, r.bore_pressure, r.flow});
  return r;
}

inline Recording play(const Parameters& parameters, double pressure, double seconds,
                      double rate = 48000, double ramp_s = 0.02) {
  Instrument instrument;
  instrument.set(parameters);
  instrument.prepare(rate, 64);
  return play(instrument, ramp(pressure, seconds, rate, ramp_s), rate);
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

/// Windowed Fourier sum at one frequency, scaled to a sine's amplitude (4-term Blackman-Harris).
inline std::complex<double> component(std::span<const double> x, double rate, double frequency) {
  const double size = static_cast<double>(x.size()), m = mean(x);
  std::complex<double> sum = 0;
  const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * frequency / rate);
  const std::complex<double> step = std::polar(1.0, 2 * std::numbers::pi / size);
  std::complex<double> phase = 1, window_phase = 1;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double c1 = window_phase.real(), c2 = 2 * c1 * c1 - 1, c3 = 4 * c1 * c1 * c1 - 3 * c1;
    sum += (x[n] - m) * (0.35875 - 0.48829 * c1 + 0.14128 * c2 - 0.01168 * c3) * phase;
    phase *= turn;
    window_phase *= step;
  }
  return 2.0 * sum / (0.35875 * size);
}

/// Frequency of the strongest partial near a guess: maximum of the windowed Fourier sum, by
/// golden-section search within +-width.
inline double peak_near(std::span<const double> x, double rate, double guess, double width) {
  double low = guess - width, high = guess + width;
  const double ratio = 0.6180339887498949;
  double a = high - ratio * (high - low), b = low + ratio * (high - low);
  double fa = std::abs(component(x, rate, a)), fb = std::abs(component(x, rate, b));
  for (int i = 0; i < 24; ++i) {
    if (fa > fb) {
      high = b;
      b = a;
      fb = fa;
      a = high - ratio * (high - low);
      fa = std::abs(component(x, rate, a));
    } else {
      low = a;
      a = b;
      fa = fb;
      b = low + ratio * (high - low);
      fb = std::abs(component(x, rate, b));
    }
  }
  return 0.5 * (low + high);
}

/// Pitch: the strongest bin between the bounds, refined.
inline double pitch(std::span<const double> x, double rate, double lowest, double highest) {
  const double spacing = 0.5 * rate / static_cast<double>(x.size());
  // Resolution first on a decimated copy of the bins: the main lobe is eight bins wide.
  double best = lowest, size = -1;
  for (double f = lowest; f < highest; f += 4 * spacing) {
    const double here = std::abs(component(x, rate, f));
    if (here > size) {
      size = here;
      best = f;
    }
  }
  return peak_near(x, rate, best, 4 * spacing);
}

inline double cents(double a, double b) { return 1200 * std::log2(a / b); }

/// Level of a harmonic relative to the fundamental, dB.
inline double harmonic_db(std::span<const double> x, double rate, double f0, int n) {
  return 20 * std::log10(std::abs(component(x, rate, n * f0)) / std::abs(component(x, rate, f0)));
}

} // namespace tactus::reed::test
