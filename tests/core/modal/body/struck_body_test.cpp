#include "core/modal/body/struck_body.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kPi = std::numbers::pi;

/// Amplitude of a decaying tone of this rate in the sound from `from` on (projection on the pole).
std::complex<double> amplitude(std::span<const float> sound, std::complex<double> s, double rate) {
  std::complex<double> sum = 0;
  double weight = 0;
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double window =
        std::sin(kPi * static_cast<double>(n) / static_cast<double>(sound.size()));
    const auto tone = std::exp(s * (static_cast<double>(n) / rate));
    sum += static_cast<double>(sound[n]) * window * window * std::conj(tone);
    weight += std::norm(tone) * window * window;
  }
  return 2.0 * sum / weight;
}

} // namespace

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
    const auto a = amplitude(early.left, s, 48000), b = amplitude(late.left, s, 48000);
    if (std::abs(a) < 1e-7)
      continue; // a mode that the listener's place does not move
    const auto expected = std::exp(s * 0.5);
    CAPTURE(k);
    // Turned by the frequency's error times half a second: 0.05 Hz would be 0.16 radians.
    CHECK(std::abs(std::arg(b / a / expected)) < 0.03);
    CHECK(std::log(std::abs(b / a)) == approx(s.real() * 0.5).epsilon(0.01));
  }
}

TEST_CASE("levels() are the modes' output levels, by frequency, in contact and after") {
  CHECK(StruckBody().levels(4).empty());
  Rig rig;
  CHECK(rig.body.levels(3) == std::vector<double>(3, -120));
  rig.hit({0.06, 0.05, 0.1}, 1);
  rig.run(1);
  REQUIRE(rig.body.contacts() == 1);
  CHECK(rig.body.levels(1)[0] > -120);
  rig.run(4800);
  REQUIRE(rig.body.contacts() == 0);
  const auto levels = rig.body.levels(2);
  REQUIRE(levels.size() == 2);
  // A second of each mode alone, its decay in it allowed for.
  const Output output = rig.run(48000);
  const BodyModel& m = *rig.body.model();
  std::vector<std::complex<double>> rates(
      m.rate.begin(), m.rate.begin() + static_cast<std::ptrdiff_t>(m.audible_modes));
  std::sort(rates.begin(), rates.end(),
            [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); });
  for (std::size_t k = 0; k < 2; ++k) {
    CAPTURE(k);
    double loudest = 0; // of the listeners
    for (const auto* side : {&output.left, &output.right}) {
      std::complex<double> sum = 0;
      double weight = 0;
      for (std::size_t n = 0; n < side->size(); ++n) {
        const double t = static_cast<double>(n) / 48000;
        const double window = 1 - std::cos(2 * kPi * t);
        sum += window * static_cast<double>((*side)[n]) * std::polar(1.0, -rates[k].imag() * t);
        weight += window * std::exp(rates[k].real() * t);
      }
      loudest = std::max(loudest, 2 * std::abs(sum) / weight);
    }
    CHECK(levels[k] == approx(20 * std::log10(loudest)).epsilon(0.002));
  }
}

TEST_CASE("a strike on a nodal line leaves that mode silent") {
  Rig rig;
  rig.settings.listener[0] = {0.05, 0.03, 0.1};
  rig.rebuild(false);
  rig.hit({0.0, 0.03, 0}, 1); // the second mode along x has its node in the middle
  static_cast<void>(rig.run(480));
  const auto output = rig.run(24000);
  const BodyModel& model = *rig.body.model();
  const double loud = std::abs(amplitude(output.left, model.rate[model.index_of[0]], 48000));
  const double silent = std::abs(amplitude(output.left, model.rate[model.index_of[1]], 48000));
  CHECK(20 * std::log10(silent / loud) < -50);
}

TEST_CASE("exchanging strike and pick-up changes nothing (reciprocity)") {
  const Vec3 a{0.07, 0.02, 0.0025}, b{-0.03, 0.051, 0.0025};
  const auto response = [&](const Vec3& from, const Vec3& to) {
    Rig rig;
    rig.settings.listener[0] = to;
    rig.rebuild(false);
    const SurfacePoint at = rig.body.model()->nearest(from);
    rig.body.set_point(at, at.normal);
    std::vector<float> force(4800, 0.0F);
    force[10] = 1;
    return rig.run(4800, 64, force).left;
  };
  const auto there = response(a, b), back = response(b, a);
  float largest = 0, difference = 0;
  for (std::size_t n = 0; n < there.size(); ++n) {
    largest = std::max(largest, std::abs(there[n]));
    difference = std::max(difference, std::abs(there[n] - back[n]));
  }
  CHECK(difference < 1e-6F * largest);
}

TEST_CASE("four listeners give the output of each alone, in a contact and after it") {
  const Vec3 positions[] = {
      {0.051, 0.043, 0.1}, {-0.037, 0.021, 0.1}, {0.011, -0.05, 0.2}, {-0.1, 0.02, 0.3}};
  const auto play = [&](std::size_t listeners, const Vec3& first) {
    Rig rig;
    rig.settings.radiation = Radiation::kModal;
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
    float largest = 0, difference = 0;
    for (std::size_t n = 0; n < alone[0].size(); ++n) {
      largest = std::max(largest, std::abs(alone[0][n]));
      difference = std::max(difference, std::abs(alone[0][n] - together[l][n]));
    }
    CHECK(largest > 0);
    CHECK(difference <= 1e-5F * largest);
    CHECK(alone[1] == alone[0]);
    CHECK(alone[2] == std::vector<float>(alone[0].size(), 0.0F));
  }
}

TEST_CASE("the sound of strikes, forces and a hand has the same bits in blocks of any size") {
  std::vector<float> force(6000, 0.0F), height(6000, 0.01F);
  for (std::size_t n = 1500; n < 1700; ++n)
    force[n] = 0.3F;
  for (std::size_t n = 3000; n < 3300; ++n)
    height[n] = -1e-6F * static_cast<float>(n % 37);
  const auto play = [&](std::size_t block, bool coupled) {
    Rig rig;
    rig.options.coupled = coupled;
    rig.options.driven = true;
    rig.hit({0.03, 0.02, 0}, 1);
    rig.hit({-0.1, 0.05, 0}, 0.5);
    auto output = rig.run(6000, block, force, height);
    output.left.insert(output.left.end(), output.contact.begin(), output.contact.end());
    return output.left;
  };
  for (const bool coupled : {true, false}) {
    const auto reference = play(64, coupled);
    for (const std::size_t block : {1UL, 7UL, 16UL, 100UL, 1000UL, 4096UL})
      CHECK(play(block, coupled) == reference);
  }
}

TEST_CASE("a body of many modes, in single precision, gives the same bits too") {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  for (std::size_t k = 0; k < ContactModes::kMaxModesInDouble + 188; ++k) {
    table.frequency_hz.push_back(50 + 30 * static_cast<double>(k));
    table.decay_rate.push_back(1 + 0.02 * static_cast<double>(k));
  }
  const auto play = [&](std::size_t block) {
    Rig rig(48000, table);
    rig.options.driven = true;
    rig.hit({}, 1);
    std::vector<float> force(2000, 0.0F), height(2000, 0.01F);
    for (std::size_t n = 0; n < 300; ++n) {
      force[700 + n] = 0.3F;
      height[1000 + n] = -1e-6F * static_cast<float>(n % 37);
    }
    auto output = rig.run(2000, block, force, height);
    output.left.insert(output.left.end(), output.contact.begin(), output.contact.end());
    return output.left;
  };
  const auto reference = play(64);
  for (const std::size_t block : {1UL, 7UL, 100UL, 2000UL})
    CHECK(play(block) == reference);
}

TEST_CASE("a pulse has the coupled strike's impulse and sound below half its inverse duration") {
  // A heavy plate, so that elastic recoil plays a small part.
  ModalTable table = plate(0.4, 0.3, 0.02);
  const auto play = [&](bool coupled) {
    Rig rig(96000, table);
    rig.options.coupled = coupled;
    rig.body.set_striker({0.002, 0.004, 206e9, 0.29, 2e7, 1.5, 0, 1});
    rig.hit({0.06, 0.04, 0}, 0.5);
    return rig.run(48000);
  };
  const auto a = play(true), b = play(false);
  CHECK(20 * std::log10(impulse(b, 96000) / impulse(a, 96000)) == approx(0).epsilon(1).scale(1));
  const Rig rig(96000, table);
  const tactus::contact::ImpactLaw law{2e7, 1.5, 0};
  const double highest = 0.5 / law.duration(0.002, 0.5);
  for (std::size_t k = 0; k < rig.body.model()->audible_modes; ++k) {
    const auto s = rig.body.model()->rate[k];
    const double x = std::abs(amplitude(std::span(a.left).subspan(2000), s, 96000));
    const double y = std::abs(amplitude(std::span(b.left).subspan(2000), s, 96000));
    if (s.imag() / (2 * kPi) > highest || x < 1e-7)
      continue;
    CAPTURE(s.imag() / (2 * kPi));
    CHECK(std::abs(20 * std::log10(x / y)) < 1);
  }
}

TEST_CASE("size and material scale frequencies, shapes and mass as elasticity says") {
  Rig rig;
  const BodyModel& before = *rig.body.model();
  const double f = before.rate[before.index_of[0]].imag();
  const auto fresh = std::make_shared<const LoadedTable>(plate(0.64, 0.4, 0.01));
  BodySettings twice = rig.settings;
  twice.size = 2;
  const BodyModel scaled(rig.loaded, twice), solved(fresh, rig.settings);
  CHECK(scaled.rate[scaled.index_of[0]].imag() == approx(f / 2).epsilon(1e-6));
  CHECK(scaled.mass_kg == approx(solved.mass_kg).epsilon(1e-9));
  std::vector<double> a(scaled.mode.size()), b(solved.mode.size());
  scaled.gains(scaled.nearest({0.1, 0.07, 0}), {0, 0, 1}, a);
  solved.gains(solved.nearest({0.1, 0.07, 0}), {0, 0, 1}, b);
  for (std::size_t k = 0; k < 20; ++k) {
    CHECK(scaled.rate[scaled.index_of[k]].imag() ==
          approx(solved.rate[solved.index_of[k]].imag()).epsilon(1e-6));
    CHECK(a[scaled.index_of[k]] == approx(b[solved.index_of[k]]).epsilon(1e-5));
  }
  BodySettings steel = rig.settings;
  steel.youngs_modulus_pa = 4 * 70.3e9;
  const BodyModel stiff(rig.loaded, steel);
  CHECK(stiff.rate[stiff.index_of[0]].imag() == approx(2 * f).epsilon(1e-6));
}

TEST_CASE("a gain that is set in silence holds from the first sample, and is smoothed in sound") {
  const auto play = [](double gain) {
    Rig rig;
    rig.options.gain = gain;
    rig.hit({0.05, 0.03, 0}, 1); // takes the options first
    return rig.run(2000).left;
  };
  const auto one = play(1), quiet = play(0.001);
  float loudest = 0;
  for (const float x : one)
    loudest = std::max(loudest, std::abs(x));
  for (std::size_t n = 0; n < one.size(); ++n)
    CHECK(std::abs(1000 * quiet[n] - one[n]) <= 1e-5F * loudest);
  // 40 dB less while it rings: half a percent of the distance a sample.
  Rig rig;
  rig.hit({0.05, 0.03, 0}, 1);
  static_cast<void>(rig.run(4800));
  Rig loud;
  loud.hit({0.05, 0.03, 0}, 1);
  static_cast<void>(loud.run(4800));
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

TEST_CASE("retuning while it sounds keeps modal displacement and velocity, and makes no step") {
  Rig rig;
  rig.hit({0.05, 0.03, 0}, 1);
  static_cast<void>(rig.run(4800));
  const BodyModel* old = rig.body.model();
  std::vector<std::array<double, 2>> before;
  rig.settings.size = 1.03;
  auto next = std::make_unique<BodyModel>(rig.loaded, rig.settings);
  BodyModel* now = next.get();
  {
    auto* changing = const_cast<BodyModel*>(old);
    changing->bank.flush_pending();
    for (std::size_t k = 0; k < 10; ++k) {
      const std::size_t i = old->index_of[k];
      const auto z = old->bank.state(i);
      const double q = z.imag() / old->rate[i].imag();
      before.push_back({q, z.real() + old->rate[i].real() * q});
    }
  }
  rig.body.publish(std::move(next), true);
  rig.body.adopt();
  for (std::size_t k = 0; k < 10; ++k) {
    const std::size_t i = now->index_of[k];
    const auto z = now->bank.state(i);
    const double q = z.imag() / now->rate[i].imag();
    const double speed = z.real() + now->rate[i].real() * q;
    const double scale = std::abs(z) / now->rate[i].imag();
    CHECK(std::abs(q - before[k][0]) < 1e-6 * scale);
    CHECK(std::abs(speed - before[k][1]) < 1e-6 * std::abs(z));
  }
}

TEST_CASE("a hundred bodies exchanged while they sound leave no step and no leak") {
  Rig rig;
  float step = 0, last = 0, loudest = 0;
  for (int round = 0; round < 100; ++round) {
    rig.hit({0.05, 0.03, 0}, 0.001); // quiet: what is heard beside it would be a step
    rig.loaded =
        std::make_shared<const LoadedTable>(plate(0.3 + 0.001 * round, 0.2, 0.005, 5000, 8, 8));
    rig.rebuild(false);
    for (const float x : rig.run(100, 50).left) {
      CHECK(std::isfinite(x));
      step = std::max(step, std::abs(x - last));
      loudest = std::max(loudest, std::abs(x));
      last = x;
    }
  }
  CHECK(loudest < 1);
  CHECK(step <= loudest);
}

TEST_CASE("absurd forces and heights, at any block size and rate, stay finite") {
  std::mt19937 random(8);
  for (const double rate : {8000.0, 12345.6, 48000.0, 384000.0}) {
    Rig rig(rate);
    rig.options.driven = true;
    rig.body.set_options(rig.options);
    for (int round = 0; round < 30; ++round) {
      std::vector<float> force(512), height(512);
      for (std::size_t n = 0; n < force.size(); ++n) {
        const auto pick = random() % 8;
        force[n] = pick == 0   ? std::numeric_limits<float>::quiet_NaN()
                   : pick == 1 ? std::numeric_limits<float>::infinity()
                   : pick == 2 ? 1e30F
                               : static_cast<float>(random() % 1000) - 500;
        height[n] = pick == 3   ? -std::numeric_limits<float>::infinity()
                    : pick == 4 ? std::numeric_limits<float>::quiet_NaN()
                                : 1e-3F * (static_cast<float>(random() % 100) - 50);
      }
      if (round % 3 == 0)
        rig.hit({0.1, 0.1, 0.1}, 50);
      const auto output = rig.run(512, 1 + random() % 512, force, height);
      for (std::size_t n = 0; n < 512; ++n)
        CHECK((std::isfinite(output.left[n]) && std::isfinite(output.right[n]) &&
               std::isfinite(output.contact[n])));
    }
  }
}

TEST_CASE("culled modes are inaudible, and a decayed bank is idle") {
  const auto play = [](double cull) {
    Rig rig;
    rig.options.cull_db = cull;
    rig.body.set_striker({0.02, 0.02, 3e5, 0.49, 0, 1.5, 0, 1}); // soft: high modes hardly ring
    rig.hit({0.05, 0.03, 0}, 0.5);
    auto output = rig.run(48000);
    return std::tuple(output.left, rig.body.culled(), rig.body.model()->audible_modes);
  };
  const auto [all, none, count] = play(200);
  const auto [fewer, culled, same] = play(80);
  CHECK(none == 0);
  CHECK(culled * 4 > count);
  CHECK(same == count);
  double difference = 0, whole = 0;
  for (std::size_t n = 2000; n < all.size(); ++n) {
    difference += std::pow(static_cast<double>(all[n] - fewer[n]), 2);
    whole += std::pow(static_cast<double>(all[n]), 2);
  }
  CHECK(10 * std::log10(difference / whole + 1e-30) < -70);
  Rig rig;
  rig.settings.choke_t60_s = 0.1;
  rig.rebuild(false);
  rig.hit({0.05, 0.03, 0}, 0.5);
  static_cast<void>(rig.run(96000));
  CHECK(rig.body.model()->bank.idle());
}
