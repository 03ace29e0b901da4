// Contacts that are stepped four at a time go on as each of them would alone.
#include "core/contact/touched_body.hpp"
#include "core/dsp/random.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <doctest/doctest.h>
#include <vector>

using namespace tactus::contact;

namespace {

constexpr double kRate = 48000;

/// Pebbles of one mode each, laws of all powers; and a mass far away from another mode.
class Pebbles {
public:
  Pebbles(std::size_t count, bool one_at_a_time) : body(count + 1, count + 1), one_(one_at_a_time) {
    body.prepare(kRate);
    tactus::Random random(7);
    std::vector<Mode> modes;
    for (std::size_t i = 0; i <= count; ++i)
      modes.push_back({300 + 3000 * random.uniform(), 0.05 + random.uniform(), 0.02});
    body.set_modes(modes);
    std::vector<double> shape(count + 1, 0.0);
    constexpr double kExponent[] = {1, 1.5, 2, 2.3, 3.5, 1.25};
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = 0.5 + random.uniform();
      body.set_place(i, shape);
      shape[i] = 0;
      const double exponent = kExponent[i % 6];
      // As stiff as a mass of 10 g and 1 m/s allows in steps of a sample.
      ImpactLaw law{1, exponent, i % 4 == 0 ? 0 : (i % 4 == 1 ? 30 : 0.4) * random.uniform()};
      law.stiffness = 0.005 * (exponent + 1) / std::pow(2e-3, exponent + 1);
      body.set_impact(i, law, 0.005 + 0.01 * random.uniform());
      body.throw_mass(i, 1e-4 * random.uniform(), 0.3 * random.uniform());
    }
    shape[count] = 1;
    body.set_place(count, shape);
    body.set_impact(count, {}, 0.01); // far away, on a mode of its own
    shape.assign(count + 1, 1.0);
    shape[count] = 0;
    body.set_ear(0, shape);
  }
  void step() {
    if (one_) // with an outer force each contact is taken alone; no pebble feels this one
      body.push_body(body.exciters() - 1, 1e-280);
    body.step();
  }
  TouchedBody body;

private:
  bool one_;
};

void check_same(const TouchedBody& a, const TouchedBody& b) {
  REQUIRE(a.hear() == b.hear());
  for (std::size_t i = 0; i < a.exciters(); ++i) {
    REQUIRE(a.force(i) == b.force(i));
    const Exciter &x = a.exciter(i), &y = b.exciter(i);
    if (x.impact.touching()) // far away it is looked at now and then
      REQUIRE(x.depth_m == y.depth_m);
    REQUIRE(x.place_m == y.place_m);
    REQUIRE(x.velocity_m_per_s == y.velocity_m_per_s);
    if (x.impact.touching())
      REQUIRE(x.approach_m_per_s == y.approach_m_per_s);
    REQUIRE(x.impact.stored_j() == y.impact.stored_j());
    REQUIRE(x.impact.bank_j() == y.impact.bank_j());
    REQUIRE(x.blows == y.blows);
    REQUIRE(x.last.duration_s == y.last.duration_s);
    REQUIRE(x.last.impulse_ns == y.last.impulse_ns);
    REQUIRE(x.last.highest_n == y.last.highest_n);
    REQUIRE(x.open.impulse_ns == y.open.impulse_ns);
  }
}

} // namespace

TEST_CASE("pebbles that bounce and press go on in fours as each does alone") {
  for (const std::size_t count : {2U, 5U, 8U, 37U}) {
    Pebbles fours(count, false), ones(count, true), baseline(count, false);
    baseline.body.use_baseline();
    tactus::Random random(3);
    std::size_t touching = 0;
    for (int n = 0; n < 6000; ++n) {
      const std::size_t slot = static_cast<std::size_t>((n % 50 == 2 ? n - 1 : n) * 7919) % count;
      // Weights, pulls that lift off, some within a step, and pushes.
      const double force = n % 50 == 1   ? -400
                           : n % 50 == 2 ? 390
                           : n % 3 == 0  ? 8 * random.uniform() - 4
                                         : 0.3;
      const bool knock = n % 500 == 499, change = n % 700 == 699;
      for (Pebbles* p : {&fours, &ones, &baseline}) {
        p->body.push_mass(slot, force);
        if (knock)
          p->body.knock_body(slot, 1e-4);
        if (change) {
          p->body.set_impact(slot, {2e4, 1.5, 0.1}, 0.01);
          p->body.push_mass(slot, 1);
        }
        p->step();
      }
      if (n % 16 < 3 || n > 5900) {
        check_same(fours.body, ones.body);
        check_same(fours.body, baseline.body);
      }
      for (std::size_t i = 0; i < count; ++i)
        touching += fours.body.force(i) > 0;
    }
    CHECK(touching > 500 * count); // what this is about
    CHECK(touching < 5900 * count);
    std::size_t blows = 0;
    for (std::size_t i = 0; i < count; ++i)
      blows += fours.body.exciter(i).blows;
    CHECK(blows > count);
  }
}

TEST_CASE("energy of pebbles in contact only falls, to rounding") {
  Pebbles pebbles(40, false);
  double before = pebbles.body.energy();
  const double all = before;
  for (int n = 0; n < 4000; ++n) {
    pebbles.step();
    const double now = pebbles.body.energy();
    REQUIRE(now <= before + 1e-14 * all);
    before = now;
  }
  CHECK(before < 0.99 * all);
}

TEST_CASE("a pebble among many presses as one that is alone does") {
  // Static: force of a weight, depth (F/k)^(1/a).
  Pebbles pebbles(9, false);
  for (std::size_t i = 0; i < 9; ++i) {
    pebbles.body.set_impact(i, {1e5, 1.5, 20}, 0.01);
    pebbles.body.throw_mass(i, 0, 0);
    pebbles.body.push_mass(i, 0.5 + 0.1 * static_cast<double>(i));
  }
  for (int n = 0; n < 96000; ++n)
    pebbles.step();
  for (std::size_t i = 0; i < 9; ++i) {
    const double weight = 0.5 + 0.1 * static_cast<double>(i);
    CHECK(std::abs(pebbles.body.force(i) / weight - 1) < 1e-6);
    const double depth = std::pow(weight / 1e5, 1 / 1.5);
    CHECK(std::abs(pebbles.body.exciter(i).depth_m / depth - 1) < 1e-4);
  }
}

TEST_CASE("a pebble that is pressed harder than its steps allow leaves the fours in time") {
  // A light mass on a stiff contact: steps of a sample at rest, finer ones once it is pushed.
  const auto run = [](unsigned least_steps) {
    TouchedBody body(9, 9);
    body.prepare(kRate);
    body.set_modes(std::vector<Mode>(9, Mode{800, 0.3, 0.05}));
    std::vector<double> shape(9, 0.0), forces;
    for (std::size_t i = 0; i < 9; ++i) {
      shape[i] = 1;
      body.set_place(i, shape);
      shape[i] = 0;
      body.set_impact(i, {3e8, 2.2, 0.2}, 0.002);
      body.throw_mass(i, 0, 0.01);
      body.push_mass(i, 0.2);
    }
    body.set_least_steps(least_steps);
    unsigned most = 0;
    for (int n = 0; n < 3000; ++n) {
      if (n == 1500)
        body.push_mass(4, 500);
      body.step();
      most = std::max(most, body.steps());
      forces.push_back(body.force(4));
      REQUIRE(std::isfinite(body.energy()));
    }
    CHECK(most > 1);
    return forces;
  };
  const std::vector<double> chosen = run(1), fine = run(64);
  double error = 0, all = 0;
  for (std::size_t n = 1500; n < 1800; ++n) {
    error += (chosen[n] - fine[n]) * (chosen[n] - fine[n]);
    all += fine[n] * fine[n];
  }
  CHECK(error < 1e-3 * all);
}
