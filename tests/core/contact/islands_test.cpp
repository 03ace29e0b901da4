#include "core/contact/contact_islands.hpp"
#include "tests/core/contact/bodies.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

// Many separate bodies whose modes stand in one list: contacts that share no mode are islands of
// their own.

using namespace tactus::contact;
using namespace tactus::test;
using tactus::simd::VectorSet;

namespace {

/// Bodies in one list of modes beside the same bodies each alone.
struct Together {
  std::unique_ptr<ExcitedBody> all;
  std::vector<std::unique_ptr<ExcitedBody>> alone;
  std::vector<std::size_t> first_slot; ///< of each part in the list of all
  struct Compared {
    double velocity_error = 0, velocity = 0, force_error = 0, force = 0;
  };
  std::vector<Compared> compared; ///< largest of each part

  explicit Together(const std::vector<Part>& parts, bool interleaved = false,
                    VectorSet widest = tactus::simd::kWidest)
      : all(combined_body(parts, interleaved, in_order(strikers(parts)), widest)),
        compared(parts.size()) {
    std::size_t slot = 0;
    for (const Part& part : parts) {
      alone.push_back(body_of(part));
      first_slot.push_back(slot);
      slot += part.strikers.size();
    }
  }
  /// Does the same to a contact of a part in both.
  template <class Do> void each(std::size_t part, std::size_t contact, Do act) {
    act(*all, first_slot[part] + contact);
    act(*alone[part], contact);
  }
  void step() {
    all->step();
    for (std::size_t p = 0; p < alone.size(); ++p) {
      ExcitedBody& one = *alone[p];
      one.step();
      Compared& c = compared[p];
      c.velocity_error =
          std::max(c.velocity_error, std::abs(all->pickup_velocity(p) - one.pickup_velocity()));
      c.velocity = std::max(c.velocity, std::abs(one.pickup_velocity()));
      for (std::size_t i = 0; i < one.exciters(); ++i) {
        c.force_error =
            std::max(c.force_error, std::abs(all->force(first_slot[p] + i) - one.force(i)));
        c.force = std::max(c.force, std::abs(one.force(i)));
      }
    }
  }
};

} // namespace

TEST_CASE("contacts are divided by the modes that they share, directly or through others") {
  PointModes points(10, 6);
  points.set(0, std::array{1., 0., 1., 0., 0., 0., 0., 0., 0., 0.});
  points.set(1, std::array{0., 1., 0., 0., 0., 0., 0., 0., 0., 0.});
  points.set(2, std::array{0., 0., 0., 1., 0., 0., 0., 0., 0., 1e-300});
  points.set(3, std::array{0., 0., 1., 1., 0., 0., 0., 0., 0., 0.});
  points.set(4, std::array{0., 0., 0., 0., 0., 0., 0., 0., 0., 0.});
  points.set(5, std::array{0., -1., 0., 0., 0., 0., 0., 0., 0., 0.});
  Islands islands(10, 6);
  const auto slots = [&](std::size_t k) {
    return std::vector(islands.slots(k).begin(), islands.slots(k).end());
  };
  const auto modes = [&](std::size_t k) {
    return std::vector(islands.modes(k).begin(), islands.modes(k).end());
  };
  for (int again = 0; again < 2; ++again) {
    points.divide(std::array<std::size_t, 6>{2, 1, 0, 4, 5, 3}, islands);
    REQUIRE(islands.size() == 3);
    CHECK(slots(0) == std::vector<std::size_t>{2, 0, 3}); // 2 and 0 by way of 3
    CHECK(modes(0) == std::vector<std::uint32_t>{0, 2, 3, 9});
    CHECK(slots(1) == std::vector<std::size_t>{1, 5});
    CHECK(modes(1) == std::vector<std::uint32_t>{1});
    CHECK(slots(2) == std::vector<std::size_t>{4});
    CHECK(modes(2).empty());
    points.divide(std::array<std::size_t, 2>{0, 2}, islands); // without 3 they are apart
    CHECK(islands.size() == 2);
  }
}

TEST_CASE("bodies in one list of modes do what each does alone, whatever touches them") {
  struct Row {
    double softest, stiffest;
    unsigned steps; // 0: each contact's own
    bool pushed;    // by forces; and the first striker of every second body rubs
    int samples;
    double velocity, force; // relative errors allowed
  };
  constexpr double kAny = 1e9;
  std::mt19937 source(3);
  // With the same steps to rounding; with steps of each contact's own to the error of a step, since
  // one contact alone on a body waits before its steps become coarser. Hard contacts chatter.
  for (const Row& row :
       {Row{1e4, 1e8, 16, false, 400, 1e-8, kAny}, Row{1e4, 1e12, 0, false, 120, 2e-2, kAny},
        Row{1e4, 1e7, 8, true, 150, kAny, 1e-6},
        Row{1e17, 1e18, 8, false, 60, kAny, 1e-4}}) // impulses
    for (const bool interleaved : {false, true})
      for (const VectorSet widest : {VectorSet::kBaseline, tactus::simd::kWidest}) {
        const std::vector<Part> parts = mixed(source, row.softest, row.stiffest);
        Together bodies(parts, interleaved, widest);
        bodies.all->set_min_steps(std::max(1U, row.steps));
        for (auto& body : bodies.alone)
          body->set_min_steps(std::max(1U, row.steps));
        for (std::size_t p = 0; p < parts.size() && row.pushed; p += 2)
          bodies.each(p, 0, [&](ExcitedBody& body, std::size_t slot) {
            body.set_friction(slot, {.8, .3, .1, .5, 1e5, 40, .5});
            body.rub(slot, 5, p % 4 ? .2 : -.2);
          });
        for (int n = 0; n < row.samples; ++n) {
          for (std::size_t p = 0; p < parts.size() && row.pushed; ++p)
            bodies.each(p, 0, [&](ExcitedBody& body, std::size_t slot) {
              body.apply_impulse(slot, 30 * std::sin(.2 * n + static_cast<double>(p)) / 48000);
              if (n % 50 == 20)
                body.apply_impulse(slot, .002);
            });
          bodies.step();
        }
        for (std::size_t p = 0; p < parts.size(); ++p) {
          const auto& c = bodies.compared[p];
          CAPTURE(row.stiffest);
          CAPTURE(interleaved);
          CAPTURE(p);
          // Impulses come when they come, and are chaos some time later.
          CHECK((c.force > 1e-2 || row.samples < 100));
          CHECK(c.velocity_error <= row.velocity * c.velocity);
          CHECK(c.force_error <= row.force * c.force);
        }
      }
}

TEST_CASE("bodies ring on beside one that is touched, and while others come and go") {
  // Two ring; a pair of masses is pressed on one between them; a pebble is met now and then, and
  // ten masses are far from others.
  std::mt19937 source(17);
  std::vector<Part> parts{random_part(source, 20, 0, 1, 2), random_part(source, 10, 2, 1e4, 2e4),
                          random_part(source, 20, 0, 1, 2), random_part(source, 1, 1, 1e4, 2e4)};
  for (Part::Striker& s : parts[1].strikers)
    s.push_n = 5, s.mass_kg = .5;
  parts[3].strikers[0].mass_kg = .05;
  for (int i = 0; i < 10; ++i) {
    parts.push_back(random_part(source, 1, 1, 1e4, 2e4));
    parts.back().strikers[0] = {{}, .1, 50, 0, 0, {1}};
  }
  for (const std::size_t p : {0UL, 2UL}) // far masses, at whose contact points they are set off
    parts[p].strikers.push_back({{}, .1, 50, 0, 0, std::vector<double>(20, 1)});
  Together bodies(parts);
  for (const std::size_t p : {0UL, 2UL}) {
    std::vector<double> own(20, .1), all(p == 0 ? 0 : 30, 0.);
    all.insert(all.end(), own.begin(), own.end());
    set_off(*bodies.all, bodies.first_slot[p], all);
    set_off(*bodies.alone[p], 0, own);
  }
  int changes = 0;
  bool touching = false;
  for (int n = 0; n < 3000; ++n) {
    if (n % 300 == 0)
      bodies.each(3, 0,
                  [](ExcitedBody& body, std::size_t slot) { body.launch_mass(slot, 1e-4, .2); });
    bodies.step();
    CHECK(bodies.all->steps() == 1);
    const bool touches = bodies.all->force(bodies.first_slot[3]) > 0;
    changes += touching != touches;
    touching = touches;
  }
  for (std::size_t p = 0; p < 4; ++p) {
    const auto& c = bodies.compared[p];
    CAPTURE(p);
    CHECK(c.velocity > 1e-4);
    CHECK(c.velocity_error < 1e-9 * c.velocity);
    CHECK(c.force_error <= 1e-9 * c.force);
  }
  CHECK(bodies.compared[3].force > 1);
  CHECK(changes > 6);
}

TEST_CASE("the work of a sample is bounded however many islands want fine steps") {
  std::mt19937 source(12);
  std::vector<Part> parts;
  for (int i = 0; i < 300; ++i) {
    parts.push_back(random_part(source, 1, 1, 1e11, 1e11));
    parts.back().modes[0].mass_kg = .01;
    parts.back().strikers[0] = {{1e11, 1.5, .1}, .01, 0, 1, 0, {1}};
  }
  const auto first_steps = [](const std::vector<Part>& touched) { // all touch
    auto body = combined_body(touched, false, in_order(touched.size()));
    body->step();
    return body->steps();
  };
  CHECK(first_steps(parts) == 4); // 300 contacts of 64 products each, of 2^17
  parts.resize(2);
  CHECK(first_steps(parts) >= 16);
}

TEST_CASE("an island takes no finer steps because another does") {
  // The hard strike's 64 steps leave the soft contacts' bits as they are without it.
  std::mt19937 source(8);
  std::vector<Part> parts{random_part(source, 1, 1, 1e4, 1e5), random_part(source, 6, 2, 1e4, 1e5),
                          random_part(source, 1, 1, 1e4, 1e5)};
  auto soft = combined_body(parts, false, in_order(4));
  parts.push_back(random_part(source, 7, 2, 1e12, 1e13, 0));
  auto both = combined_body(parts, false, in_order(6));
  unsigned steps_of_soft = 0, steps_of_both = 0;
  bool same = true;
  for (int n = 0; n < 300; ++n) {
    soft->step();
    both->step();
    steps_of_soft = std::max(steps_of_soft, soft->steps());
    steps_of_both = std::max(steps_of_both, both->steps());
    for (std::size_t i = 0; i < 4; ++i)
      same = same && soft->force(i) == both->force(i);
  }
  CHECK(steps_of_soft <= 2);
  CHECK(steps_of_both == 64);
  CHECK(same);
}

namespace {

/// Bodies met by many: one body with 2 to 64 contacts, and sets of mixed bodies.
std::vector<std::vector<Part>> crowds(std::mt19937& source) {
  std::vector<std::vector<Part>> sets;
  for (const std::size_t contacts : {2UL, 5UL, 12UL, 64UL})
    sets.push_back({random_part(source, 8, contacts, 1e4, 1e10, 1e-4)});
  sets.push_back({random_part(source, 2, 64, 1e4, 1e15, 1e-4)});
  sets.push_back({random_part(source, 64, 64, 1e4, 1e8, 1e-4)});
  for (const double stiffest : {1e8, 1e12, 1e16})
    sets.push_back(mixed(source, 1e3, stiffest));
  return sets;
}

} // namespace

TEST_CASE("contacts that change slots give the same bits, on one body or on many") {
  std::mt19937 source(14);
  bool interleaved = false;
  for (const std::vector<Part>& parts : crowds(source)) {
    std::vector<std::size_t> slots = in_order(strikers(parts));
    auto one = combined_body(parts, interleaved, slots);
    std::shuffle(slots.begin(), slots.end(), source);
    auto other = combined_body(parts, interleaved, slots);
    interleaved = !interleaved;
    bool same = true;
    double loudest = 0;
    for (int n = 0; n < 250; ++n) {
      one->step();
      other->step();
      for (std::size_t i = 0; i < slots.size(); ++i)
        same = same && one->force(i) == other->force(slots[i]);
      same = same && one->pickup_velocity() == other->pickup_velocity();
      loudest = std::max(loudest, std::abs(one->pickup_velocity()));
    }
    CAPTURE(slots.size());
    CHECK(same);
    CHECK(loudest > 1e-4);
  }
}

TEST_CASE("many contacts at different levels, struck and rubbed, never gain energy") {
  std::mt19937 source(6);
  std::size_t impact_count = 0;
  for (const bool interleaved : {false, true})
    for (std::vector<Part>& parts : crowds(source)) {
      for (Part& part : parts)
        for (Part::Striker& s : part.strikers)
          s.push_n = 0;
      const std::size_t contacts = strikers(parts);
      auto body = combined_body(parts, interleaved, in_order(contacts));
      for (std::size_t i = 0; i < contacts; i += 4) { // surfaces at rest: they bring no energy
        body->set_friction(
            i, {.8, .3, .1, .5, log_random(source, 1e3, 1e8), log_random(source, 1, 1e3), .5, 1});
        body->rub(i, log_random(source, .1, 100), 0);
      }
      const double whole = body->energy();
      double before = whole, worst = 0;
      for (int n = 0; n < 600; ++n) {
        body->step();
        worst = std::max(worst, (body->energy() - before) / whole);
        before = body->energy();
      }
      for (std::size_t i = 0; i < contacts; ++i)
        impact_count += body->exciter(i).impact_count;
      CAPTURE(contacts);
      CHECK(worst < 1e-12);
      CHECK(before < whole);
    }
  CHECK(impact_count > 100);
}

TEST_CASE("a copy goes on as its original, on arrays of its own, alone, struck or in islands") {
  std::mt19937 source(7);
  const std::vector<Part> parts = mixed(source, 1e5, 1e9);
  for (std::size_t p = 0; p <= parts.size(); ++p) {
    CAPTURE(p);
    const auto make = [&] {
      return p < parts.size() ? body_of(parts[p])
                              : combined_body(parts, true, in_order(strikers(parts)));
    };
    for (const int before : {0, 30, 200, 3000}) { // in flight, in contact, ringing
      const auto expected = make();
      auto original = make();
      for (int n = 0; n < before; ++n) {
        expected->step();
        original->step();
      }
      ExcitedBody copy(*original);
      copy.prepare(48000);          // as every copy is, before its first sample
      for (int n = 0; n < 300; ++n) // what the original does meanwhile is not the copy's
        original->step();
      original.reset();
      double largest = 0;
      for (int n = 0; n < 300; ++n) {
        expected->step();
        copy.step();
        largest = std::max(largest, std::abs(copy.pickup_velocity() - expected->pickup_velocity()));
      }
      CHECK(largest <= 1e-9 * std::max(1e-3, std::abs(expected->pickup_velocity())));
    }
  }
}
