// One body gives way to another: contacts, rubs and balls in the air go on; what waits for its
// sample, where points come to lie, and what still rings.
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

Vec3 turned(const Vec3& v, double angle) { // about x
  return {v.x, std::cos(angle) * v.y - std::sin(angle) * v.z,
          std::sin(angle) * v.y + std::cos(angle) * v.z};
}

/// The plate, inclined by an angle about x.
std::shared_ptr<const LoadedTable> inclined(double angle) {
  ModalTable table = plate(.32, .2, .005, 3000, 8, 6);
  for (Vec3& v : table.vertex_m)
    v = turned(v, angle);
  for (std::size_t i = 0; i < table.shape.size(); i += 3) { // along z alone
    const Vec3 t = turned({0, 0, static_cast<double>(table.shape[i + 2])}, angle);
    for (int axis = 0; axis < 3; ++axis)
      table.shape[i + static_cast<std::size_t>(axis)] = static_cast<float>(t[axis]);
  }
  return std::make_shared<const LoadedTable>(std::move(table));
}

const Vec3 kPoint{.06, .03, 0};

/// The same body again, as a slider's smallest move makes it.
void retune(Rig& rig, double size) {
  rig.settings.size = size;
  rig.rebuild();
}

} // namespace

TEST_CASE("a contact, a pulse and a rub go on through a retuning as if there had been none") {
  enum How { kContact, kPulse, kRub };
  for (const How how : {kContact, kPulse, kRub}) {
    CAPTURE(static_cast<int>(how));
    const auto play = [&](bool replaced) {
      Rig rig(kRate, plate(.32, .2, .005, 5000, 16, 10));
      rig.options.coupled = how == kContact;
      rig.body.set_striker({0.05, 0.02, 1e6, 0.49, 1e5, 1.5, 0, 1}); // stays for milliseconds
      if (how != kRub)
        rig.hit(kPoint, 0.5);
      Rub rub;
      rub.placed = true;
      rub.point = rig.body.model()->nearest(kPoint);
      rub.direction = {1, 0, 0};
      rub.law.stiffness_n_per_m = 1e4;
      rig.body.apply(rub);
      const auto run = [&](std::size_t frames) {
        return how == kRub ? rig.rub(2, .05F, frames).second : rig.run(frames).left;
      };
      std::vector<float> sound = run(how == kRub ? 1280 : 64);
      if (replaced) {
        rig.settings.listener[1] = {0, 0, 0.3}; // where something moves
        rig.rebuild();
      }
      CHECK(rig.body.contacts() == 1);
      append(sound, run(4800));
      return sound;
    };
    CHECK(apart(play(false), play(true)) < (how == kRub ? 2e-3 : 1e-4));
  }
}

TEST_CASE("a hand that presses while size and material change keeps its force and its contact") {
  Rig rig;
  rig.options.driven = true;
  rig.body.set_options(rig.options);
  rig.body.set_striker({0.05, 0.02, 1e6, 0.49, 1e4, 1, 0, 1});
  const float before = rig.run(48000, 64, {}, std::vector<float>(48000, -1e-4F)).contact.back();
  for (int round = 1; round <= 20; ++round) {
    retune(rig, 1 + 0.002 * round);
    CHECK(rig.body.contacts() == 1);
    for (const float force : rig.run(480, 64, {}, std::vector<float>(480, -1e-4F)).contact)
      CHECK(force == approx(before).epsilon(0.1));
  }
}

TEST_CASE("a body that changes while it rings, or while a hand presses, does not thump") {
  struct Change {
    double modulus_pa, density, size;
  };
  constexpr Change kTable{0, 0, 1}, kSteel{200e9, 7850, 1}, kRubber{.05e9, 1100, 1};
  for (const bool pressed : {false, true})
    for (const auto& change : {std::pair(kTable, Change{1e9, 0, 1}), std::pair(kTable, kRubber),
                               std::pair(kTable, Change{0, 0, 8}), std::pair(kSteel, kRubber),
                               std::pair(kRubber, kSteel), std::pair(Change{0, 0, 2}, kTable)})
      for (const double highest : {700., 5000.}) { // one mode, or those of a plate
        const Change &from = change.first, &to = change.second;
        CAPTURE(pressed);
        CAPTURE(from.modulus_pa);
        CAPTURE(to.modulus_pa);
        CAPTURE(to.size);
        CAPTURE(highest);
        Rig rig(kRate, plate(.32, .2, .005, highest, 16, 10), Radiation::kModal);
        const auto become = [&](const Change& c) {
          rig.settings.youngs_modulus_pa = c.modulus_pa;
          rig.settings.density_kg_per_m3 = c.density;
          retune(rig, c.size);
        };
        const auto run = [&](std::size_t frames) {
          return loudest(rig.run(frames, 64, {}, std::vector<float>(frames, -1e-5F)).left);
        };
        if (pressed) {
          rig.settings.damping = Damping::kLoss;
          rig.settings.loss_factor = .3;
        }
        rig.options.driven = pressed;
        rig.body.set_options(rig.options);
        become(from);
        const double touch = run(4800);
        if (!pressed)
          rig.hit(kPoint, 1);
        const double before = run(pressed ? 48000 : 960);
        become(to);
        const double meanwhile = run(1200), after = run(4800);
        CHECK(meanwhile < 1.26 * std::max(before, after) + 1e-5 * touch); // 2 dB
      }
}

TEST_CASE("a retuned body begins its new sound where the old one stopped") {
  for (const Radiation radiation : {Radiation::kNone, Radiation::kModal}) {
    Rig rig(kRate, plate(.32, .2, .005, 20000, 16, 10), radiation);
    rig.hit({0.05, 0.03, 0}, 2);
    const double peak = loudest(rig.run(4800).left);
    const auto sound = [&](ModeBank::Part part) {
      rig.flush();
      const BodyModel& model = *rig.body.model();
      double sum = 0;
      for (std::size_t k = 0; k < model.audible_modes; ++k)
        sum += (model.bank.weight(0, part, k) * model.bank.state(k)).imag();
      return sum;
    };
    const double last = sound(ModeBank::kLatest);
    rig.settings.youngs_modulus_pa = 60e9;
    retune(rig, 1.05);
    CHECK(std::abs(sound(ModeBank::kMiddle) - last) < 1e-3 * peak);
  }
}

TEST_CASE("a ball that falls comes back in the times of its bounces until it lies") {
  for (const double e : {0.3, 0.6})
    for (const std::size_t block : {1UL, 64UL, 1000UL}) {
      CAPTURE(e);
      CAPTURE(block);
      Rig rig(kRate, mode_table({15000}, 500)); // of 1 kg: nearly a wall for a light ball
      rig.body.set_striker({0.0005, 0.003, 206e9, 0.29, 1e7, 1.5, 0, e});
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
          onset.push_back(static_cast<double>(n) / kRate);
          impulses.push_back(0);
        }
        samples_below = 0;
        impulses.back() += static_cast<double>(output.contact[n]) / kRate;
      }
      REQUIRE(onset.size() > 4);
      for (std::size_t i = 1; i < 4; ++i) {
        const double up = speed * std::pow(e, static_cast<double>(i));
        // 2 v/g in the air, and the contact's own time, here below a millisecond.
        CHECK(std::abs(onset[i] - onset[i - 1] - 2 * up / kGravity) < 1e-3 + 0.02 * onset[i]);
        CHECK(impulses[i] / impulses[i - 1] == approx(e).epsilon(0.05));
      }
      CHECK(rig.body.flights() == 0);
      CHECK(rig.body.contacts() == 0);
      CHECK(onset.back() < 2 * speed / kGravity * e / (1 - e) + 0.1);
    }
}

TEST_CASE(
    "a scheduled strike hits the new body at its position, along the normal if it was along it") {
  constexpr double kAngle = .7;
  for (const bool oblique : {false, true}) {
    CAPTURE(oblique);
    const Vec3 given{0, .6, .8};
    Rig scheduled, direct;
    const SurfacePoint before = scheduled.body.model()->nearest(kPoint);
    scheduled.body.schedule(Hit{before, oblique ? given : before.normal, 1}, 100);
    for (Rig* rig : {&scheduled, &direct})
      rig->exchange(inclined(kAngle));
    const SurfacePoint now = direct.body.model()->nearest(before.position);
    CHECK(norm(now.normal - before.normal) > .5);
    direct.body.schedule(Hit{now, oblique ? given : now.normal, 1}, 100);
    const auto a = scheduled.run(2000), b = direct.run(2000);
    CHECK(apart(b.left, a.left) < 1e-6);
    CHECK(impulse(a) == approx(impulse(b)).epsilon(1e-6));
  }
}

TEST_CASE("points are kept in metres when the new body has another size") {
  Rig rig, direct;
  rig.settings.size = 2;
  rig.rebuild(false);
  rig.set_point({.1, .05, 0});
  rig.body.schedule(rig.at({.1, .05, 0}, 1), 100);
  const Vec3 next{-.06, .02, .0025};
  rig.body.schedule(ForcePoint{rig.body.model()->nearest(next), {0, 0, 1}}, 300);
  rig.settings.size = 1;
  for (Rig* each : {&rig, &direct})
    each->exchange(inclined(0));
  // What waits, in the table's own lengths: 2 x its position.
  CHECK(norm(rig.body.point().position - next) < 1e-6);
  Rig alone; // one point is all that waits
  alone.body.schedule(ForcePoint{alone.body.model()->nearest(next), {0, 0, 1}}, 300);
  alone.rebuild();
  CHECK(norm(alone.body.point().position - next) < 1e-6);
  direct.body.schedule(direct.at({.1, .05, 0}, 1), 100);
  // The bank is exact to -60 dB, and its leaps begin anew where the point moves.
  CHECK(apart(direct.run(1000).left, rig.run(1000).left) < 1e-3);
}

TEST_CASE("a rub moves to the new body, whether it is there, waits or is asked for again") {
  for (const bool waits : {false, true}) {
    CAPTURE(waits);
    Rig rig;
    Rub rub;
    rub.placed = true;
    rub.point = rig.body.model()->nearest({.1, .05, 0});
    rub.direction = {1, 0, 0};
    if (waits)
      rig.body.schedule(rub, 1000);
    else
      rig.body.apply(rub);
    const auto coarse = std::make_shared<const LoadedTable>(plate(.3, .2, .005, 5000, 2, 2));
    REQUIRE(rub.point.triangle >= coarse->surface.triangles());
    rig.exchange(coarse);
    rub = rig.body.rub(); // with another law it is sent once more
    CHECK(rub.point.triangle < coarse->surface.triangles());
    CHECK(norm(rub.point.position - Vec3{.1, .05, 0}) < 1e-2);
  }
}

TEST_CASE("a rub at the force point that waits keeps its direction on a new body") {
  Rig rig;
  Rub rub;
  rub.direction = {.6, 0, .8};
  rig.body.schedule(rub, 1000);
  rig.exchange(inclined(.7));
  CHECK(rig.body.rub().direction == rub.direction);
}

TEST_CASE("a force point that was never set lies nearest to the user, and a set one stays put") {
  Rig rig;
  const auto middle = [&] {
    return .5 * (rig.loaded->surface.lowest() + rig.loaded->surface.highest());
  };
  CHECK(norm(rig.body.point().position - middle()) < .02);
  rig.exchange(inclined(1.2)); // upright: its upper edge and its middle are as near
  CHECK(
      rig.body.point().position ==
      rig.loaded->surface.nearest(middle() + Vec3{0, 0, rig.loaded->surface.diagonal()}).position);
  rig.set_point({.1, 0, 0});
  const Vec3 set = rig.body.point().position;
  rig.rebuild(); // the same body again
  CHECK(rig.body.point().position == set);
  rig.exchange(inclined(.2));
  CHECK(norm(rig.body.point().position - rig.body.model()->nearest(set).position) < 1e-12);
}

TEST_CASE("of two bodies that are handed over one after the other the second counts") {
  Rig rig;
  auto first = std::make_unique<BodyModel>(rig.loaded, rig.settings);
  auto second = std::make_unique<BodyModel>(rig.loaded, rig.settings);
  const BodyModel* const expected = second.get();
  rig.body.publish(std::move(first), false);
  rig.body.publish(std::move(second), false);
  CHECK(rig.body.model() != expected);
  for (int i = 0; i < 2; ++i) {
    rig.body.adopt();
    CHECK(rig.body.model() == expected);
  }
}

TEST_CASE("a body that is exchanged rings out as one that is silenced, a silent one not at all") {
  const auto play = [](bool struck, bool exchanged, Radiation radiation) {
    Rig rig(kRate, plate(.32, .2, .005, 20000, 16, 10), radiation);
    rig.settings.listener[0] = {.4, .1, 1.5}; // on its way when the body goes
    rig.rebuild(false);
    if (struck)
      rig.hit(kPoint, 1);
    static_cast<void>(rig.run(1024));
    CHECK(rig.body.contacts() == 0);
    if (exchanged)
      rig.exchange(inclined(0));
    else
      rig.body.apply(Reset{});
    return rig.run(ModeBank::kRelease + 1024).left;
  };
  for (const Radiation radiation : {Radiation::kNone, Radiation::kModal}) {
    const auto exchanged = play(true, true, radiation), silenced = play(true, false, radiation);
    CHECK(apart(silenced, exchanged) < 1e-4);
    CHECK(std::abs(silenced.back()) < 1e-7F);
    CHECK(std::abs(exchanged.back()) < 1e-7F);
    CHECK(loudest(play(false, true, radiation)) == 0);
  }
}

TEST_CASE("bodies exchanged while others still ring: the sum of what each would ring out") {
  const auto strike = [](Rig& rig) {
    rig.hit(kPoint, 1);
    static_cast<void>(rig.run(64));
  };
  Rig rig;
  for (int i = 0; i < 3; ++i) {
    strike(rig);
    rig.exchange(inclined(.1 * i));
  }
  const auto all = rig.run(1024).left;
  // The same bodies, each alone, for as long as it is heard.
  std::vector<float> sum(1024, 0);
  for (int i = 0; i < 3; ++i) {
    Rig one;
    if (i > 0)
      one.exchange(inclined(.1 * (i - 1)));
    strike(one);
    one.exchange(inclined(.1 * i));
    static_cast<void>(one.run(static_cast<std::size_t>(64 * (2 - i))));
    const auto output = one.run(1024).left;
    for (std::size_t n = 0; n < sum.size(); ++n)
      sum[n] += output[n];
  }
  CHECK(apart(sum, all) < 1e-5);
}

TEST_CASE("more bodies exchanged while they sound than can fade out leave no step and no leak") {
  Rig rig;
  std::vector<float> sound;
  for (int round = 0; round < 30; ++round) {
    rig.hit({0.05, 0.03, 0}, 0.001); // quiet: what is heard beside it would be a step
    rig.exchange(
        std::make_shared<const LoadedTable>(plate(0.3 + 0.001 * round, 0.2, 0.005, 5000, 8, 8)));
    append(sound, rig.run(100, 50).left);
  }
  CHECK(is_finite(sound));
  CHECK(loudest(sound) < 1);
  CHECK(largest_step(sound) <= loudest(sound));
}

TEST_CASE("a ball that has come to rest stays on a surface that swings, however fast it rises") {
  double fastest = 0; // m/s, upwards, as the ball was found to rest
  for (int phase = 0; phase < 8; ++phase) {
    CAPTURE(phase);
    Rig rig(kRate, mode_table({12}, 5));
    rig.body.set_striker({0.05, 0.02, 206e9, 0.29, 1e7, 1.5, 0, 0.5});
    rig.body.hit({{}, {0, 0, 1}, 1.2});
    static_cast<void>(rig.run(4800 + 500 * static_cast<std::size_t>(phase)));
    rig.body.set_striker({0.0005, 0.003, 1e6, 0.49, 1e5, 1.5, 0, 0.3});
    rig.body.hit({{}, {0, 0, 1}, 0.01, true});
    bool rests = false;
    for (int n = 0; n < 48000 && !rests; ++n) {
      static_cast<void>(rig.run(1, 1));
      const ContactSolver& solver = rig.body.model()->solver;
      for (std::size_t i = 0; i < rig.body.model()->settings.voices; ++i)
        if (solver.contact(i).settled) {
          rests = true;
          fastest = std::max(fastest, -solver.contact(i).exciter.velocity_m_per_s);
        }
    }
    CHECK(rests);
    CHECK(rig.body.flights() == 0);
    CHECK(rig.body.contacts() == 0);
  }
  CHECK(fastest > .02); // would fly for 4 ms
}
