// What goes on: contacts while the body is retuned, balls that bounce, culled bowls.
#include "core/modal/body/struck_body.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

/// One stiff mode of 1 kg without a shape: nearly a wall for a light ball.
ModalTable wall() {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  table.frequency_hz = {15000};
  table.loss_factor = {1e-2};
  return table;
}

/// The same body again, as a slider's smallest move makes it.
void retune(Rig& rig, double size) {
  rig.settings.size = size;
  rig.rebuild();
}

} // namespace

TEST_CASE("a long contact continues through a retuning as if there had been none") {
  // A soft striker stays for milliseconds; the new body is the old one in all but name.
  const auto play = [](bool replaced) {
    Rig rig;
    rig.body.set_striker({0.05, 0.02, 1e6, 0.49, 1e5, 1.5, 0, 1});
    rig.hit({0.05, 0.03, 0}, 0.5);
    Output output = rig.run(64);
    CHECK(rig.body.contacts() == 1);
    if (replaced)
      retune(rig, 1);
    CHECK(rig.body.contacts() == 1);
    const Output rest = rig.run(4800);
    output.left.insert(output.left.end(), rest.left.begin(), rest.left.end());
    output.contact.insert(output.contact.end(), rest.contact.begin(), rest.contact.end());
    return output;
  };
  const Output a = play(false), b = play(true);
  CHECK(impulse(b, 48000) == approx(impulse(a, 48000)).epsilon(1e-6));
  float largest = 0, difference = 0;
  for (std::size_t n = 0; n < a.left.size(); ++n) {
    largest = std::max(largest, std::abs(a.left[n]));
    difference = std::max(difference, std::abs(a.left[n] - b.left[n]));
  }
  CHECK(difference < 1e-4F * largest);
}

TEST_CASE("a hand that presses while size and material change keeps its force and its contact") {
  Rig rig;
  rig.options.driven = true;
  rig.body.set_options(rig.options);
  rig.body.set_striker({0.05, 0.02, 1e6, 0.49, 1e4, 1, 0, 1});
  const std::vector<float> height(4800, -1e-4F);
  const float before = rig.run(48000, 64, {}, std::vector<float>(48000, -1e-4F)).contact.back();
  for (int round = 1; round <= 20; ++round) {
    retune(rig, 1 + 0.002 * round);
    CHECK(rig.body.contacts() == 1);
    for (const float force : rig.run(480, 64, {}, std::vector<float>(480, -1e-4F)).contact)
      CHECK(force == approx(before).epsilon(0.1));
  }
}

TEST_CASE("a retuned body begins its new sound where the old one stopped") {
  for (const Radiation radiation : {Radiation::kNone, Radiation::kModal}) {
    Rig rig;
    rig.settings.radiation = radiation;
    rig.rebuild(false);
    rig.hit({0.05, 0.03, 0}, 2);
    float loudest = 0;
    for (const float x : rig.run(4800).left)
      loudest = std::max(loudest, std::abs(x));
    const BodyModel& before = *rig.body.model();
    const auto sound = [](BodyModel& model, ModeBank::Part part) {
      model.bank.flush_pending();
      double sum = 0;
      for (std::size_t k = 0; k < model.audible_modes; ++k)
        sum += (model.bank.weight(0, part, k) * model.bank.state(k)).imag();
      return sum;
    };
    auto& old = const_cast<BodyModel&>(before);
    const double last = sound(old, ModeBank::kLatest);
    rig.settings.size = 1.05;
    rig.settings.youngs_modulus_pa = 60e9;
    auto next = std::make_unique<BodyModel>(rig.loaded, rig.settings);
    BodyModel& now = *next;
    rig.body.publish(std::move(next), true);
    rig.body.adopt();
    CHECK(20 * std::log10(std::abs(sound(now, ModeBank::kMiddle) - last) /
                              static_cast<double>(loudest) +
                          1e-12) <
          -60);
  }
}

TEST_CASE("a ball that falls comes back in the times of its bounces until it lies") {
  for (const double e : {0.3, 0.6}) {
    for (const std::size_t block : {1UL, 64UL, 1000UL}) {
      CAPTURE(e);
      CAPTURE(block);
      Rig rig(48000, wall());
      Striker ball{0.0005, 0.003, 206e9, 0.29, 1e7, 1.5, 0, e};
      rig.body.set_striker(ball);
      const double speed = 1;
      rig.body.hit({{}, {0, 0, 1}, speed, true});
      const Output output = rig.run(48000, block);
      std::vector<double> onset, impulses;
      std::size_t samples_below = 1000;
      for (std::size_t n = 0; n < output.contact.size(); ++n) {
        if (output.contact[n] <= 0) {
          ++samples_below;
          continue;
        }
        if (samples_below > 20) {
          onset.push_back(static_cast<double>(n) / 48000);
          impulses.push_back(0);
        }
        samples_below = 0;
        impulses.back() += static_cast<double>(output.contact[n]) / 48000;
      }
      REQUIRE(onset.size() > 4);
      for (std::size_t i = 1; i < 4; ++i) {
        const double up = speed * std::pow(e, static_cast<double>(i));
        // 2 v/g in the air, and the contact's own time, here below a millisecond.
        CHECK(std::abs(onset[i] - onset[i - 1] - 2 * up / StruckBody::kGravity) <
              1e-3 + 0.02 * onset[i]);
        CHECK(impulses[i] / impulses[i - 1] == approx(e).epsilon(0.05));
      }
      CHECK(rig.body.flights() == 0);
      CHECK(rig.body.contacts() == 0);
      CHECK(onset.back() < 2 * speed / StruckBody::kGravity * e / (1 - e) + 0.1);
    }
  }
}

TEST_CASE("falling balls without number, and bodies exchanged under them, stay finite and end") {
  std::mt19937 random(3);
  Rig rig(48000);
  rig.body.set_striker({0.002, 0.004, 206e9, 0.29, 0, 1.5, 0, 0.8});
  for (int round = 0; round < 200; ++round) {
    const SurfacePoint at =
        rig.body.model()->nearest({0.001 * static_cast<double>(random() % 100), 0, 0});
    rig.body.hit({at, at.normal, 0.01 * static_cast<double>(1 + random() % 200), true});
    if (round % 5 == 0)
      retune(rig, 1 + 0.001 * static_cast<double>(random() % 50));
    for (const float x : rig.run(1 + random() % 700).left)
      CHECK(std::isfinite(x));
  }
  static_cast<void>(rig.run(5 * 48000));
  CHECK(rig.body.flights() == 0);
  CHECK(rig.body.contacts() == 0);
}
