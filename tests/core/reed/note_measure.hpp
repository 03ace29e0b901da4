#pragma once

#include "core/dsp/complex.hpp"
#include "tests/core/reed/reference_transform.hpp"
#include "tests/core/reed/render.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <span>
#include <vector>

/// What a note sounds like, in numbers; for the tests and for bench/realism_reed.
namespace tactus::reed::test {

/// Amplitudes of a signal's partials under a four-term Blackman-Harris window, whose main lobe is
/// eight bins wide and whose side lobes lie below -92 dB.
class Spectrum {
public:
  /// The first samples of signal that fill a power of two, at most 2^15.
  Spectrum(std::span<const double> signal, double rate) {
    std::size_t size = std::size_t{1} << 15;
    while (size > signal.size())
      size /= 2;
    spacing_ = rate / static_cast<double>(size);
    const std::vector<double>& window = window_of(size);
    const double middle = mean(signal.first(size));
    std::vector<double> work(size);
    for (std::size_t n = 0; n < size; ++n)
      work[n] = (signal[n] - middle) * window[n];
    std::vector<Complex> bins(size / 2 + 1);
    reference::RadixTwo transform;
    transform.prepare(size);
    transform.forward(work, bins);
    amplitude_.resize(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k)
      amplitude_[k] = abs(bins[k]) * 2 / (0.35875 * static_cast<double>(size));
  }

  struct Peak {
    double frequency_hz = 0, amplitude = 0;
  };
  /// The largest bin between two frequencies, refined by a parabola through decibels.
  [[nodiscard]] Peak peak(double low_hz, double high_hz) const {
    const std::size_t first = bin(low_hz), last = bin(high_hz);
    std::size_t at = first;
    for (std::size_t k = first; k <= last; ++k)
      if (amplitude_[k] > amplitude_[at])
        at = k;
    const double left = std::log(amplitude_[at - 1] + 1e-300),
                 here = std::log(amplitude_[at] + 1e-300),
                 in_register = std::log(amplitude_[at + 1] + 1e-300),
                 curvature = left - 2 * here + in_register;
    const double shift =
        curvature < 0 ? std::clamp(0.5 * (left - in_register) / curvature, -0.5, 0.5) : 0.0;
    return {(static_cast<double>(at) + shift) * spacing_,
            std::exp(here - 0.25 * (left - in_register) * shift)};
  }

  /// The strongest partial farther than six bins and `spread` (relative) from every harmonic of f0,
  /// from 30 Hz to 20 kHz: what can be heard.
  [[nodiscard]] Peak inharmonic(double f0, double spread = 0.004) const {
    Peak strongest;
    for (std::size_t k = bin(30); k < bin(20e3); ++k) {
      const double f = static_cast<double>(k) * spacing_, n = std::round(f / f0);
      const double guard_band = std::min(0.4 * f0, std::max(6 * spacing_, spread * f));
      const bool harmonic = n >= 1 && std::abs(f - n * f0) < guard_band;
      if (!harmonic && amplitude_[k] > strongest.amplitude)
        strongest = {f, amplitude_[k]};
    }
    return strongest;
  }

  /// Centre of the power spectrum above 20 Hz.
  [[nodiscard]] double centroid_hz() const {
    double power = 0, moment = 0;
    for (std::size_t k = bin(20); k < amplitude_.size(); ++k) {
      const double square = amplitude_[k] * amplitude_[k];
      power += square;
      moment += square * static_cast<double>(k) * spacing_;
    }
    return power > 0 ? moment / power : 0;
  }

  /// Pitch near the one meant (within 60 cents): that of the partial among the first ten that fixes
  /// it best.
  [[nodiscard]] double pitch_near(double expected_hz) const {
    Peak best;
    for (int n = 1; n <= 10; ++n) {
      const double centre = n * expected_hz, reach = std::min(0.035 * centre, 0.4 * expected_hz);
      const Peak found = peak(centre - reach, centre + reach);
      const double weight = found.amplitude * std::sqrt(n);
      if (weight > best.amplitude)
        best = {found.frequency_hz / n, weight};
    }
    return best.frequency_hz;
  }

private:
  [[nodiscard]] std::size_t bin(double frequency_hz) const {
    return std::clamp(static_cast<std::size_t>(std::max(0.0, frequency_hz) / spacing_),
                      std::size_t{1}, amplitude_.size() - 2);
  }
  static const std::vector<double>& window_of(std::size_t size) {
    static std::map<std::size_t, std::vector<double>> windows;
    std::vector<double>& window = windows[size];
    if (window.empty())
      for (std::size_t n = 0; n < size; ++n) {
        const double turn =
            2 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(size);
        window.push_back(0.35875 - 0.48829 * std::cos(turn) + 0.14128 * std::cos(2 * turn) -
                         0.01168 * std::cos(3 * turn));
      }
    return window;
  }
  double spacing_ = 1;
  std::vector<double> amplitude_;
};

/// One stretch of a note.
struct NoteMeasure {
  double frequency_hz = 0;
  double cents = 0;         // from the pitch meant
  double inharmonic_db = 0; // strongest tone that is no harmonic, relative to the strongest partial
  double inharmonic_hz = 0;
  double first_db = -300; // first harmonic of the bore pressure, relative to its strongest partial
  double rms = 0, bore_rms = 0;
  double centroid_hz = 0;
  std::array<double, 10> harmonics{}; // dB, relative to the strongest of them

  /// It sounds, within half a semitone of the note meant, in its register.
  [[nodiscard]] bool in_register() const {
    return bore_rms > 20 && std::abs(cents) < 50 && first_db > -20;
  }
};

/// Measures what sounds between two times, s; at least 2^14 samples for notes below 150 Hz.
inline NoteMeasure measure_note(const Recording& r, double expected_hz, double from, double to,
                                double spread = 0.004) {
  NoteMeasure note;
  const auto sound = part(r, r.sound, from, to), bore = part(r, r.bore_pressure, from, to);
  note.rms = rms(sound);
  note.bore_rms = rms(bore);
  if (!(note.rms > 1e-9))
    return note;
  const Spectrum spectrum(sound, r.rate), inside(bore, r.rate);
  const double nyquist = 0.5 * r.rate;
  note.frequency_hz = spectrum.pitch_near(expected_hz);
  note.cents = cents(note.frequency_hz, expected_hz);
  const auto decibels = [](double a, double b) { return 20 * std::log10((a + 1e-300) / b); };
  const double strongest = spectrum.peak(30, nyquist).amplitude;
  const Spectrum::Peak inharmonic = spectrum.inharmonic(note.frequency_hz, spread);
  note.inharmonic_db = decibels(inharmonic.amplitude, strongest);
  note.inharmonic_hz = inharmonic.frequency_hz;
  const double f = note.frequency_hz;
  note.first_db =
      decibels(inside.peak(0.97 * f, 1.03 * f).amplitude, inside.peak(30, nyquist).amplitude);
  note.centroid_hz = spectrum.centroid_hz();
  double top = 0;
  for (std::size_t n = 0; n < note.harmonics.size(); ++n) {
    const double h = static_cast<double>(n + 1);
    note.harmonics[n] = spectrum.peak((h - 0.25) * f, (h + 0.25) * f).amplitude;
    top = std::max(top, note.harmonics[n]);
  }
  for (double& h : note.harmonics)
    h = decibels(h, top);
  return note;
}

/// Running rms over one period of `frequency_hz`, but at least 8 ms, centred; one value a sample.
inline std::vector<double> envelope(std::span<const double> x, double rate, double frequency_hz) {
  const auto length = static_cast<std::size_t>(rate * std::max(1 / frequency_hz, 8e-3));
  std::vector<double> sum(x.size() + 1, 0.0), level(x.size());
  for (std::size_t n = 0; n < x.size(); ++n)
    sum[n + 1] = sum[n] + x[n] * x[n];
  for (std::size_t n = 0; n < x.size(); ++n) {
    const std::size_t low = n > length / 2 ? n - length / 2 : 0,
                      high = std::min(x.size(), n + (length + 1) / 2);
    level[n] = std::sqrt((sum[high] - sum[low]) / static_cast<double>(length));
  }
  return level;
}

/// Seconds from the recording's beginning until the sound's envelope first reaches that rms; the
/// recording's length if it never does.
inline double time_to(const Recording& r, double frequency_hz, double level) {
  const std::vector<double> loudness = envelope(r.sound, r.rate, frequency_hz);
  const auto at =
      std::find_if(loudness.begin(), loudness.end(), [&](double here) { return here >= level; });
  return static_cast<double>(at - loudness.begin()) / r.rate;
}

/// The worst of overlapping frames (0.34 s at 48 kHz) of a swelling note, of those louder than
/// -30 dB of the loudest, and so the frame before: foreign tone and distance from the pitch.
struct SwellMeasure {
  double inharmonic_db = -300, inharmonic_at = 0, cents = 0;
  int frames = 0, wrong_register = 0; // measured; not in the note's register
};
inline SwellMeasure measure_swell(const Recording& r, double expected_hz) {
  const double frame = 16384 / r.rate;
  const double length = static_cast<double>(r.sound.size()) / r.rate;
  std::vector<double> loudness;
  for (double t = 0; t + frame < length; t += frame / 2)
    loudness.push_back(rms(part(r, r.sound, t, t + frame)));
  SwellMeasure worst;
  if (loudness.empty())
    return worst;
  const double top = *std::max_element(loudness.begin(), loudness.end());
  for (std::size_t i = 1; i < loudness.size(); ++i) {
    if (loudness[i] < 0.0316 * top || loudness[i - 1] < 0.0316 * top)
      continue;
    const double t = static_cast<double>(i) * frame / 2;
    const NoteMeasure note = measure_note(r, expected_hz, t, t + frame, 0.01);
    ++worst.frames;
    worst.wrong_register += note.in_register() ? 0 : 1;
    worst.cents = std::max(worst.cents, std::abs(note.cents));
    if (note.inharmonic_db > worst.inharmonic_db) {
      worst.inharmonic_db = note.inharmonic_db;
      worst.inharmonic_at = t;
    }
  }
  return worst;
}

} // namespace tactus::reed::test
