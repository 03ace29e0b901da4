#include "core/contact/contact_islands.hpp"
#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

// Many separate bodies whose modes stand in one list: contacts that share no mode are islands of
// their own.

using namespace tactus::contact;
using tactus::test::approx;

namespace {

double random(std::mt19937& source, double low, double high) {
  return std::uniform_real_distribution<>(low, high)(source);
}
double log_random(std::mt19937& source, double low, double high) {
  return std::exp(random(source, std::log(low), std::log(high)));
}

/// A body with the strikers that are to meet it.
struct Part {
  struct Striker {
    ImpactLaw law;
    double mass_kg, gap_m, speed_m_per_s, push_n;
    std::vector<double> shape;
  };
  std::vector<Mode> modes;
  std::vector<Striker> strikers;
};

Part random_part(std::mt19937& source, std::size_t modes, std::size_t strikers, double softest,
                 double stiffest) {
  Part part;
  for (std::size_t i = 0; i < modes; ++i)
    part.modes.push_back(
        {log_random(source, 40, 15000), log_random(source, .01, 2), log_random(source, .05, 5)});
  for (std::size_t i = 0; i < strikers; ++i) {
    Part::Striker s{
        {log_random(source, softest, stiffest), random(source, 1, 3), random(source, 0, 1)},
        log_random(source, 1e-3, 1),
        random(source, 0, 1e-3),
        random(source, .1, 3),
        random(source, 0, 20),
        {}};
    for (std::size_t k = 0; k < modes; ++k)
      s.shape.push_back(random(source, -1, 1));
    part.strikers.push_back(s);
  }
  return part;
}

/// Bodies in one list of modes, which are its parts one after another or, `interleaved`, mode by
/// mode in turn; `slots` names the slot of each striker of the first part, then the second...
std::unique_ptr<ExcitedBody> combined_body(const std::vector<Part>& parts, bool interleaved,
                                           const std::vector<std::size_t>& slots) {
  std::vector<std::vector<std::size_t>> at(parts.size());
  std::vector<Mode> modes;
  const auto take = [&](std::size_t part) {
    at[part].push_back(modes.size());
    modes.push_back(parts[part].modes[at[part].size() - 1]);
  };
  if (interleaved) {
    for (std::size_t round = 0; round < 100; ++round)
      for (std::size_t p = 0; p < parts.size(); ++p)
        if (round < parts[p].modes.size())
          take(p);
  } else {
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t k = 0; k < parts[p].modes.size(); ++k)
        take(p);
  }
  auto body = std::make_unique<ExcitedBody>(modes.size(), slots.size(), parts.size());
  body->prepare(48000);
  body->set_modes(modes);
  std::size_t next = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::vector<double> pickup(modes.size(), 0.0);
    for (const std::size_t k : at[p])
      pickup[k] = 1;
    body->set_pickup(p, pickup);
    for (const Part::Striker& s : parts[p].strikers) {
      const std::size_t slot = slots[next++];
      std::vector<double> shape(modes.size(), 0.0);
      for (std::size_t k = 0; k < s.shape.size(); ++k)
        shape[at[p][k]] = s.shape[k];
      body->set_contact_shape(slot, shape);
      body->set_impact(slot, s.law, s.mass_kg);
      body->launch_mass(slot, s.gap_m, s.speed_m_per_s);
      body->set_mass_force(slot, s.push_n);
    }
  }
  return body;
}

std::vector<std::size_t> in_order(std::size_t count) {
  std::vector<std::size_t> slots(count);
  std::iota(slots.begin(), slots.end(), 0);
  return slots;
}
std::size_t strikers(const std::vector<Part>& parts) {
  std::size_t sum = 0;
  for (const Part& part : parts)
    sum += part.strikers.size();
  return sum;
}

/// Bodies of one, few and many modes, met by one, two and several strikers.
std::vector<Part> mixed(std::mt19937& source, double softest, double stiffest) {
  std::vector<Part> parts;
  for (const auto& [modes, count] : std::array<std::array<std::size_t, 2>, 8>{
           {{1, 1}, {3, 1}, {9, 1}, {20, 1}, {1, 2}, {5, 2}, {11, 4}, {2, 6}}})
    parts.push_back(random_part(source, modes, count, softest, stiffest));
  return parts;
}

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

TEST_CASE("bodies in one list of modes do what each does alone") {
  // With the same steps to rounding; with steps of each contact's own to the error of a step, since
  // one contact alone on a body waits before its steps become coarser.
  std::mt19937 source(3);
  for (int set = 0; set < 6; ++set) {
    const bool same_steps = set % 3 < 2;
    const std::vector<Part> parts = mixed(source, 1e4, same_steps ? 1e8 : 1e12);
    for (const bool interleaved : {false, true}) {
      auto all = combined_body(parts, interleaved, in_order(strikers(parts)));
      std::vector<std::unique_ptr<ExcitedBody>> alone;
      for (const Part& part : parts)
        alone.push_back(combined_body({part}, false, in_order(part.strikers.size())));
      if (same_steps) {
        all->set_min_steps(16);
        for (auto& body : alone)
          body->set_min_steps(16);
      }
      std::vector<double> worst(parts.size(), 0), loudest(parts.size(), 0);
      for (int n = 0; n < (same_steps ? 400 : 120); ++n) {
        all->step();
        CHECK((!same_steps || all->steps() == 16));
        for (std::size_t p = 0; p < parts.size(); ++p) {
          alone[p]->step();
          worst[p] =
              std::max(worst[p], std::abs(all->pickup_velocity(p) - alone[p]->pickup_velocity()));
          loudest[p] = std::max(loudest[p], std::abs(alone[p]->pickup_velocity()));
        }
      }
      for (std::size_t p = 0; p < parts.size(); ++p) {
        CAPTURE(set);
        CAPTURE(interleaved);
        CAPTURE(p);
        CHECK(loudest[p] > 1e-6);
        CHECK(worst[p] < (same_steps ? 1e-8 : 2e-2) * loudest[p]);
      }
    }
  }
}

TEST_CASE("forces, outer forces and impulses of bodies in one list are those of each alone") {
  std::mt19937 source(31);
  for (const bool impulses : {false, true}) {
    const std::vector<Part> parts = mixed(source, impulses ? 1e17 : 1e4, impulses ? 1e18 : 1e7);
    auto all = combined_body(parts, false, in_order(strikers(parts)));
    std::vector<std::unique_ptr<ExcitedBody>> alone;
    for (const Part& part : parts)
      alone.push_back(combined_body({part}, false, in_order(part.strikers.size())));
    all->set_min_steps(8);
    for (auto& body : alone)
      body->set_min_steps(8);
    // The first striker of some is a surface that rubs, either way.
    for (std::size_t p = 0, slot = 0; p < parts.size(); slot += parts[p++].strikers.size())
      if (!impulses && p % 2 == 0) {
        const FrictionLaw law{.8, .3, .1, .5, 1e5, 40, .5};
        all->set_friction(slot, law);
        all->rub(slot, 5, p % 4 ? .2 : -.2);
        alone[p]->set_friction(0, law);
        alone[p]->rub(0, 5, p % 4 ? .2 : -.2);
      }
    std::vector<double> worst(parts.size(), 0), strongest(parts.size(), 0);
    for (int n = 0; n < 150; ++n) {
      for (std::size_t p = 0, slot = 0; p < parts.size(); slot += parts[p++].strikers.size())
        if (!impulses) {
          const double force = 30 * std::sin(.2 * n + static_cast<double>(p));
          all->apply_force(slot, force);
          alone[p]->apply_force(0, force);
        }
      all->step();
      for (std::size_t p = 0, slot = 0; p < parts.size(); ++p) {
        alone[p]->step();
        for (std::size_t i = 0; i < parts[p].strikers.size(); ++i, ++slot) {
          worst[p] = std::max(worst[p], std::abs(all->force(slot) - alone[p]->force(i)));
          strongest[p] = std::max(strongest[p], std::abs(alone[p]->force(i)));
        }
      }
    }
    for (std::size_t p = 0; p < parts.size(); ++p) {
      CAPTURE(impulses);
      CAPTURE(p);
      CHECK(strongest[p] > 1e-2);
      CHECK(worst[p] < (impulses ? 1e-4 : 1e-6) * strongest[p]); // which chatter
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
  parts[3].strikers[0].speed_m_per_s = .2;
  for (int i = 0; i < 10; ++i) {
    parts.push_back(random_part(source, 1, 1, 1e4, 2e4));
    parts.back().strikers[0] = {{}, .1, 50, 0, 0, {1}};
  }
  auto all = combined_body(parts, false, in_order(strikers(parts)));
  std::vector<std::unique_ptr<ExcitedBody>> alone;
  for (std::size_t p = 0; p < 4; ++p)
    alone.push_back(combined_body({parts[p]}, false, in_order(parts[p].strikers.size())));
  for (std::size_t k = 0; k < 20; ++k)
    for (const std::size_t p : {0UL, 2UL}) {
      all->set_modal_velocity((p == 0 ? 0 : 30) + k, .1);
      alone[p]->set_modal_velocity(k, .1);
    }
  std::array<double, 4> worst{}, loudest{};
  double force_error = 0, strongest = 0;
  std::size_t changes = 0;
  bool touching = false;
  for (int n = 0; n < 3000; ++n) {
    if (n % 300 == 0) {
      all->launch_mass(2, 1e-4, .2);
      alone[3]->launch_mass(0, 1e-4, .2);
    }
    all->step();
    CHECK(all->steps() == 1);
    for (std::size_t p = 0; p < 4; ++p) {
      alone[p]->step();
      worst[p] =
          std::max(worst[p], std::abs(all->pickup_velocity(p) - alone[p]->pickup_velocity()));
      loudest[p] = std::max(loudest[p], std::abs(alone[p]->pickup_velocity()));
    }
    force_error = std::max(force_error, std::abs(all->force(2) - alone[3]->force(0)));
    strongest = std::max(strongest, all->force(2));
    changes += touching != (all->force(2) > 0);
    touching = all->force(2) > 0;
  }
  for (std::size_t p = 0; p < 4; ++p) {
    CAPTURE(p);
    CHECK(loudest[p] > 1e-4);
    CHECK(worst[p] < 1e-9 * loudest[p]);
  }
  CHECK(strongest > 1);
  CHECK(force_error < 1e-9 * strongest);
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
  const auto max_steps = [](ExcitedBody& body) {
    unsigned steps = 0;
    double before = body.energy(), worst = 0;
    for (int n = 0; n < 100; ++n) {
      body.step();
      steps = n == 0 ? body.steps() : steps; // all touch
      worst = std::max(worst, body.energy() / before - 1);
      before = body.energy();
    }
    CHECK(worst < 1e-12);
    return steps;
  };
  auto crowd = combined_body(parts, false, in_order(300));
  CHECK(max_steps(*crowd) == 4); // 300 contacts of 64 products each, of 2^17
  parts.resize(2);
  auto two = combined_body(parts, false, in_order(2));
  CHECK(max_steps(*two) >= 16);
}

TEST_CASE("an island takes no finer steps because another does") {
  // The hard strike's 64 steps leave the soft contacts' bits as they are without it.
  std::mt19937 source(8);
  const Part soft = random_part(source, 1, 1, 1e4, 1e5), pair = random_part(source, 6, 2, 1e4, 1e5),
             other = random_part(source, 1, 1, 1e4, 1e5);
  Part hard = random_part(source, 7, 2, 1e12, 1e13);
  for (Part::Striker& s : hard.strikers)
    s.gap_m = 0;
  auto without_stiff_part = combined_body({soft, pair, other}, false, in_order(4));
  auto both = combined_body({soft, pair, other, hard}, false, in_order(6));
  unsigned max_steps_without = 0, max_steps = 0;
  bool same = true;
  for (int n = 0; n < 300; ++n) {
    without_stiff_part->step();
    both->step();
    max_steps_without = std::max(max_steps_without, without_stiff_part->steps());
    max_steps = std::max(max_steps, both->steps());
    for (std::size_t i = 0; i < 4; ++i)
      same = same && without_stiff_part->force(i) == both->force(i);
  }
  CHECK(max_steps_without <= 2);
  CHECK(max_steps == 64);
  CHECK(same);
}

TEST_CASE("islands whose contacts change slots give the same bits") {
  std::mt19937 source(14);
  for (int set = 0; set < 4; ++set) {
    const std::vector<Part> parts = mixed(source, 1e4, 1e11);
    std::vector<std::size_t> slots = in_order(strikers(parts));
    auto one = combined_body(parts, set % 2, slots);
    std::shuffle(slots.begin(), slots.end(), source);
    auto other = combined_body(parts, set % 2, slots);
    bool same = true;
    for (int n = 0; n < 1500; ++n) {
      one->step();
      other->step();
      for (std::size_t i = 0; i < slots.size(); ++i)
        same = same && one->force(i) == other->force(slots[i]);
    }
    CHECK(same);
  }
}

TEST_CASE("islands at different levels, with friction, never gain energy") {
  std::mt19937 source(6);
  for (std::size_t set = 0; set < 40; ++set) {
    std::vector<Part> parts = mixed(source, 1e3, std::array{1e8, 1e12, 1e16}[set % 3]);
    for (Part& part : parts)
      for (Part::Striker& s : part.strikers)
        s.push_n = 0;
    auto body = combined_body(parts, set % 2, in_order(strikers(parts)));
    for (const std::size_t i : {0UL, 5UL, 8UL}) {
      body->set_friction(
          i, {.8, .3, .1, .5, log_random(source, 1e3, 1e8), log_random(source, 1, 1e3), .5, 1});
      body->rub(i, log_random(source, .1, 100), 0);
    }
    const double whole = body->energy();
    double before = whole, worst = 0;
    unsigned max_steps = 0;
    for (int n = 0; n < 800; ++n) {
      body->step();
      max_steps = std::max(max_steps, body->steps());
      worst = std::max(worst, (body->energy() - before) / whole);
      before = body->energy();
    }
    CAPTURE(set);
    CHECK(worst < 1e-12);
    CHECK(before < whole);
  }
}

TEST_CASE("rigid chains in one list keep their momentum while links meet and part") {
  // Two chains of five bars, their modes in turn; links touch now and then, so islands merge and
  // part.
  constexpr std::size_t kBars = 10, kOf = 4; // a rigid motion and three bending modes
  std::vector<Mode> modes;
  for (std::size_t bar = 0; bar < kBars; ++bar) {
    const double mass = .1 + .02 * static_cast<double>(bar);
    modes.push_back({0, 1, mass});
    for (const double order : {1., 5.4, 13.3})
      modes.push_back({300 * order + 11 * static_cast<double>(bar), 1e4, mass / 4});
  }
  const std::array<std::array<std::size_t, 5>, 2> chains{{{0, 2, 4, 6, 8}, {1, 3, 5, 7, 9}}};
  ExcitedBody body(modes.size(), 8, kBars);
  body.prepare(48000);
  body.set_modes(modes);
  const std::array<double, kOf> middle{1, -.6, .6, -.6};
  std::size_t link = 0;
  for (const auto& chain : chains)
    for (std::size_t i = 0; i + 1 < chain.size(); ++i, ++link) {
      std::vector<double> shape(modes.size(), 0.0);
      for (std::size_t k = 0; k < kOf; ++k) {
        shape[chain[i] * kOf + k] = -middle[k];
        shape[chain[i + 1] * kOf + k] = middle[k];
      }
      body.set_contact_shape(link, shape);
      body.set_held(link, {3e8, 1.5, 0});
      body.launch_mass(link, 1e-4 * static_cast<double>(1 + link % 3), 0);
    }
  for (std::size_t bar = 0; bar < kBars; ++bar) {
    std::vector<double> shape(modes.size(), 0.0);
    shape[bar * kOf] = 1;
    body.set_pickup(bar, shape);
  }
  body.set_modal_velocity(0, 1.5);
  body.set_modal_velocity(8 * kOf, -.5);
  body.set_modal_velocity(1 * kOf, .3);
  body.set_modal_velocity(9 * kOf, -.9);
  const auto momentum = [&](const std::array<std::size_t, 5>& chain) {
    double sum = 0;
    for (const std::size_t bar : chain)
      sum += modes[bar * kOf].mass_kg * body.pickup_velocity(bar);
    return sum;
  };
  const double first = momentum(chains[0]), second = momentum(chains[1]), energy = body.energy();
  double before = energy, growth = 0, drift = 0;
  std::size_t maximum = 0;
  for (int n = 0; n < 48000; ++n) {
    body.step();
    growth = std::max(growth, body.energy() - before);
    before = body.energy();
    drift = std::max(
        {drift, std::abs(momentum(chains[0]) - first), std::abs(momentum(chains[1]) - second)});
    std::size_t touching = 0;
    for (std::size_t i = 0; i < 8; ++i)
      touching += body.force(i) > 0;
    maximum = std::max(maximum, touching);
  }
  CHECK(growth < 1e-13 * energy);
  CHECK(drift < 1e-12);
  CHECK(before == approx(energy).epsilon(1e-2));
  CHECK(maximum >= 3);
  for (std::size_t i = 0; i < 8; ++i)
    CHECK(body.exciter(i).impact_count > 0);
}

TEST_CASE(
    "bodies in a row that share lanes of vectors move as they do apart, whatever touches them") {
  // 3, 20 and 11 modes: no body begins or ends with a vector but the first. All are touched, so
  // that nothing rings beside them; then the middle one is let go, and all modes ring once a
  // sample.
  const std::size_t counts[] = {3, 20, 11};
  constexpr std::size_t kAll = 34, kEach = 2;
  tactus::Random random(5);
  std::vector<Mode> modes;
  std::vector<std::vector<double>> shape;
  for (const std::size_t count : counts)
    for (std::size_t i = 0; i < count; ++i)
      modes.push_back({100 + 6000 * random.uniform(), 0.02 + random.uniform(), 0.05});
  for (std::size_t e = 0; e < 3 * kEach; ++e) {
    shape.emplace_back();
    for (std::size_t i = 0; i < counts[e / kEach]; ++i)
      shape.back().push_back(0.1 + random.uniform());
  }
  const auto touch = [&](ExcitedBody& body, std::size_t slot, std::size_t e) {
    if (e == 3) {
      body.set_friction(slot, {0.8, 0.3, 0.1, 0.5, 1e5, 5, 0.4});
      body.rub(slot, 5, 0.1);
    } else if (e != 1) { // one body has one contact, the others two
      body.set_impact(slot, {1e7, 1.5, 0.2}, 0.01);
      body.launch_mass(slot, 1e-4, 0.2 + 0.1 * static_cast<double>(e));
      body.set_mass_force(slot, 3);
    }
  };
  for (const bool baseline : {false, true}) {
    ExcitedBody all(kAll, 3 * kEach);
    std::vector<ExcitedBody> apart;
    all.set_modes(modes);
    if (baseline)
      all.use_baseline();
    for (std::size_t b = 0, first = 0; b < 3; first += counts[b++]) {
      ExcitedBody& one = apart.emplace_back(counts[b], kEach);
      one.set_modes({modes.data() + first, counts[b]});
      one.set_min_steps(64);
      for (std::size_t c = 0; c < kEach; ++c) {
        const std::size_t e = kEach * b + c;
        std::vector<double> full(kAll, 0.0);
        std::copy(shape[e].begin(), shape[e].end(),
                  full.begin() + static_cast<std::ptrdiff_t>(first));
        one.set_contact_shape(c, shape[e]);
        all.set_contact_shape(e, full);
        touch(one, c, e);
        touch(all, e, e);
      }
    }
    all.set_min_steps(64);
    double largest = 0, difference = 0;
    for (int n = 0; n < 900; ++n) {
      if (n == 600)
        for (std::size_t c = 0; c < kEach; ++c) {
          all.clear(kEach + c);
          apart[1].clear(c);
        }
      if (n > 100 && n % 50 < 5) {
        all.apply_impulse(0, 0.002);
        apart[0].apply_impulse(0, 0.002);
        all.apply_impulse(4, 0.002);
        apart[2].apply_impulse(0, 0.002);
      }
      if (n > 100 && n % 50 > 30 && n % 3 == 0) {
        all.apply_force(0, 2);
        apart[0].apply_force(0, 2);
      }
      all.step();
      double output = 0;
      for (ExcitedBody& one : apart) {
        one.step();
        output += one.pickup_velocity();
      }
      largest = std::max(largest, std::abs(output));
      difference = std::max(difference, std::abs(output - all.pickup_velocity()));
      for (std::size_t e = 0; e < 3 * kEach; ++e)
        REQUIRE(std::abs(all.force(e) - apart[e / kEach].force(e % kEach)) < 1e-6);
    }
    CHECK(largest > 0.05);
    CHECK(difference < 1e-8 * largest);
  }
}
