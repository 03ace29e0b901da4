// Listeners that move, bodies that are exchanged and silenced: nothing clicks.
#include "core/modal/body/struck_body.hpp"
#include "tests/core/modal/rig.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kPi = std::numbers::pi, kRate = 48000;

/// A plate with its lowest mode alone.
ModalTable one_mode() {
  ModalTable table = plate(0.32, 0.2, 0.005, 500, 16, 10);
  table.frequency_hz.resize(1);
  table.loss_factor = {2e-4};
  table.shape.resize(3 * table.vertex_m.size());
  return table;
}

/// Energy further than `width` Hz from the tone against all of it, in dB, under a window of
/// Blackman and Harris over the whole sound.
double off_tone_level_db(std::span<const float> sound, double tone_hz, double width_hz) {
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

double tone_of(const Rig& rig) { return rig.body.model()->rate[0].imag() / (2 * kPi); }

/// A minute change of place at each call.
template <class Move>
std::vector<float> listen(Rig& rig, std::size_t every, std::size_t frames, const Move& move,
                          const std::vector<float>& height = {}) {
  std::vector<float> sound;
  while (sound.size() < frames) {
    rig.settings.listener[0] = move(static_cast<double>(sound.size()) / kRate);
    rig.rebuild();
    const auto output = rig.run(every, every, {}, std::vector<float>(height));
    sound.insert(sound.end(), output.left.begin(), output.left.end());
  }
  return sound;
}

struct Sounding : Rig {
  explicit Sounding(bool doppler = false) : Rig(kRate, one_mode()) {
    settings.radiation = Radiation::kModal;
    options.doppler = doppler;
    settings.listener[0] = {0.4, 0, 0.3};
    rebuild(false);
    hit({0.01, 0.02, 0}, 1);
    static_cast<void>(run(4800));
  }
};

} // namespace

TEST_CASE("a listener that moves smoothly is heard without a trace of the updates' rate" *
          doctest::skip(kSanitized)) {
  bool doppler = true;
  for (const std::size_t every : {8UL, 48UL, 64UL, 480UL, 777UL}) {
    doppler = !doppler;
    CAPTURE(doppler);
    CAPTURE(every);
    Sounding rig(doppler);
    const auto sound = listen(rig, every, every == 8 ? 4096 : 16384, [](double t) {
      return Vec3{0.4 * std::cos(3 * t), 0.1, 0.3 + 0.5 * t};
    });
    CHECK(off_tone_level_db(sound, tone_of(rig), every == 8 ? 300 : 150) < -60);
  }
}

TEST_CASE("a listener that jumps by metres, through the plate as well, does not click" *
          doctest::skip(kSanitized)) {
  bool doppler = true;
  for (const std::size_t every : {48UL, 64UL, 1000UL, 1500UL}) {
    doppler = !doppler;
    CAPTURE(doppler);
    CAPTURE(every);
    Sounding rig(doppler);
    std::mt19937 random(5);
    const auto coordinate = [&](double reach) {
      return reach * (2 * static_cast<double>(random() % 1000) / 999 - 1);
    };
    const auto sound = listen(rig, every, 16384, [&](double) {
      return Vec3{coordinate(2), coordinate(2), coordinate(1) + 0.02};
    });
    CHECK(off_tone_level_db(sound, tone_of(rig), 1000) < -60);
  }
}

TEST_CASE("a listener that moves while something touches the body does not click either" *
          doctest::skip(kSanitized)) {
  // Held by a soft spring: the body swings in a contact that lasts.
  const auto play = [](bool moves) {
    Sounding rig;
    rig.options.driven = true;
    rig.body.set_options(rig.options);
    rig.body.set_striker({0.01, 0.01, 1e6, 0.3, 100, 1, 0, 1});
    const std::vector<float> pressed(64, -1e-3F);
    static_cast<void>(rig.run(2048, 64, {}, std::vector<float>(2048, -1e-3F)));
    std::mt19937 random(5);
    auto sound = listen(
        rig, 64, 16384,
        [&](double t) {
          return moves ? Vec3{0.4 * std::cos(3 * t), 0.1, 0.3 + 0.5 * t} : Vec3{0.4, 0, 0.3};
        },
        pressed);
    CHECK(rig.body.contacts() == 1);
    return std::pair(std::move(sound), tone_of(rig));
  };
  const auto [still, tone] = play(false);
  CHECK(off_tone_level_db(still, tone, 150) < -60);
  CHECK(off_tone_level_db(play(true).first, tone, 150) < -60);
}

TEST_CASE("a listener that has arrived gives the output of one that was always there") {
  Sounding rig, there;
  static_cast<void>(listen(rig, 64, 6400, [](double t) { return Vec3{0.1, 0.1, 0.2 + 2 * t}; }));
  static_cast<void>(there.run(6400));
  for (Rig* each : {static_cast<Rig*>(&rig), static_cast<Rig*>(&there)}) {
    each->settings.listener[0] = {0.2, 0.1, 0.25};
    each->rebuild();
    static_cast<void>(each->run(3 * Glide::kSegment + 200));
  }
  const auto a = rig.run(4800).left, b = there.run(4800).left;
  float loudest = 0, difference = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    loudest = std::max(loudest, std::abs(b[n]));
    difference = std::max(difference, std::abs(a[n] - b[n]));
  }
  CHECK(difference < 1e-4F * loudest);
}

TEST_CASE("a listener that is moved in silence has arrived before the first strike") {
  const auto play = [](bool moved) {
    Rig rig(kRate, one_mode());
    rig.settings.radiation = Radiation::kModal;
    const Vec3 position{0.1, 0.2, 0.6};
    rig.settings.listener[0] = moved ? Vec3{0, 0, 2} : position;
    rig.rebuild(false);
    static_cast<void>(rig.run(640));
    rig.settings.listener[0] = position;
    rig.rebuild();
    rig.hit({0.01, 0.02, 0}, 1);
    return rig.run(4800).left;
  };
  CHECK(play(true) == play(false));
}

TEST_CASE("reset and load do not click") {
  enum Change { kReset, kLoad, kBoth, kThriceLoaded, kRetunedAfterReset, kStruckAfterReset };
  for (const Change change :
       {kReset, kLoad, kBoth, kThriceLoaded, kRetunedAfterReset, kStruckAfterReset}) {
    CAPTURE(static_cast<int>(change));
    Sounding rig;
    const double tone = tone_of(rig);
    std::vector<float> sound;
    const auto run = [&](std::size_t frames) {
      const auto output = rig.run(frames, 64).left;
      sound.insert(sound.end(), output.begin(), output.end());
    };
    const auto exchange = [&] {
      rig.loaded = std::make_shared<const LoadedTable>(one_mode());
      rig.rebuild(false);
    };
    run(8000);
    if (change != kLoad && change != kThriceLoaded)
      rig.body.reset();
    if (change == kLoad || change == kBoth)
      exchange();
    if (change == kThriceLoaded)
      for (int i = 0; i < 3; ++i) {
        exchange();
        run(100);
      }
    if (change == kRetunedAfterReset) {
      run(300);
      rig.settings.size = 1.0001; // the same body in all but name
      rig.rebuild();
    }
    if (change == kStruckAfterReset) { // so softly that it is a contact and no sound
      run(300);
      rig.body.set_striker({1e-6, 0.01, 1e6, 0.3, 1, 1, 0, 1});
      rig.hit({0.01, 0.02, 0}, 1e-5);
    }
    const std::size_t changed = sound.size();
    run(8384);
    CHECK(off_tone_level_db(std::span(sound).first(16384), tone, 1000) < -60);
    // It takes no longer than the release and the sound's way: 0.6 m are 84 samples.
    float left = 0, loudest = 0;
    for (std::size_t n = 0; n < sound.size(); ++n) {
      loudest = std::max(loudest, std::abs(sound[n]));
      if (n > changed + ModeBank::kRelease + 200)
        left = std::max(left, std::abs(sound[n]));
    }
    CHECK(left < 1e-4F * loudest);
  }
}

TEST_CASE("glides and fade-outs give the same bits in blocks of any size") {
  const auto play = [](std::size_t block) {
    Sounding rig(true);
    std::vector<float> sound;
    const auto run = [&](std::size_t frames) {
      const auto output = rig.run(frames, block).left;
      sound.insert(sound.end(), output.begin(), output.end());
    };
    for (int i = 0; i < 6; ++i) {
      rig.settings.listener[0] = {0.4, 0.1 * i, 0.3};
      rig.rebuild();
      run(300);
    }
    rig.body.reset();
    run(100);
    rig.body.set_striker({0.01, 0.01, 1e6, 0.3, 1e4, 1.5, 0, 1}); // stays for milliseconds
    rig.hit({0.01, 0.02, 0}, 0.1);
    run(500);
    rig.loaded = std::make_shared<const LoadedTable>(one_mode());
    rig.rebuild(false);
    run(1500);
    return sound;
  };
  const auto reference = play(64);
  for (const std::size_t block : {1UL, 7UL, 50UL, 100UL, 1500UL})
    CHECK(play(block) == reference);
}
