#pragma once

#include "core/footstep/ground.hpp"
#include "files/recipe.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

/// Plain grounds and what is measured on them: what a recipe's words do to the sound, each alone.
namespace tactus::test {

using namespace footstep;

inline Recipe recipe_of(const std::string& text) {
  Recipe recipe;
  INFO(text);
  REQUIRE(files::read_recipe(text, recipe) == "");
  return recipe;
}

inline std::unique_ptr<Ground> ground_of(const std::string& text, double rate = 48000,
                                         std::uint64_t seed = 1, double shoe = 1) {
  auto ground = std::make_unique<Ground>();
  ground->prepare(rate);
  ground->seed(seed);
  ground->set(recipe_of(text), shoe);
  return ground;
}

/// A plain floor of one linear contact and one mode, no step unlike another; `more` goes on in it.
inline std::string board(const std::string& more) {
  return "radiation 1\nfelt 1\n[solid]\nmodes 1\nfrequency 400\ndetune 0\nt60 0.5\nplace "
         "0\npatches 1\n"
         "exponent 1\nstiffness 1e4\ndissipation 0\nball 0\nvary_frequency 0\nvary_decay "
         "0\nvary_level 0\n" +
         more;
}

/// A rustle, which is as loud as its energy: nothing else sets it going but what `more` says.
inline std::string rustle(const std::string& more) {
  return "radiation 1\nfelt 1\n[rustle]\nattack 1e-4\ndecay 0.05\nheel 0\nball 0\nload 0\nrelease "
         "0\n"
         "vary_frequency 0\nvary_decay 0\nvary_level 0\n" +
         more;
}

inline SoleState heel_at(double speed) {
  SoleState sole;
  sole.heel_landing = speed;
  return sole;
}

inline double both(const Ground::Sound& sound) {
  return sound.heel_vibration + sound.ball_vibration;
}

/// The ground's motion from one state of the sole in the first sample and none after.
inline std::vector<double> vibration(Ground& ground, const SoleState& first, int samples = 4800) {
  std::vector<double> motion;
  motion.reserve(static_cast<std::size_t>(samples));
  for (int n = 0; n < samples; ++n)
    motion.push_back(both(ground.next(n == 0 ? first : SoleState{})));
  return motion;
}

inline double peak_amplitude(const std::vector<double>& sound) {
  double max_abs = 0;
  for (const double x : sound)
    max_abs = std::max(max_abs, std::abs(x));
  return max_abs;
}

/// The factor between two sounds of one shape; fails when they have not one shape.
inline double factor(const std::vector<double>& a, const std::vector<double>& b) {
  const double by = peak_amplitude(a) / peak_amplitude(b);
  double difference = 0;
  for (std::size_t n = 0; n < a.size(); ++n)
    difference = std::max(difference, std::abs(a[n] - by * b[n]));
  CHECK(difference < 1e-6 * peak_amplitude(a));
  return by;
}

/// Frequency from the times of rising zeros, and T60 from the peaks between them.
struct Tone {
  double frequency_hz, t60_s;
};
inline Tone tone_of(const std::vector<double>& x, double rate, double begin_s) {
  std::vector<double> zeros, peaks;
  double peak = 0;
  for (auto n = static_cast<std::size_t>(begin_s * rate) + 1; n < x.size(); ++n) {
    peak = std::max(peak, std::abs(x[n]));
    if (x[n - 1] <= 0 && x[n] > 0) {
      zeros.push_back((static_cast<double>(n) - x[n] / (x[n] - x[n - 1])) / rate);
      peaks.push_back(peak);
      peak = 0;
    }
  }
  REQUIRE(zeros.size() > 8);
  const double time = zeros.back() - zeros[1];
  return {static_cast<double>(zeros.size() - 2) / time,
          3 * std::numbers::ln10 * time / std::log(peaks[2] / peaks.back()) *
              (static_cast<double>(peaks.size() - 3) / static_cast<double>(peaks.size() - 2))};
}

inline double scatter(const std::vector<double>& values) {
  double sum = 0, square = 0;
  for (const double v : values) {
    sum += v / static_cast<double>(values.size());
    square += v * v / static_cast<double>(values.size());
  }
  return std::sqrt(square - sum * sum);
}

} // namespace tactus::test
