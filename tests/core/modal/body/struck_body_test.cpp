// What a struck body sounds like, by the laws of linear vibration: momentum, frequencies and decay,
// reciprocity, superposition; the same bits in any blocks; nothing but finite numbers.
#include "core/modal/body/struck_body.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

TEST_CASE(
    "the coupled strike has the same impulse at every sample rate, and it is in the force output") {
  std::vector<double> impulses;
  for (const double rate : {44100.0, 48000.0, 96000.0}) {
    Rig rig(rate);
    rig.hit({0.05, 0.03, 0}, 1.4);
    impulses.push_back(impulse(rig.run(4800), rate));
    // Between momentum of a ball that stays and of one that returns as it came.
    CHECK(impulses.back() > 0.0071 * 1.4);
    CHECK(impulses.back() < 2 * 0.0071 * 1.4);
  }
  CHECK(impulses[1] == approx(impulses[0]).epsilon(0.005));
  CHECK(impulses[2] == approx(impulses[0]).epsilon(0.005));
}

TEST_CASE("the modes ring at the table's frequencies and lose 60 dB in their decay times") {
  Rig rig;
  rig.hit({0.051, 0.033, 0}, 1);
  static_cast<void>(rig.run(4800));
  const BodyModel& model = *rig.body.model();
  const auto early = rig.run(24000), late = rig.run(24000);
  for (std::size_t k = 0; k < 6; ++k) {
    const auto s = model.rate[k];
    const auto a = amplitude(early.left, s), b = amplitude(late.left, s);
    if (abs(a) < 1e-7)
      continue; // a mode that the listener's place does not move
    const auto expected = exp(s * 0.5);
    CAPTURE(k);
    // Turned by the frequency's error times half a second: 0.05 Hz would be 0.16 radians.
    CHECK(std::abs(arg(b / a / expected)) < 0.03);
    CHECK(std::log(abs(b / a)) == approx(s.real() * 0.5).epsilon(0.01));
  }
}

TEST_CASE("exchanging strike and pick-up changes nothing (reciprocity)") {
  const Vec3 a{0.07, 0.02, 0.0025}, b{-0.03, 0.051, 0.0025};
  const auto response = [&](const Vec3& from, const Vec3& to) {
    Rig rig;
    rig.settings.listener[0] = to;
    rig.rebuild(false);
    rig.set_point(from);
    std::vector<float> force(4800, 0.0F);
    force[10] = 1;
    return rig.run(4800, 64, force).left;
  };
  CHECK(apart(response(a, b), response(b, a)) < 1e-6);
}

TEST_CASE("four listeners give the output of each alone, in a contact and after it") {
  const Vec3 positions[] = {
      {0.051, 0.043, 0.1}, {-0.037, 0.021, 0.1}, {0.011, -0.05, 0.2}, {-0.1, 0.02, 0.3}};
  const auto play = [&](std::size_t listeners, const Vec3& first) {
    Rig rig(kRate, plate(), Radiation::kModal);
    rig.settings.listeners = listeners;
    std::copy(std::begin(positions), std::end(positions), rig.settings.listener.begin());
    if (listeners == 1)
      rig.settings.listener[0] = first;
    rig.rebuild(false);
    rig.hit({0.05, 0.03, 0}, 1);
    std::array<std::vector<float>, 4> output;
    std::array<float, 64> silence{}, contact{};
    std::array<std::array<float, 64>, 4> block{};
    for (int n = 0; n < 40; ++n) {
      const std::array<std::span<float>, 4> out{block[0], block[1], block[2], block[3]};
      rig.body.process<float>(silence, silence, out, contact);
      for (std::size_t l = 0; l < 4; ++l)
        output[l].insert(output[l].end(), block[l].begin(), block[l].end());
    }
    return output;
  };
  const auto together = play(4, {});
  for (std::size_t l = 0; l < 4; ++l) {
    const auto alone = play(1, positions[l]);
    CHECK(apart(alone[0], together[l]) <= 1e-5);
    CHECK(alone[1] == alone[0]);
    CHECK(loudest(alone[2]) == 0);
  }
}

TEST_CASE("the sound of strikes, forces and a hand has the same bits in blocks of any size") {
  struct Case {
    ModalTable table;
    Radiation radiation;
    bool coupled;
  };
  const ModalTable in_single = many_modes_table(ContactModes::kMaxModesInDouble + 188);
  for (const Case& c : {Case{plate(), Radiation::kNone, true},
                        {plate(), Radiation::kNone, false},
                        {free_plate(), Radiation::kModal, true},
                        {in_single, Radiation::kNone, true}})
    check_same_bits(
        [&](std::size_t block) {
          std::vector<float> force(2400, 0.0F), height(2400, 0.01F);
          for (std::size_t n = 0; n < 300; ++n) {
            force[700 + n] = 0.3F;
            height[1500 + n] = -1e-6F * static_cast<float>(n % 37);
          }
          Rig rig(kRate, c.table, c.radiation);
          rig.options.coupled = c.coupled;
          rig.options.driven = true;
          static_cast<void>(rig.run(64, block));
          rig.hit({0.03, 0.02, 0}, 1);
          rig.hit({-0.05, 0.05, 0}, 0.5);
          auto output = rig.run(2400, block, force, height);
          append(output.left, output.contact);
          return output.left;
        },
        {1, 7, 100, 2400});
}

TEST_CASE("a gain that is set in silence holds from the first sample, and is smoothed in sound") {
  const auto play = [](double gain) {
    Rig rig;
    rig.options.gain = gain;
    rig.hit({0.05, 0.03, 0}, 1); // takes the options first
    return rig.run(2000).left;
  };
  const auto one = play(1), quiet = play(0.001);
  for (std::size_t n = 0; n < one.size(); ++n)
    CHECK(std::abs(1000 * static_cast<double>(quiet[n]) - static_cast<double>(one[n])) <=
          1e-5 * loudest(one));
  // 40 dB less while it rings: half a percent of the distance a sample.
  Rig rig, loud;
  for (Rig* each : {&rig, &loud}) {
    each->hit({0.05, 0.03, 0}, 1);
    static_cast<void>(each->run(4800));
  }
  rig.options.gain = 0.01;
  rig.body.set_options(rig.options);
  const auto changing = rig.run(2000).left, steady = loud.run(2000).left;
  double gain = 1;
  for (std::size_t n = 0; n < steady.size(); ++n) {
    gain += 0.005 * (0.01 - gain);
    const double expected = gain * static_cast<double>(steady[n]);
    // Modes below 1e-8 of full scale rest sooner where the gain is less.
    CHECK(std::abs(static_cast<double>(changing[n]) - expected) < 1e-4 * std::abs(expected) + 1e-8);
  }
}

TEST_CASE("absurd forces and heights, at any block size and rate, stay finite") {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                  infinity = std::numeric_limits<float>::infinity();
  std::mt19937 random(8);
  for (const double rate : {8000.0, 12345.6, 48000.0, 384000.0}) {
    Rig rig(rate);
    rig.options.driven = true;
    rig.body.set_options(rig.options);
    for (int round = 0; round < 20; ++round) {
      std::vector<float> force(512), height(512);
      for (std::size_t n = 0; n < force.size(); ++n) {
        const auto pick = random() % 8;
        force[n] = pick == 0   ? nan
                   : pick == 1 ? infinity
                   : pick == 2 ? 1e30F
                               : static_cast<float>(random() % 1000) - 500;
        height[n] = pick == 3   ? -infinity
                    : pick == 4 ? nan
                                : 1e-3F * (static_cast<float>(random() % 100) - 50);
      }
      if (round % 3 == 0)
        rig.hit({0.1, 0.1, 0.1}, 50);
      const auto output = rig.run(512, 1 + random() % 512, force, height);
      CHECK((is_finite(output.left) && is_finite(output.right) && is_finite(output.contact)));
    }
  }
}
