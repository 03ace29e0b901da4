#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/body/struck_body.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

/// What the tests of struck bodies share: a body in a harness, and measures of what it sounds like.
namespace tactus::test {

using tactus::Complex;

using namespace modal;

inline constexpr double kPi = std::numbers::pi, kRate = 48000;

/// Settings of a body whose own velocities are heard.
inline BodySettings no_radiation() {
  BodySettings settings;
  settings.radiation = Radiation::kNone;
  return settings;
}

struct Output {
  std::vector<float> left, right, contact;
};

/// A body in a harness: the same table, struck and heard.
struct Rig {
  explicit Rig(double sample_rate = kRate, ModalTable table = plate(),
               Radiation radiation = Radiation::kNone) {
    settings.sample_rate = sample_rate;
    settings.radiation = radiation;
    settings.listener = {Vec3{0.051, 0.043, 0.1}, Vec3{-0.037, 0.021, 0.1}};
    loaded = std::make_shared<const LoadedTable>(std::move(table));
    body.prepare(sample_rate);
    options.gain = 1;
    options.cull_db = 200;
    rebuild(false);
  }
  void rebuild(bool same = true) {
    body.set_options(options);
    body.publish(std::make_unique<BodyModel>(loaded, settings), same);
    body.adopt();
  }
  void exchange(std::shared_ptr<const LoadedTable> another) {
    loaded = std::move(another);
    rebuild(false);
  }
  [[nodiscard]] Hit at(Vec3 position, double speed) const {
    const SurfacePoint point = body.model()->nearest(position);
    return {point, point.normal, speed};
  }
  void hit(Vec3 position, double speed) {
    body.set_options(options);
    body.hit(at(position, speed));
  }
  void set_point(Vec3 position) {
    const SurfacePoint point = body.model()->nearest(position);
    body.apply(ForcePoint{point, point.normal});
  }
  Output run(std::size_t frames, std::size_t block = 64, std::vector<float> force = {},
             std::vector<float> height = {}) {
    force.resize(frames);
    height.resize(frames);
    Output output{std::vector<float>(frames), std::vector<float>(frames),
                  std::vector<float>(frames)};
    for (std::size_t n = 0; n < frames; n += block) {
      const std::size_t count = std::min(block, frames - n);
      const auto part = [&](std::vector<float>& x) { return std::span(x).subspan(n, count); };
      const std::array<std::span<float>, 2> out{part(output.left), part(output.right)};
      body.process<float>(part(force), part(height), out, part(output.contact));
    }
    return output;
  }
  /// A surface that rubs with constant force and velocity.
  std::pair<std::vector<float>, std::vector<float>> rub(float press, float speed,
                                                        std::size_t frames) {
    std::vector<float> none(frames), normal(frames, press), velocity(frames, speed), sound(frames),
        contact(frames), friction(frames);
    const std::array<std::span<float>, 1> out{sound};
    body.process<float>(none, none, out, contact, {normal, velocity, friction});
    return {sound, friction};
  }
  /// Displacement and velocity, mass-normalised, of a mode of the table in the bank.
  [[nodiscard]] std::pair<double, double> motion(std::size_t mode) {
    flush();
    const BodyModel& model = *body.model();
    const std::size_t i = model.index_of[mode];
    const double q = model.bank.state(i).imag() / model.rate[i].imag();
    return {q, model.bank.state(i).real() + model.rate[i].real() * q};
  }
  /// States are brought to the present.
  void flush() { const_cast<BodyModel*>(body.model())->bank.flush_pending(); }

  BodySettings settings;
  StruckBody::Options options;
  std::shared_ptr<const LoadedTable> loaded;
  StruckBody body;
};

inline double impulse(const Output& output, double rate = kRate) {
  double sum = 0;
  for (const float f : output.contact)
    sum += static_cast<double>(f) / rate;
  return sum;
}

inline double loudest(std::span<const float> sound) {
  float maximum = 0;
  for (const float x : sound)
    maximum = std::max(maximum, std::abs(x));
  return static_cast<double>(maximum);
}

inline bool is_finite(std::span<const float> sound) {
  return std::all_of(sound.begin(), sound.end(), [](float x) { return std::isfinite(x); });
}

/// The largest difference of two sounds over the loudest sample of the first; NaN for silence.
inline double apart(std::span<const float> expected, std::span<const float> found) {
  REQUIRE(expected.size() == found.size());
  float difference = 0;
  for (std::size_t n = 0; n < expected.size(); ++n)
    difference = std::max(difference, std::abs(expected[n] - found[n]));
  return static_cast<double>(difference) / loudest(expected);
}

/// 10 log10 of the energy of a difference over that of the sound.
inline double difference_db(std::span<const float> expected, std::span<const float> found) {
  double difference = 0, whole = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    difference += std::pow(static_cast<double>(expected[n] - found[n]), 2);
    whole += std::pow(static_cast<double>(expected[n]), 2);
  }
  return 10 * std::log10(difference / whole + 1e-30);
}

inline double largest_step(std::span<const float> sound) {
  float step = 0;
  for (std::size_t n = 1; n < sound.size(); ++n)
    step = std::max(step, std::abs(sound[n] - sound[n - 1]));
  return static_cast<double>(step);
}

/// Amplitude of a decaying tone of rate s at the beginning of a sound: projection under Hann's
/// window.
inline Complex amplitude(std::span<const float> sound, Complex s, double rate = kRate) {
  Complex sum = 0, tone = 1;
  double weight = 0;
  const Complex pole = exp(s / rate);
  const double turn = 2 * kPi / static_cast<double>(sound.size());
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double window = 0.5 - 0.5 * std::cos(turn * static_cast<double>(n));
    sum += static_cast<double>(sound[n]) * window * conj(tone);
    weight += norm(tone) * window;
    tone = {tone.real() * pole.real() - tone.imag() * pole.imag(),
            tone.real() * pole.imag() + tone.imag() * pole.real()};
  }
  return 2.0 * sum / weight;
}

/// Energy further than `width` Hz from the tone against all of it below 8 kHz, in dB, under a
/// window of Blackman and Harris over the whole sound.
inline double off_tone_level_db(std::span<const float> sound, double tone_hz, double width_hz) {
  const auto count = static_cast<double>(sound.size());
  std::vector<double> windowed(sound.size());
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double u = 2 * kPi * static_cast<double>(n) / count;
    windowed[n] =
        static_cast<double>(sound[n]) *
        (0.35875 - 0.48829 * std::cos(u) + 0.14128 * std::cos(2 * u) - 0.01168 * std::cos(3 * u));
  }
  double far = 0, all = 0;
  // Bins a window's width apart miss nothing.
  const double step = 2 * kRate / count;
  for (double f = step; f < 8000; f += step) {
    // |sum of x e^(-j w n)|^2 by Goertzel's recursion (1958).
    const double twice = 2 * std::cos(2 * kPi * f / kRate);
    double last = 0, before = 0;
    for (const double x : windowed) {
      const double next = x + twice * last - before;
      before = last;
      last = next;
    }
    const double power = last * last + before * before - twice * last * before;
    all += power;
    if (std::abs(f - tone_hz) > width_hz)
      far += power;
  }
  return 10 * std::log10(far / all + 1e-30);
}

/// Spectrum of what arrives at a listener, per second: all through the samples, and where they
/// begin.
inline std::array<Complex, 2> spectrum(const Arrivals& arrivals, std::size_t motion, double hz,
                                       double rate) {
  std::vector<double> pressure(arrivals.samples() * BandLimit::kNodes);
  arrivals.find(motion, pressure);
  std::array<Complex, 2> sum{};
  for (std::size_t n = 0; n < arrivals.samples(); ++n)
    for (std::size_t m = 0; m < BandLimit::kNodes; ++m)
      sum[m == 0] += (m == 0 ? 1 : BandLimit::kGaussWeight[m - 1]) *
                     pressure[n * BandLimit::kNodes + m] *
                     tactus::math::polar(1., -2 * kPi * hz / rate *
                                                 (static_cast<double>(n) + BandLimit::kNode[m] -
                                                  static_cast<double>(BandLimit::kLatency)));
  return sum;
}

inline void append(std::vector<float>& sound, const std::vector<float>& more) {
  sound.insert(sound.end(), more.begin(), more.end());
}

/// What `play` makes with a stream that is cut into blocks of so many samples is the same to the
/// bit for each of these sizes.
template <class Play>
void check_same_bits(const Play& play, std::initializer_list<std::size_t> blocks) {
  const auto whole = play(64);
  CHECK(loudest(whole) > 0);
  for (const std::size_t block : blocks) {
    CAPTURE(block);
    CHECK(play(block) == whole);
  }
}

} // namespace tactus::test
