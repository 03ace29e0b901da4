// Listeners that move, bodies that are exchanged and silenced: nothing clicks.
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// A plate with its lowest mode alone.
ModalTable one_mode() {
  ModalTable table = plate(0.32, 0.2, 0.005, 500, 6, 4);
  table.frequency_hz.resize(1);
  table.loss_factor = {2e-4};
  table.shape.resize(3 * table.vertex_m.size());
  return table;
}

struct Sounding : Rig {
  explicit Sounding(bool doppler = false) : Rig(kRate, one_mode(), Radiation::kModal) {
    options.doppler = doppler;
    settings.listener[0] = {0.4, 0, 0.3};
    rebuild(false);
    hit({0.01, 0.02, 0}, 1);
    static_cast<void>(run(4800));
  }
  [[nodiscard]] double tone() const { return body.model()->rate[0].imag() / (2 * kPi); }
  /// The listener is where `move` says at each call.
  template <class Move>
  std::vector<float> listen(std::size_t every, std::size_t frames, const Move& move,
                            float height = 0) {
    std::vector<float> sound;
    while (sound.size() < frames) {
      settings.listener[0] = move(static_cast<double>(sound.size()) / kRate);
      rebuild();
      append(sound, run(every, every, {}, std::vector<float>(every, height)).left);
    }
    return sound;
  }
};

Vec3 smooth_path(double t) { return {0.4 * std::cos(3 * t), 0.1, 0.3 + 0.5 * t}; }

void check_smooth_move(bool doppler, std::size_t every, std::size_t frames, double width_hz) {
  CAPTURE(doppler);
  CAPTURE(every);
  Sounding rig(doppler);
  const auto sound = rig.listen(every, frames, smooth_path);
  CHECK(off_tone_level_db(sound, rig.tone(), width_hz) < -60);
}

void check_jumps(bool doppler, std::size_t every, std::size_t frames) {
  CAPTURE(doppler);
  CAPTURE(every);
  Sounding rig(doppler);
  std::mt19937 random(5);
  const auto coordinate = [&](double reach) {
    return reach * (2 * static_cast<double>(random() % 1000) / 999 - 1);
  };
  const auto sound = rig.listen(every, frames, [&](double) {
    return Vec3{coordinate(2), coordinate(2), coordinate(1) + 0.02};
  });
  CHECK(off_tone_level_db(sound, rig.tone(), 1000) < -60);
}

} // namespace

TEST_CASE("a listener that moves is heard without a trace of the updates' rate, or of jumps") {
  check_smooth_move(false, 480, 4096, 300);
  check_jumps(true, 1000, 4096);
}

TEST_CASE("a listener that moves smoothly or by metres, through the plate too, does not click" *
          doctest::test_suite("slow")) {
  check_smooth_move(false, 8, 4096, 300);
  for (const std::size_t every : {48UL, 480UL, 777UL})
    check_smooth_move(every % 2 == 0, every, 16384, 150);
  for (const std::size_t every : {64UL, 1000UL, 1500UL})
    check_jumps(every > 50, every, 16384);
}

TEST_CASE("a listener that moves while something touches the body does not click either") {
  // Held by a soft spring: the body swings in a contact that lasts.
  Sounding rig;
  rig.options.driven = true;
  rig.body.set_options(rig.options);
  rig.body.set_striker({0.01, 0.01, 1e6, 0.3, 100, 1, 0, 1});
  static_cast<void>(rig.run(2048, 64, {}, std::vector<float>(2048, -1e-3F)));
  const auto sound = rig.listen(256, 4096, smooth_path, -1e-3F);
  CHECK(rig.body.contacts() == 1);
  CHECK(off_tone_level_db(sound, rig.tone(), 300) < -60);
}

TEST_CASE("a listener that has arrived gives the output of one that was always there") {
  Sounding moved, there;
  static_cast<void>(moved.listen(640, 6400, [](double t) { return Vec3{0.1, 0.1, 0.2 + 2 * t}; }));
  static_cast<void>(there.run(6400));
  for (Sounding* rig : {&moved, &there}) {
    rig->settings.listener[0] = {0.2, 0.1, 0.25};
    rig->rebuild();
    static_cast<void>(rig->run(3 * Glide::kSegment + 200));
  }
  CHECK(apart(there.run(4800).left, moved.run(4800).left) < 1e-4);
}

TEST_CASE("a listener that is moved in silence has arrived before the first strike") {
  const auto play = [](bool moved) {
    Rig rig(kRate, one_mode(), Radiation::kModal);
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
    const double tone = rig.tone();
    std::vector<float> sound;
    const auto run = [&](std::size_t frames) { append(sound, rig.run(frames).left); };
    const auto exchange = [&] { rig.exchange(std::make_shared<const LoadedTable>(one_mode())); };
    run(2000);
    if (change != kLoad && change != kThriceLoaded)
      rig.body.apply(Reset{});
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
    run(2400);
    CHECK(off_tone_level_db(std::span(sound).first(4096), tone, 1000) < -60);
    // It takes no longer than the release and the sound's way: 0.6 m are 84 samples.
    CHECK(loudest(std::span(sound).subspan(changed + ModeBank::kRelease + 201)) <
          1e-4 * loudest(sound));
  }
}

TEST_CASE("glides and fade-outs give the same bits in blocks of any size") {
  check_same_bits(
      [](std::size_t block) {
        Sounding rig(true);
        std::vector<float> sound;
        const auto run = [&](std::size_t frames) { append(sound, rig.run(frames, block).left); };
        for (int i = 0; i < 6; ++i) {
          rig.settings.listener[0] = {0.4, 0.1 * i, 0.3};
          rig.rebuild();
          run(300);
        }
        rig.body.apply(Reset{});
        run(100);
        rig.body.set_striker({0.01, 0.01, 1e6, 0.3, 1e4, 1.5, 0, 1}); // stays for milliseconds
        rig.hit({0.01, 0.02, 0}, 0.1);
        run(500);
        rig.exchange(std::make_shared<const LoadedTable>(one_mode()));
        run(1500);
        return sound;
      },
      {1, 7, 50, 100, 1500});
}
