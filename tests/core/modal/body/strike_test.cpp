// How a body is struck: which slot, which law, coupled or a pulse; what the inlets are held within;
// what is left out, what the levels say, where the sound ends and where a ball comes down.
#include "core/dsp/soft_clip.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <functional>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A contact of half a second.
constexpr Striker kLongContact{1, .01, 1e6, .3, 40, 1, 0, 1};

const ContactSolver::Contact& contact(const Rig& rig, std::size_t slot) {
  return rig.body.model()->solver.contact(slot);
}

} // namespace

TEST_CASE("a strike takes a free slot, and when there is none that of the oldest") {
  Rig rig(kRate, mode_table({1000}));
  rig.settings.voices = 3;
  rig.rebuild(false);
  rig.body.set_striker(kLongContact);
  for (std::size_t i = 0; i < 3; ++i) {
    rig.hit({}, .1);
    CHECK(rig.body.contacts() == i + 1);
    static_cast<void>(rig.run(480));
  }
  const auto age = [&](std::size_t slot) { return contact(rig, slot).age_s; };
  CHECK(age(0) == approx(.03).epsilon(.01));
  CHECK(age(2) == approx(.01).epsilon(.01));
  for (const std::size_t slot : {0UL, 1UL, 2UL, 0UL}) {
    rig.hit({}, .1);
    CHECK(rig.body.contacts() == 3);
    CHECK(age(slot) == 0);
    static_cast<void>(rig.run(480));
  }
  rig.body.apply(Reset{});
  CHECK(rig.body.contacts() == 0);
}

TEST_CASE("a strike needs a body and a speed") {
  StruckBody none;
  none.prepare(kRate);
  CHECK(!none.hit({{}, {0, 0, 1}, 1}));
  CHECK(none.contacts() == 0);
  CHECK(none.flights() == 0);
  CHECK(none.levels(3).empty());
  Rig rig(kRate, mode_table({1000}));
  for (const double speed : {0., -1., std::nan("")})
    CHECK(!rig.body.hit({{}, {0, 0, 1}, speed}));
  CHECK(rig.body.contacts() == 0);
  CHECK(rig.body.hit({{}, {0, 0, 1}, 1e-3}));
  CHECK(rig.body.contacts() == 1);
}

TEST_CASE("a striker's law is Hertz', its own, or that of its restitution") {
  Rig rig(kRate, mode_table({1000}));
  const auto law = [&](const Striker& striker, double speed) {
    rig.body.apply(Reset{});
    static_cast<void>(rig.run(4800));
    rig.body.set_striker(striker);
    rig.hit({}, speed);
    return contact(rig, 0).exciter.impact.law();
  };
  Striker ball;
  // 4/3 E* sqrt(R), 1/E* = (1 - .29^2)/206 GPa + (1 - .3^2)/70 GPa.
  const double hertz = 4. / 3 / ((1 - .29 * .29) / 206e9 + (1 - .3 * .3) / 70e9) * std::sqrt(.006);
  CHECK(law(ball, 1).stiffness == approx(hertz).epsilon(1e-9));
  CHECK(law(ball, 1).exponent == 1.5);
  CHECK(law(ball, 1).dissipation_s_per_m == 0);
  CHECK(contact(rig, 0).exciter.mass_kg == approx(.0071));
  ball.stiffness = 3e5;
  ball.exponent = 2.5;
  ball.loss_s_per_m = .7;
  CHECK(law(ball, 1).stiffness == 3e5);
  CHECK(law(ball, 1).exponent == 2.5);
  CHECK(law(ball, 1).dissipation_s_per_m == .7);
  ball.restitution = .5;
  for (const double speed : {.2, 3.})
    CHECK(tactus::contact::restitution(law(ball, speed).dissipation_s_per_m * speed) ==
          approx(.5).epsilon(1e-6));
}

TEST_CASE(
    "strikes beyond the computing budget are pulses: by the number of modes, and beyond sixteen") {
  struct Case {
    std::size_t modes, coupled;
  };
  for (const Case& one : {Case{100, 16}, Case{2048, 4}, Case{2049, 3}, Case{9000, 1}}) {
    CAPTURE(one.modes);
    Rig rig(kRate, many_modes_table(one.modes));
    rig.settings.voices = 24;
    rig.rebuild(false);
    rig.body.set_striker({1e-4, .01, 1e6, .3, 5, 1, 0, 1}); // light and slow
    for (int i = 0; i < 20; ++i)
      rig.hit({}, .01);
    CHECK(rig.body.model()->solver.active() == one.coupled);
    CHECK(rig.body.contacts() == 20);
  }
}

TEST_CASE("with pulses a heavy striker and a falling one are still coupled") {
  const auto coupled = [](double mass_kg, bool falls) {
    Rig rig(kRate, mode_table({300}));
    rig.options.coupled = false;
    rig.body.set_options(rig.options);
    rig.body.set_striker({mass_kg, .01, 1e6, .3, 1e8, 1, 0, 1});
    rig.body.hit({{}, {0, 0, 1}, .1, falls});
    CHECK(rig.body.contacts() == 1);
    return rig.body.model()->solver.active() == 1;
  };
  // The mode weighs 1 kg for a contact that it has time to follow.
  CHECK(!coupled(.01, false));
  CHECK(coupled(.01, true));
  CHECK(coupled(2, false));
}

TEST_CASE("a hand on a spring feels k times its depth, to ten metres") {
  Rig rig(kRate, mode_table({1000}));
  rig.options.driven = true;
  rig.options.spring_n_per_m = 200;
  rig.body.set_options(rig.options);
  const Output output = rig.run(6, 64, {}, {-.5F, 2, -9.9F, -12, -kInfinity, kNan});
  CHECK(output.contact[0] == approx(100));
  CHECK(output.contact[1] == 0);
  CHECK(output.contact[2] == approx(1980).epsilon(1e-6));
  CHECK(output.contact[3] == approx(2000));
  CHECK(output.contact[4] == approx(2000));
  CHECK(output.contact[5] == 0);
  CHECK(rig.body.contacts() == 0);
  CHECK(loudest(output.left) == 0);
}

TEST_CASE("steps of an encoder under a resting hand are no strikes, and a hand that comes in steps "
          "strikes as one "
          "that glides") {
  // Heights in m by time in s; every: readings in samples; step: of the encoder, m.
  const auto play = [](const std::function<double(double)>& height_at, std::size_t every,
                       double step) {
    Rig rig(kRate, mode_table({300, 900}));
    rig.options.driven = true;
    rig.body.set_options(rig.options);
    std::vector<float> height(48000);
    for (std::size_t n = 0; n < height.size(); ++n) {
      const double x = height_at(static_cast<double>(n / every * every) / kRate);
      height[n] = static_cast<float>(step > 0 ? std::round(x / step) * step : x);
    }
    return loudest(rig.run(height.size(), 64, {}, height).left);
  };
  const auto strike_at = [](double speed) {
    return
        [speed](double t) { return .004 - speed * std::min(std::max(t - .1, 0.0), .005 / speed); };
  };
  const auto resting = [](double t) { return 20e-6 * std::sin(2 * std::numbers::pi * 9 * t); };
  const double strike = play(strike_at(1), 1, 0);
  CHECK(play(strike_at(1), 48, 0) == approx(strike).epsilon(.02));
  CHECK(play(strike_at(.1), 48, 0) == approx(play(strike_at(.1), 1, 0)).epsilon(.02));
  CHECK(strike > 0);
  CHECK(play(resting, 48, 35e-6) < 2e-3 * strike);
  CHECK(play(resting, 384, 35e-6) < 2e-3 * strike); // seen by Pd's messages, every 8 ms
}

TEST_CASE("an external force is limited to a million newtons, and NaN is 0") {
  const auto peak = [](float force) {
    Rig rig(kRate, mode_table({1000}));
    std::vector<float> push(64);
    push[3] = force;
    return loudest(rig.run(64, 64, push).left);
  };
  const double one = peak(1);
  CHECK(one > 0);
  CHECK(peak(9e5F) == approx(9e5 * one).epsilon(1e-4));
  CHECK(peak(3e6F) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(kInfinity) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(-3e6F) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(kNan) == 0);
}

TEST_CASE("levels are those of the lowest modes at the louder listener, in dB from full scale") {
  Rig rig(kRate, mode_table({3000, 500, 1200}));
  rig.options.gain = .1;
  rig.body.set_options(rig.options);
  CHECK(rig.body.levels(5) == std::vector<double>{-120, -120, -120});
  rig.hit({}, 1);
  const std::size_t lowest[2] = {1, 2}; // of the table
  static_cast<void>(rig.run(1));
  REQUIRE(rig.body.contacts() == 1);
  const BodyModel& model = *rig.body.model();
  auto levels = rig.body.levels(2);
  REQUIRE(levels.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t k = model.index_of[lowest[i]];
    const double size = abs(model.solver.state(k)) * abs(model.weight[0][k]);
    CHECK(levels[i] == approx(20 * std::log10(size * .1)).epsilon(1e-3));
  }
  static_cast<void>(rig.run(480));
  REQUIRE(rig.body.contacts() == 0);
  levels = rig.body.levels(2);
  const Output output = rig.run(24000); // measured
  for (std::size_t i = 0; i < 2; ++i) {
    const Complex s = model.rate[model.index_of[lowest[i]]];
    const double heard = std::max(abs(amplitude(output.left, s)), abs(amplitude(output.right, s)));
    CHECK(levels[i] == approx(20 * std::log10(heard)).epsilon(1e-3));
  }
}

TEST_CASE("a striker meets modes that no listener hears") {
  const auto play = [](const Vec3& listener) {
    Rig rig(kRate, plate(.32, .2, .005, 5000, 16, 10));
    rig.settings.listener = {listener, listener};
    rig.rebuild(false);
    rig.hit({.06, .03, 0}, 1);
    rig.run(960);
    rig.hit({.06, .03, 0}, 1);
    return rig.run(480).contact;
  };
  CHECK(apart(play({.051, .043, .1}), play({0, 0, .1})) < 1e-4); // above the centre half are silent
}

TEST_CASE("modes that are culled after a contact or from a pulse are inaudible") {
  for (const bool coupled : {true, false}) {
    CAPTURE(coupled);
    const auto play = [&](double cull_db) {
      Rig rig;
      rig.options.cull_db = cull_db;
      rig.options.coupled = coupled;
      rig.body.set_striker({0.02, 0.02, 3e5, 0.49, 0, 1.5, 0, 1}); // soft: high modes hardly ring
      rig.hit({0.05, 0.03, 0}, 0.5);
      const auto sound = rig.run(12000).left;
      const double culled = static_cast<double>(rig.body.culled());
      return std::pair(sound, culled / static_cast<double>(rig.body.model()->audible_modes));
    };
    const auto [all, none] = play(200);
    const auto [fewer, culled] = play(80);
    CHECK(none == 0);
    CHECK(culled > (coupled ? .15 : .1));
    CHECK(difference_db(std::span(all).subspan(2000), std::span(fewer).subspan(2000)) < -70);
  }
}

TEST_CASE("a table's recordings sound as they were taken at the nearest place, times the speed") {
  ModalTable table = plate(.3, .2, .005, 2000, 4, 4);
  RawTable& raw = table.raw;
  raw.hits = 2;
  raw.points = 1;
  raw.samples = 400;
  raw.sample_rate_hz = 96000;
  raw.position_m = {{0, 0, 0}};
  raw.hit_m = {{-.1, 0, 0}, {.1, 0, 0}};
  raw.area_m2 = {.001};
  for (std::size_t h = 0; h < 2; ++h)
    for (std::size_t n = 0; n < 400; ++n)
      raw.velocity_m_per_s.push_back(static_cast<float>(
          (h ? 3 : 1) * std::sin(.02 * static_cast<double>(n)) * (n < 390 ? 1 : 0)));
  Rig rig(kRate, table, Radiation::kRaw);
  rig.settings.voices = 2;
  rig.rebuild(false);
  REQUIRE(rig.body.model()->uses_recordings);
  const auto expected = [&](std::size_t hit, double time) {
    return static_cast<float>(rig.body.model()->raw[0].pressure(rig.loaded->table.raw, hit, time));
  };
  const auto play = [&](Vec3 point, double speed) {
    rig.hit(point, speed);
    CHECK(rig.body.contacts() == 0);
    return rig.run(640).left;
  };
  for (const bool right : {false, true}) {
    const auto output = play({right ? .08 : -.12, .03, 0}, right ? 2 : .5);
    for (std::size_t n = 0; n < 400; ++n) {
      const float want = (right ? 2.F : .5F) * expected(right, static_cast<double>(n) / kRate);
      CHECK(std::abs(output[n] - want) <= 1e-5F * (1e-3F + std::abs(want)));
    }
    CHECK(loudest(output) > 0);
    CHECK(output.back() == 0); // it is over
  }
  // Three strikes in two slots: the oldest is cut.
  for (int i = 0; i < 2; ++i) {
    rig.hit({-.12, 0, 0}, 1);
    static_cast<void>(rig.run(64));
  }
  rig.hit({-.12, 0, 0}, 1);
  const auto output = rig.run(64).left;
  for (std::size_t n = 0; n < 64; ++n) {
    const double t = static_cast<double>(n) / kRate;
    CHECK(output[n] == approx(expected(0, t) + expected(0, t + 64 / kRate)).epsilon(1e-3));
  }
  // Silence that is asked for fades them out.
  rig.body.apply(Reset{});
  const auto faded = rig.run(64 + ModeBank::kRelease).left;
  CHECK(faded[0] != 0);
  for (std::size_t n = 0; n < 64; ++n) {
    const double t = static_cast<double>(n + 64) / kRate;
    const double share = ModeBank::release_share(ModeBank::kRelease - n);
    CHECK(faded[n] ==
          approx(share * static_cast<double>(expected(0, t) + expected(0, t + 64 / kRate)))
              .epsilon(1e-3));
  }
  CHECK(faded.back() == 0);
}

TEST_CASE("a mode rings until it is 160 dB below full scale, and not longer") {
  for (const double gain : {1.0, 0.01}) {
    CAPTURE(gain);
    Rig rig(kRate, mode_table({1000}, 50));
    rig.options.gain = gain;
    rig.hit({}, 1);
    static_cast<void>(rig.run(480));
    const double size =
        abs(rig.body.model()->bank.state(0)) * abs(rig.body.model()->weight[0][0]) * gain;
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
      Rig rig(kRate, mode_table({1000}, 50));
      rig.options.gain = gain;
      rig.options.soft_limit = limit;
      rig.hit({}, 20);
      return rig.run(4800);
    };
    const Output free = struck(false), limited = struck(true);
    for (std::size_t n = 0; n < free.left.size(); ++n) {
      REQUIRE(limited.left[n] ==
              static_cast<float>(tactus::soft_clip(static_cast<double>(free.left[n]))));
      REQUIRE(limited.right[n] ==
              static_cast<float>(tactus::soft_clip(static_cast<double>(free.right[n]))));
      REQUIRE(limited.contact[n] == free.contact[n]);
    }
    CHECK((loudest(free.left) > 1) == (gain > 1)); // both sides of the limit are tried
  }
}

TEST_CASE("a ball thrown off by a swinging body lands as fast as it falls from there") {
  // A soft spring on a slow mode: the surface is well above its rest when the ball leaves.
  constexpr double kMass = 1, kStiffness = 5000, kSpeed = 1;
  bool above = false;
  for (const double frequency : {2.0, 3.0, 4.0, 6.0, 10.0, 16.0}) {
    CAPTURE(frequency);
    Rig rig(kRate, mode_table({frequency}, 0.1));
    rig.body.set_striker({kMass, 0.01, 1e6, 0.3, kStiffness, 1, 0, 1});
    rig.body.hit({{}, {0, 0, 1}, kSpeed, true});
    const Output output = rig.run(96000);
    // The ball's own motion, up, from the force on it.
    double height = 0, speed = -kSpeed;
    std::size_t n = 0;
    const auto fly = [&](std::size_t sample) {
      const double force = static_cast<double>(output.contact[sample]);
      const double a = force / kMass - kGravity;
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
    const double landing = std::sqrt(speed * speed + 2 * kGravity * height);
    const double flight = (speed + landing) / kGravity;
    CHECK(std::abs(static_cast<double>(quiet) / kRate / flight - 1) < 0.002);
  }
  CHECK(above);
}
