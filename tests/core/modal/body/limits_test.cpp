// Where a body's sound ends, what no body stands, and where a ball comes down.
#include "core/dsp/soft_clip.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;

namespace {

ModalTable one_mode(double frequency_hz, double decay_per_s) {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  table.frequency_hz = {frequency_hz};
  table.decay_rate = {decay_per_s};
  return table;
}

} // namespace

TEST_CASE("a mode rings until it is 160 dB below full scale, and not longer") {
  for (const double gain : {1.0, 0.01}) {
    CAPTURE(gain);
    Rig rig(48000, one_mode(1000, 50));
    rig.options.gain = gain;
    rig.hit({}, 1);
    static_cast<void>(rig.run(480));
    const double size =
        std::abs(rig.body.model()->bank.state(0)) * std::abs(rig.body.model()->weight[0][0]) * gain;
    const double sounds_s = std::log(size / 1e-8) / 50;
    static_cast<void>(rig.run(static_cast<std::size_t>((sounds_s - 0.03) * 48000)));
    CHECK(!rig.body.model()->bank.idle());
    static_cast<void>(rig.run(static_cast<std::size_t>(0.07 * 48000)));
    CHECK(rig.body.model()->bank.idle());
  }
}

TEST_CASE("the soft limit clips what is heard after the gain, and neither quiet sound nor forces") {
  for (const double gain : {0.01, 300.0}) {
    CAPTURE(gain);
    const auto struck = [gain](bool limit) {
      Rig rig(48000, one_mode(1000, 50));
      rig.options.gain = gain;
      rig.options.soft_limit = limit;
      rig.hit({}, 20);
      return rig.run(4800);
    };
    const Output free = struck(false), limited = struck(true);
    float largest = 0;
    for (std::size_t n = 0; n < free.left.size(); ++n) {
      largest = std::max(largest, std::abs(free.left[n]));
      REQUIRE(limited.left[n] == static_cast<float>(soft_clip(static_cast<double>(free.left[n]))));
      REQUIRE(limited.right[n] ==
              static_cast<float>(soft_clip(static_cast<double>(free.right[n]))));
      REQUIRE(limited.contact[n] == free.contact[n]);
    }
    CHECK((largest > 1) == (gain > 1)); // both sides of the limit are tried
  }
}

TEST_CASE("a diverging force ends the contact, and the next strike is as any other") {
  const auto strike_impulse = [](bool pressed) {
    Rig rig(48000, one_mode(15000, 50));
    rig.settings.size = 100; // as heavy and stiff as settings make it: 1e14 N/m
    rig.settings.density_kg_per_m3 = 1e5;
    rig.settings.youngs_modulus_pa = 1e13;
    rig.rebuild(false);
    rig.options.driven = true;
    rig.body.set_options(rig.options);
    if (pressed) {
      const Striker ball = rig.body.striker();
      Striker pin = ball;
      pin.stiffness = 1e15;
      pin.exponent = 1;
      rig.body.set_striker(pin);
      const Output output = rig.run(2000, 64, {}, std::vector<float>(2000, -10.0F));
      CHECK(*std::max_element(output.contact.begin(), output.contact.end()) < 1e12F);
      rig.body.set_striker(ball);
    }
    static_cast<void>(rig.run(4800, 64, {}, std::vector<float>(4800, 1.0F)));
    rig.body.reset();
    static_cast<void>(rig.run(4800, 64, {}, std::vector<float>(4800, 1.0F)));
    rig.hit({0.05, 0.03, 0}, 1);
    return impulse(rig.run(4800, 64, {}, std::vector<float>(4800, 1.0F)), 48000);
  };
  CHECK(strike_impulse(true) / strike_impulse(false) == approx(1).epsilon(1e-6));
}

TEST_CASE("a ball thrown off by a swinging body lands as fast as it falls from there") {
  // A soft spring on a slow mode: the surface is well above its rest when the ball leaves.
  constexpr double kRate = 48000, kMass = 1, kStiffness = 5000, kSpeed = 1;
  bool above = false;
  for (const double frequency : {2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0}) {
    CAPTURE(frequency);
    Rig rig(kRate, one_mode(frequency, 0.1));
    rig.body.set_striker({kMass, 0.01, 1e6, 0.3, kStiffness, 1, 0, 1});
    rig.body.hit({{}, {0, 0, 1}, kSpeed, true});
    const Output output = rig.run(96000);
    // The ball's own motion, up, from the force on it.
    double height = 0, speed = -kSpeed;
    std::size_t n = 0;
    const auto fly = [&](std::size_t sample) {
      const double force = static_cast<double>(output.contact[sample]);
      const double a = force / kMass - StruckBody::kGravity;
      height += speed / kRate + 0.5 * a / (kRate * kRate);
      speed += a / kRate;
    };
    while (n < 96000 && (output.contact[n] > 0 || n < 10))
      fly(n++);
    std::size_t quiet = 0;
    while (n + quiet < 96000 && output.contact[n + quiet] <= 0)
      ++quiet;
    if (n + quiet >= 95000 || quiet < 480 || height < 1e-3 || speed <= 0)
      continue;
    above = true;
    const double landing = std::sqrt(speed * speed + 2 * StruckBody::kGravity * height);
    const double flight = (speed + landing) / StruckBody::kGravity;
    CHECK(std::abs(static_cast<double>(quiet) / kRate / flight - 1) < 0.002);
  }
  CHECK(above);
}

TEST_CASE("modes that are culled from a pulse are inaudible") {
  const auto play = [](double cull) {
    Rig rig;
    rig.options.cull_db = cull;
    rig.options.coupled = false;
    rig.body.set_striker({0.02, 0.02, 3e5, 0.49, 0, 1.5, 0, 1}); // soft
    rig.hit({0.05, 0.03, 0}, 0.5);
    auto output = rig.run(48000);
    return std::tuple(output.left, rig.body.culled(), rig.body.model()->audible_modes);
  };
  const auto [all, none, count] = play(200);
  const auto [fewer, culled, same] = play(80);
  CHECK(none == 0);
  CHECK(culled * 10 > count);
  CHECK(same == count);
  double difference = 0, whole = 0;
  for (std::size_t n = 2000; n < all.size(); ++n) { // after the pulse
    difference += std::pow(static_cast<double>(all[n] - fewer[n]), 2);
    whole += std::pow(static_cast<double>(all[n]), 2);
  }
  CHECK(10 * std::log10(difference / whole + 1e-30) < -70);
}

TEST_CASE("many strikers that never leave are computed in bounded time, and the body works "
          "after it") {
  // A thousand tonnes each: all press at once and for ever. More than the solver follows are
  // pulses.
  Rig rig;
  rig.settings.voices = 64;
  rig.rebuild(false);
  rig.body.set_striker({1e6, 10, 1e15, .3, 0, 1.5, 0, 1});
  for (int i = 0; i < 66; ++i)
    rig.hit({.001 * i, .0007 * i, 0}, 50);
  CHECK(rig.body.model()->solver.active() <= StruckBody::kMaxCoupled);
  const Output output = rig.run(64);
  CHECK(rig.body.model()->solver.steps() * rig.body.model()->solver.active() <= 1024);
  for (const auto* sound : {&output.left, &output.right, &output.contact})
    CHECK(std::all_of(sound->begin(), sound->end(), [](float y) { return std::isfinite(y); }));
  rig.body.reset();
  static_cast<void>(rig.run(4096));
  rig.body.set_striker({});
  rig.hit({}, 1);
  const Output after = rig.run(2000);
  float peak = 0;
  for (const float y : after.left)
    peak = std::max(peak, std::abs(y));
  CHECK(peak > 1e-3F);
}
