// Contacts that are stepped four at a time go on as each of them would alone.
#include "core/contact/excited_body.hpp"
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
/// `unbatched`: each has a second mode, that it moves by nothing worth a bit, so that it is not
/// stepped in fours.
struct SingleModeImpacts {
  SingleModeImpacts(std::size_t count, bool unbatched,
                    tactus::simd::VectorSet widest = tactus::simd::kWidest)
      : body(2 * count + 1, count + 1, 1, widest) {
    body.prepare(kRate);
    tactus::Random random(7);
    std::vector<Mode> modes;
    for (std::size_t i = 0; i <= count; ++i)
      modes.push_back({300 + 3000 * random.uniform(), 0.05 + random.uniform(), 0.02});
    modes.resize(2 * count + 1, {500, 0.1, 0.02});
    body.set_modes(modes);
    std::vector<double> shape(modes.size(), 0.0);
    constexpr double kExponent[] = {1, 1.5, 2, 2.3, 3.5, 1.25};
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = 0.5 + random.uniform();
      shape[count + 1 + i] = unbatched ? 1e-200 : 0;
      body.set_contact_shape(i, shape);
      shape[i] = shape[count + 1 + i] = 0;
      const double exponent = kExponent[i % 6];
      // As stiff as a mass of 10 g and 1 m/s allows in steps of a sample.
      ImpactLaw law{1, exponent, i % 4 == 0 ? 0 : (i % 4 == 1 ? 30 : 0.4) * random.uniform()};
      law.stiffness = 0.005 * (exponent + 1) / std::pow(2e-3, exponent + 1);
      body.set_impact(i, law, 0.005 + 0.01 * random.uniform());
      body.launch_mass(i, 1e-4 * random.uniform(), 0.3 * random.uniform());
    }
    shape[count] = 1;
    body.set_contact_shape(count, shape);
    body.set_impact(count, {}, 0.01); // far away, on a mode of its own
    shape.assign(count, 1.0);
    body.set_pickup(0, shape);
  }
  ExcitedBody body;
};

void check_same(const ExcitedBody& a, const ExcitedBody& b) {
  REQUIRE(a.pickup_velocity() == b.pickup_velocity());
  for (std::size_t i = 0; i < a.exciters(); ++i) {
    REQUIRE(a.force(i) == b.force(i));
    const Exciter &x = a.exciter(i), &y = b.exciter(i);
    if (x.impact.touching()) // far away it is looked at now and then
      REQUIRE(x.depth_m == y.depth_m);
    REQUIRE(x.position_m == y.position_m);
    REQUIRE(x.velocity_m_per_s == y.velocity_m_per_s);
    if (x.impact.touching())
      REQUIRE(x.approach_m_per_s == y.approach_m_per_s);
    REQUIRE(x.impact.stored_j() == y.impact.stored_j());
    REQUIRE(x.impact.energy_account_j() == y.impact.energy_account_j());
    REQUIRE(x.impact_count == y.impact_count);
    REQUIRE(x.last.duration_s == y.last.duration_s);
    REQUIRE(x.last.impulse_ns == y.last.impulse_ns);
    REQUIRE(x.last.peak_n == y.last.peak_n);
    REQUIRE(x.ongoing.impulse_ns == y.ongoing.impulse_ns);
  }
}

} // namespace

namespace {

void check_fours(std::size_t count) {
  SingleModeImpacts batched(count, false), single(count, true),
      baseline(count, false, tactus::simd::VectorSet::kBaseline);
  tactus::Random random(3);
  std::size_t touching = 0;
  for (int n = 0; n < 6000; ++n) {
    const std::size_t slot = static_cast<std::size_t>((n % 50 == 2 ? n - 1 : n) * 7919) % count;
    // Weights, pulls that lift off, some within a step, and pushes.
    const double force = n % 50 == 1   ? -400
                         : n % 50 == 2 ? 390
                         : n % 3 == 0  ? 8 * random.uniform() - 4
                                       : 0.3;
    const bool impulse_now = n % 500 == 499, change = n % 700 == 699;
    for (SingleModeImpacts* p : {&batched, &single, &baseline}) {
      p->body.set_mass_force(slot, force);
      if (impulse_now)
        p->body.apply_impulse(slot, 1e-4);
      if (change) {
        p->body.set_impact(slot, {2e4, 1.5, 0.1}, 0.01);
        p->body.set_mass_force(slot, 1);
      }
      p->body.step();
    }
    if (n % 16 < 3 || n > 5900) {
      check_same(batched.body, single.body);
      check_same(batched.body, baseline.body);
    }
    for (std::size_t i = 0; i < count; ++i)
      touching += batched.body.force(i) > 0;
  }
  CHECK(touching > 500 * count); // what this is about
  CHECK(touching < 5900 * count);
  std::size_t impact_count = 0;
  for (std::size_t i = 0; i < count; ++i)
    impact_count += batched.body.exciter(i).impact_count;
  CHECK(impact_count > count);
}

} // namespace

TEST_CASE("pebbles that bounce and press go on in fours as each does alone") {
  for (const std::size_t count : {2U, 5U, 8U})
    check_fours(count);
}
TEST_CASE("37 pebbles go on in fours as each does alone" * doctest::test_suite("slow")) {
  check_fours(37);
}

TEST_CASE("a pebble that is pressed harder than its steps allow leaves the fours in time") {
  // A light mass on a stiff contact: steps of a sample at rest, finer ones once it is pushed.
  const auto run = [](unsigned min_steps) {
    ExcitedBody body(9, 9);
    body.prepare(kRate);
    body.set_modes(std::vector<Mode>(9, Mode{800, 0.3, 0.05}));
    std::vector<double> shape(9, 0.0), forces;
    for (std::size_t i = 0; i < 9; ++i) {
      shape[i] = 1;
      body.set_contact_shape(i, shape);
      shape[i] = 0;
      body.set_impact(i, {3e8, 2.2, 0.2}, 0.002);
      body.launch_mass(i, 0, 0.01);
      body.set_mass_force(i, 0.2);
    }
    body.set_min_steps(min_steps);
    unsigned maximum = 0;
    for (int n = 0; n < 3000; ++n) {
      if (n == 1500)
        body.set_mass_force(4, 500);
      body.step();
      maximum = std::max(maximum, body.steps());
      forces.push_back(body.force(4));
      REQUIRE(std::isfinite(body.energy()));
    }
    CHECK(maximum > 1);
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
