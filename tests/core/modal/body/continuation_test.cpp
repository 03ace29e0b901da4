// A body that is solved anew in another shape while it rings: energy, sound and places go on.
#include "core/modal/table/resolved_modes.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// A plate of sides a and b in closed form, its modes by frequency, and (m, n) of each.
struct Plate {
  Plate(double a, double b, std::size_t modes) : table(plate(a, b, .005, 6000, 16, 12)) {
    std::vector<std::pair<double, std::pair<int, int>>> order;
    for (int m = 1; m < 30; ++m)
      for (int n = 1; n < 30; ++n)
        order.push_back({m * m / (a * a) + n * n / (b * b), {m, n}});
    std::sort(order.begin(), order.end());
    REQUIRE(table.modes() >= modes);
    table.frequency_hz.resize(modes);
    table.loss_factor.resize(modes);
    table.shape.resize(modes * table.vertices() * 3);
    for (std::size_t k = 0; k < modes; ++k)
      number.push_back(order[k].second);
  }
  ModalTable table;
  std::vector<std::pair<int, int>> number;
};

constexpr std::size_t kModes = 12;
const Vec3 kPoint{.06, .03, 0};

/// sin(m pi x/a) of a stretched plate are the same functions of the material points: shares are 1
/// for equal (m, n) and 0 for all others.
std::vector<ModeShare> shares(const Plate& before, const Plate& now) {
  std::vector<ModeShare> found;
  for (std::uint32_t j = 0; j < now.number.size(); ++j)
    for (std::uint32_t i = 0; i < before.number.size(); ++i)
      if (before.number[i] == now.number[j])
        found.push_back({i, j, 1});
  return found;
}

/// A plate that was struck 0.2 s ago.
struct Ringing : Rig {
  explicit Ringing(const ModalTable& table) : Rig(kRate, table) {
    hit(kPoint, 1);
    static_cast<void>(run(9600));
    REQUIRE(body.contacts() == 0);
  }
  double state(std::size_t mode_of_table) {
    flush();
    return abs(body.model()->bank.state(body.model()->index_of[mode_of_table]));
  }
  double energy() {
    double sum = 0;
    for (std::size_t k = 0; k < body.model()->audible_modes; ++k)
      sum += .5 * std::pow(state(body.model()->mode[k]), 2);
    return sum;
  }
};

void continue_with(Rig& rig, ModalTable table, std::vector<ModeShare> share) {
  rig.loaded = std::make_shared<const LoadedTable>(std::move(table), *rig.loaded, std::move(share));
  rig.rebuild();
}

} // namespace

TEST_CASE("modes of a plate that change order when it is stretched go on as themselves") {
  // (1, 3) and (2, 1) cross as the plate of 320 x 200 becomes 320 x 340.
  const Plate before(.32, .2, kModes), now(.32, .34, kModes);
  REQUIRE(before.number != now.number);
  Ringing rig(before.table);
  std::vector<double> size;
  for (std::size_t k = 0; k < kModes; ++k)
    size.push_back(rig.state(k));
  const auto share = shares(before, now);
  REQUIRE(share.size() >= 6);
  REQUIRE(share.size() < kModes); // some have no successor
  continue_with(rig, now.table, share);
  double kept = 0;
  bool crossed = false;
  for (const ModeShare& s : share) {
    CHECK(rig.state(s.now) == approx(size[s.before]).epsilon(1e-5));
    kept += .5 * size[s.before] * size[s.before];
    crossed = crossed || s.before != s.now;
  }
  CHECK(crossed);
  CHECK(rig.energy() == approx(kept).epsilon(1e-5)); // what has no successor is apart
}

TEST_CASE("a mode without a successor fades within 1024 samples, the others sound as if alone") {
  const Plate plate(.32, .2, 3);
  const auto all = [&](bool lose) {
    Ringing rig(plate.table);
    std::vector<ModeShare> share{{0, 0, 1}, {1, 1, 1}, {2, 2, 1}};
    if (lose)
      share.erase(share.begin() + 1);
    continue_with(rig, plate.table, share);
    return rig.run(9600).left;
  };
  const auto whole = all(false), less = all(true);
  CHECK(std::abs(whole[0] - less[0]) < 1e-4F * std::abs(whole[0]) + 1e-9F); // no step
  // What is missing is the second mode: a tone of its frequency, that begins with half a cosine.
  std::vector<float> missing(9600);
  for (std::size_t n = 0; n < missing.size(); ++n)
    missing[n] = whole[n] - less[n];
  const double omega = 2 * kPi * plate.table.frequency_hz[1];
  const auto tone = [&](std::size_t from) {
    return abs(amplitude(std::span(missing).subspan(from, 2400), {0, omega}));
  };
  CHECK(tone(1200) > 0);
  // It decays as the mode does, alpha = omega eta/2: what is taken away is the mode and no more.
  CHECK(tone(6000) / tone(1200) == approx(std::exp(-.5 * omega * 1e-3 * .1)).epsilon(.02));
  // 1 - (1 + cos(pi 200/1024))/2 = 0.09
  CHECK(loudest(std::span(missing).first(200)) < .12 * loudest(std::span(whole).first(200)));
}

TEST_CASE("where a mode's weight changes sign at the exchange it glides from its old value") {
  const Plate plate(.32, .2, 1);
  Ringing rig(plate.table), same(plate.table);
  continue_with(rig, plate.table, {{0, 0, -1}}); // the same shape, said to be the opposite motion
  const auto after = rig.run(4800).left, whole = same.run(4800).left;
  CHECK(std::abs(after[0] - whole[0]) < 1e-3F * static_cast<float>(loudest(whole)));
  CHECK(largest_step(after) < 1.2 * largest_step(whole));
  // In the end it is heard with the new sign.
  CHECK(std::abs(after[4700] + whole[4700]) < 1e-3F * std::abs(whole[4700]) + 1e-7F);
}

TEST_CASE("two modes that mix are rotated into each other with their energy and their sound") {
  Plate plate(.32, .2, 4);
  plate.table.frequency_hz = {400, 401, 900, 1500};
  Ringing rig(plate.table), other(plate.table);
  const double c = std::cos(.7), s = std::sin(.7), whole = rig.energy();
  ModalTable turned = plate.table;
  const std::size_t n = turned.vertices() * 3;
  for (std::size_t i = 0; i < n; ++i) { // the shapes of the same motions in the turned basis
    const auto a = static_cast<double>(plate.table.shape[i]),
               b = static_cast<double>(plate.table.shape[n + i]);
    turned.shape[i] = static_cast<float>(c * a + s * b);
    turned.shape[n + i] = static_cast<float>(c * b - s * a);
  }
  turned.frequency_hz[1] = turned.frequency_hz[0] = 400; // nothing tells the bases apart
  ModalTable equal = plate.table;
  equal.frequency_hz[1] = 400;
  continue_with(rig, turned, {{0, 0, c}, {1, 0, s}, {0, 1, -s}, {1, 1, c}, {2, 2, 1}, {3, 3, 1}});
  continue_with(other, equal, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {3, 3, 1}});
  CHECK(rig.energy() == approx(whole).epsilon(1e-5));
  // single precision of bank and shapes
  CHECK(apart(other.run(9600).left, rig.run(9600).left) < 2e-4);
}

TEST_CASE("a contact continues through an exchange: its impulse is that of the strike") {
  const Plate before(.32, .2, kModes), now(.32, .202, kModes);
  const auto struck = [&](bool exchange) {
    Rig rig(kRate, before.table);
    rig.body.set_striker({.05, .02, 1e7, .4}); // soft: some milliseconds
    rig.hit(kPoint, 1);
    Output output = rig.run(64);
    if (exchange)
      continue_with(rig, now.table, shares(before, now));
    CHECK(rig.body.contacts() == 1);
    append(output.contact, rig.run(4800).contact);
    CHECK(rig.body.contacts() == 0);
    return impulse(output);
  };
  CHECK(struck(true) == approx(struck(false)).epsilon(.03)); // by 1 % of stiffer plate
}

TEST_CASE("the force inlet's point stays on the same material point of the surface") {
  const Plate before(.32, .2, kModes), now(.32, .22, kModes);
  Rig rig(kRate, before.table);
  rig.set_point({.08, .05, 0});
  const SurfacePoint at = rig.body.point();
  continue_with(rig, now.table, shares(before, now));
  const SurfacePoint& point = rig.body.point();
  CHECK(point.triangle == at.triangle);
  CHECK(point.position.y == approx(1.1 * at.position.y).epsilon(1e-6));
  CHECK(point.position.x == approx(at.position.x).epsilon(1e-6));
}

TEST_CASE("a table that follows no other is another body: it begins silent") {
  const Plate before(.32, .2, kModes);
  Ringing rig(before.table);
  rig.loaded = std::make_shared<const LoadedTable>(before.table);
  rig.rebuild();
  CHECK(rig.energy() == 0);
}
