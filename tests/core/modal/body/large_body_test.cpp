// Bodies of thousands of modes: what begins is spread over samples, and memory is bounded.
#include "core/modal/radiation/direct_sound.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

/// A plate of more modes than take each new point at once: its own again, a little higher.
ModalTable crowded_plate() {
  ModalTable table = plate(0.32, 0.2, 0.005, 20000, 4, 4);
  const std::size_t each = table.vertices() * 3;
  for (std::size_t k = 0; table.modes() <= EventSchedule::kMaxUnthrottledModes; ++k) {
    table.frequency_hz.push_back(table.frequency_hz.back() + 0.1);
    table.loss_factor.push_back(1e-3);
    const auto begin = table.shape.begin() + static_cast<std::ptrdiff_t>(k * each);
    const std::vector<float> shape(begin, begin + static_cast<std::ptrdiff_t>(each));
    table.shape.insert(table.shape.end(), shape.begin(), shape.end());
  }
  return table;
}

} // namespace

TEST_CASE("kernels of large bodies keep to their memory") {
  for (const std::size_t modes : {1UL, 400UL, 20000UL, 1000000UL})
    for (const std::size_t vertices : {0UL, 3UL, 9000UL, 2000000UL}) {
      const std::size_t spread = DirectKernels::max_spread(modes, vertices);
      CHECK(spread <= Arrivals::kMaxSpread);
      CHECK(spread >= 64);
      const std::size_t rows = vertices > 0 ? std::min(modes, 3 * vertices) : modes;
      if (rows <= 100000)
        CHECK(2 * rows * (spread + BandLimit::kLength) <= DirectKernels::kMaxNumbers);
    }
  CHECK(DirectKernels::max_spread(400, 9000) == Arrivals::kMaxSpread);
}

TEST_CASE(
    "a crowd of strikes on a large body begins block by block, on a small one at its sample") {
  struct Case {
    std::size_t modes;
    std::int64_t apart; // samples from one beginning to the next, at most
  };
  for (const Case& one : {Case{200, 0}, Case{20000, 64}}) {
    CAPTURE(one.modes);
    Rig rig(kRate, many_modes_table(one.modes));
    rig.settings.listeners = 2;
    rig.settings.voices = 16;
    rig.options.coupled = false;
    rig.rebuild(false);
    static_cast<void>(rig.run(64));
    rig.body.set_striker({.0071, .006, 206e9, .29, 1e3, 1.5, 0, 1}); // soft
    const std::int64_t when = rig.body.clock() + 77;
    for (int i = 0; i < 8; ++i)
      rig.body.schedule(Hit{{}, {0, 0, 1}, 1}, when);
    std::size_t before = 0;
    std::int64_t last = when;
    for (int n = 0; n < 700; ++n) { // sample by sample
      static_cast<void>(rig.run(1, 1));
      const std::size_t now = rig.body.contacts();
      if (now > before) {
        const std::int64_t start_sample = rig.body.clock() - 1;
        CHECK(start_sample >= when);
        CHECK(start_sample - last <= (before == 0 ? 0 : one.apart));
        last = start_sample;
      }
      before = std::max(before, now);
    }
    CHECK(before == 8);
    CHECK(last >= when + 6 * one.apart);
    CHECK(last <= when + 7 * one.apart);
  }
}

TEST_CASE("of force and friction points faster than a large body's rate limit the newest counts") {
  Rig rig(kRate, crowded_plate());
  static_cast<void>(rig.run(64));
  const std::int64_t begin = rig.body.clock();
  const auto& rubbing = rig.body.model()->solver.contact(rig.settings.voices + 1);
  const auto coefficient = [&] { return rubbing.exciter.friction.law().dynamic_coefficient; };
  const auto point_gain = [&] { return static_cast<double>(rig.body.model()->force_gain[0]); };
  Rub rub;
  rub.placed = true;
  for (int i = 0; i < 200; ++i) { // every 4 samples
    const SurfacePoint point = rig.body.model()->nearest({0.0005 * i, 0.01, 0});
    rig.body.schedule(ForcePoint{point, point.normal}, begin + 4 * i);
    rub.point = point;
    rub.law.dynamic_coefficient = 0.3 + 0.001 * i;
    rig.body.schedule(rub, begin + 4 * i);
  }
  int points = 0, rubs = 0;
  double last_gain = point_gain(), last_coefficient = 0;
  for (int n = 0; n < 900; ++n) {
    static_cast<void>(rig.rub(1, 0.1F, 1));
    points += point_gain() != last_gain ? 1 : 0;
    rubs += coefficient() != last_coefficient ? 1 : 0;
    last_gain = point_gain();
    last_coefficient = coefficient();
  }
  for (const int count : {points, rubs}) {
    CHECK(count >= 800 / 64);
    CHECK(count <= 900 / 64 + 2);
  }
  CHECK(rubbing.active);
  CHECK(last_coefficient == approx(0.3 + 0.001 * 199));
  const SurfacePoint newest = rig.body.model()->nearest({0.0005 * 199, 0.01, 0});
  std::vector<double> gain(rig.body.model()->mode.size());
  rig.body.model()->gains(newest, newest.normal, gain);
  CHECK(last_gain == static_cast<double>(static_cast<float>(gain[0])));
}

TEST_CASE("many strikes at once on a large body are one contact and pulses") {
  const ModalTable table = many_modes_table(10000);
  const auto play = [&](std::size_t strikes, std::size_t block) {
    Rig rig(kRate, table);
    rig.body.set_striker({1e-5, 0.002, 1e7, 0.3, 0, 1.5, 0, 1}); // light and soft
    for (std::size_t i = 0; i < strikes; ++i)
      rig.hit({}, 0.1);
    const Output output = rig.run(960, block);
    CHECK(rig.body.contacts() == 0);
    return output;
  };
  const Output one = play(1, 64), two = play(2, 64);
  // The second is struck as on a body at rest: twice the impulse and the sound, as the light
  // striker gives way so little.
  CHECK(std::abs(impulse(two) / impulse(one) - 2) < 0.06);
  std::vector<float> twice = one.left;
  for (float& x : twice)
    x *= 2;
  CHECK(difference_db(std::span(twice).subspan(200), std::span(two.left).subspan(200)) < -30);
  check_same_bits([&](std::size_t block) { return play(2, block).left; }, {1, 50, 960});
}
