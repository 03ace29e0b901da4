// How a body is struck: which slot, which law, coupled or a pulse; what the inlets are held within;
// what is left out, and what the levels say.
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

ModalTable unit_modes(const std::vector<double>& hz, double decay_per_s = 5) {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, .3, 2700};
  table.frequency_hz = hz;
  table.decay_rate.assign(hz.size(), decay_per_s);
  return table;
}

/// Modes from 50 Hz on, all that a body of so many has.
ModalTable many_modes_table(std::size_t modes) {
  std::vector<double> hz;
  for (std::size_t k = 0; k < modes; ++k)
    hz.push_back(50 + 19000. * static_cast<double>(k) / static_cast<double>(modes));
  return unit_modes(hz);
}

/// A contact of half a second.
constexpr Striker kLongContact{1, .01, 1e6, .3, 40, 1, 0, 1};

const ContactSolver::Contact& contact(const Rig& rig, std::size_t slot) {
  return rig.body.model()->solver.contact(slot);
}

} // namespace

TEST_CASE("a strike takes a free slot, and when there is none that of the oldest") {
  Rig rig(kRate, unit_modes({1000}));
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
  rig.body.reset();
  CHECK(rig.body.contacts() == 0);
}

TEST_CASE("a strike needs a body and a speed") {
  StruckBody none;
  none.prepare(kRate);
  CHECK(!none.hit({{}, {0, 0, 1}, 1}));
  CHECK(none.contacts() == 0);
  CHECK(none.flights() == 0);
  CHECK(none.levels(3).empty());
  Rig rig(kRate, unit_modes({1000}));
  for (const double speed : {0., -1., std::nan("")})
    CHECK(!rig.body.hit({{}, {0, 0, 1}, speed}));
  CHECK(rig.body.contacts() == 0);
  CHECK(rig.body.hit({{}, {0, 0, 1}, 1e-3}));
  CHECK(rig.body.contacts() == 1);
}

TEST_CASE("a striker's law is Hertz', its own, or that of its restitution") {
  Rig rig(kRate, unit_modes({1000}));
  const auto law = [&](const Striker& striker, double speed) {
    rig.body.reset();
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
    Rig rig(kRate, unit_modes({300}));
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
  Rig rig(kRate, unit_modes({1000}));
  rig.options.driven = true;
  rig.options.spring_n_per_m = 200;
  rig.body.set_options(rig.options);
  const Output output =
      rig.run(6, 64, {}, {-.5F, 2, -9.9F, -12, -std::numeric_limits<float>::infinity(), kNan});
  CHECK(output.contact[0] == approx(100));
  CHECK(output.contact[1] == 0);
  CHECK(output.contact[2] == approx(1980).epsilon(1e-6));
  CHECK(output.contact[3] == approx(2000));
  CHECK(output.contact[4] == approx(2000));
  CHECK(output.contact[5] == 0);
  CHECK(rig.body.contacts() == 0);
  CHECK(*std::max_element(output.left.begin(), output.left.end()) == 0);
}

TEST_CASE("an external force is limited to a million newtons, and NaN is 0") {
  const auto peak = [](float force) {
    Rig rig(kRate, unit_modes({1000}));
    float maximum = 0;
    std::vector<float> push(64);
    push[3] = force;
    for (const float x : rig.run(64, 64, push).left)
      maximum = std::max(maximum, std::abs(x));
    return static_cast<double>(maximum);
  };
  const double one = peak(1);
  CHECK(one > 0);
  CHECK(peak(9e5F) == approx(9e5 * one).epsilon(1e-4));
  CHECK(peak(3e6F) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(std::numeric_limits<float>::infinity()) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(-3e6F) == approx(1e6 * one).epsilon(1e-4));
  CHECK(peak(kNan) == 0);
}

TEST_CASE("levels are those of the lowest modes by frequency, in dB from full scale") {
  Rig rig(kRate, unit_modes({3000, 500, 1200}));
  rig.options.gain = .1;
  rig.body.set_options(rig.options);
  CHECK(rig.body.levels(5) == std::vector<double>{-120, -120, -120});
  rig.hit({}, 1);
  for (const bool contacting : {true, false}) {
    static_cast<void>(rig.run(contacting ? 1 : 480));
    CHECK((rig.body.contacts() > 0) == contacting);
    const BodyModel& model = *rig.body.model();
    const auto levels = rig.body.levels(2);
    REQUIRE(levels.size() == 2);
    const std::size_t lowest[2] = {1, 2}; // of the table
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t k = model.index_of[lowest[i]];
      const auto z = contacting ? model.solver.state(k) : model.bank.state(k);
      const double output = std::max(std::abs(model.weight[0][k]), std::abs(model.weight[1][k]));
      CHECK(levels[i] == approx(20 * std::log10(std::abs(z) * output * .1)).epsilon(1e-3));
    }
  }
}

TEST_CASE("after a contact modes that are quieter than the loudest by cull_db are left out") {
  // A long contact leaves little in the high modes: their share of a half sine's spectrum.
  const auto residual_compliance = [](double cull_db) {
    Rig rig(kRate, unit_modes({200, 900, 4000, 15000}, 1));
    rig.options.cull_db = cull_db;
    rig.body.set_striker({.01, .01, 1e6, .3, 1e4, 1.5, 0, 1});
    rig.hit({}, .2);
    std::size_t n = 0;
    while (rig.body.contacts() > 0 && n++ < 4800)
      static_cast<void>(rig.run(1));
    std::size_t silent = 0;
    for (std::size_t k = 0; k < 4; ++k)
      silent += rig.body.model()->bank.state(k) == std::complex<double>(0) ? 1 : 0;
    CHECK(rig.body.culled() == silent);
    return silent;
  };
  CHECK(residual_compliance(200) == 0);
  CHECK(residual_compliance(1e-3) == 3);
  std::size_t before = 3;
  for (const double db : {1., 10., 20., 30., 40., 60., 80., 120.}) {
    const std::size_t now = residual_compliance(db);
    CHECK(now <= before);
    before = now;
  }
  CHECK(before == 0);
}

TEST_CASE("a table's recordings sound as they were taken at the nearest place, times the speed") {
  ModalTable table = plate(.3, .2, .005, 2000, 4, 4);
  RawTable& raw_table = table.raw;
  raw_table.hits = 2;
  raw_table.points = 1;
  raw_table.samples = 400;
  raw_table.sample_rate_hz = 96000;
  raw_table.position_m = {{0, 0, 0}};
  raw_table.hit_m = {{-.1, 0, 0}, {.1, 0, 0}};
  raw_table.area_m2 = {.001};
  for (std::size_t h = 0; h < 2; ++h)
    for (std::size_t n = 0; n < 400; ++n)
      raw_table.velocity_m_per_s.push_back(static_cast<float>(
          (h ? 3 : 1) * std::sin(.02 * static_cast<double>(n)) * (n < 390 ? 1 : 0)));
  Rig rig(kRate, table);
  rig.settings.radiation = Radiation::kRaw;
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
    float loudest = 0;
    for (std::size_t n = 0; n < 400; ++n) {
      const float want = (right ? 2.F : .5F) * expected(right, static_cast<double>(n) / kRate);
      CHECK(std::abs(output[n] - want) <= 1e-5F * (1e-3F + std::abs(want)));
      loudest = std::max(loudest, std::abs(want));
    }
    CHECK(loudest > 0);
    CHECK(output.back() == 0); // it is over
  }
  // Three strikes in two slots: the oldest is cut.
  rig.hit({-.12, 0, 0}, 1);
  static_cast<void>(rig.run(64));
  rig.hit({-.12, 0, 0}, 1);
  static_cast<void>(rig.run(64));
  rig.hit({-.12, 0, 0}, 1);
  const auto output = rig.run(64).left;
  for (std::size_t n = 0; n < 64; ++n) {
    const double t = static_cast<double>(n) / kRate;
    CHECK(output[n] == approx(expected(0, t) + expected(0, t + 64 / kRate)).epsilon(1e-3));
  }
  // Silence that is asked for fades them out.
  rig.body.reset();
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
