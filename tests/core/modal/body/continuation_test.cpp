// A body that is solved anew in another shape while it rings: energy, sound and places go on.
#include "core/modal/table/resolved_modes.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

/// A plate of sides a and b in closed form, its modes by frequency, and (m, n) of each.
struct Plate {
  ModalTable table;
  std::vector<std::pair<int, int>> number;
};

Plate simply_supported(double a, double b, std::size_t modes) {
  Plate plate{test::plate(a, b, .005, 6000, 16, 12), {}};
  ModalTable& t = plate.table;
  std::vector<std::pair<double, std::pair<int, int>>> order;
  for (int m = 1; m < 30; ++m)
    for (int n = 1; n < 30; ++n)
      order.push_back({m * m / (a * a) + n * n / (b * b), {m, n}});
  std::sort(order.begin(), order.end());
  REQUIRE(t.modes() >= modes);
  t.frequency_hz.resize(modes);
  t.loss_factor.resize(modes);
  t.shape.resize(modes * t.vertices() * 3);
  for (std::size_t k = 0; k < modes; ++k)
    plate.number.push_back(order[k].second);
  return plate;
}

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

double energy(Rig& rig) {
  const BodyModel& m = *rig.body.model();
  auto& bank = const_cast<ModeBank&>(m.bank); // states are brought to the present
  bank.flush_pending();
  double sum = 0;
  for (std::size_t k = 0; k < m.audible_modes; ++k)
    sum += .5 * std::norm(bank.state(k));
  return sum;
}

double state_of(Rig& rig, std::size_t mode_of_table) {
  const BodyModel& m = *rig.body.model();
  auto& bank = const_cast<ModeBank&>(m.bank);
  bank.flush_pending();
  return std::abs(bank.state(m.index_of[mode_of_table]));
}

void continue_with(Rig& rig, ModalTable table, std::vector<ModeShare> share) {
  rig.loaded = std::make_shared<const LoadedTable>(std::move(table), *rig.loaded, std::move(share));
  rig.rebuild();
}

double largest_step(const std::vector<float>& x, std::size_t from, std::size_t to) {
  float maximum = 0;
  for (std::size_t n = from + 1; n < to; ++n)
    maximum = std::max(maximum, std::abs(x[n] - x[n - 1]));
  return static_cast<double>(maximum);
}

constexpr std::size_t kModes = 12;

} // namespace

TEST_CASE("modes of a plate that change order when it is stretched go on as themselves") {
  // (1, 3) and (2, 1) cross as the plate of 320 x 200 becomes 320 x 340.
  const Plate before = simply_supported(.32, .2, kModes), now = simply_supported(.32, .34, kModes);
  REQUIRE(before.number != now.number);
  Rig rig(kRate, before.table);
  rig.hit({.06, .03, 0}, 1);
  static_cast<void>(rig.run(9600));
  REQUIRE(rig.body.contacts() == 0);
  std::vector<double> size;
  for (std::size_t k = 0; k < kModes; ++k)
    size.push_back(state_of(rig, k));
  const auto share = shares(before, now);
  REQUIRE(share.size() >= 6);
  REQUIRE(share.size() < kModes); // some have no successor
  continue_with(rig, now.table, share);
  double kept = 0;
  bool crossed = false;
  for (const ModeShare& s : share) {
    CHECK(state_of(rig, s.now) == approx(size[s.before]).epsilon(1e-5));
    kept += .5 * size[s.before] * size[s.before];
    crossed = crossed || s.before != s.now;
  }
  CHECK(crossed);
  CHECK(energy(rig) == approx(kept).epsilon(1e-5)); // what has no successor is apart
}

TEST_CASE("an exchange of modes does not click and does not raise the energy") {
  for (const auto radiation : {Radiation::kNone, Radiation::kModal}) {
    CAPTURE(static_cast<int>(radiation));
    const Plate before = simply_supported(.32, .2, kModes),
                now = simply_supported(.32, .22, kModes);
    Rig rig(kRate, before.table);
    rig.settings.radiation = radiation;
    rig.settings.listener[0] = {.05, .04, .6};
    rig.rebuild();
    rig.hit({.06, .03, 0}, 1);
    static_cast<void>(rig.run(14400));
    const double whole = energy(rig);
    auto share = shares(before, now);
    share.erase(share.begin() + 1); // as if the second mode had no successor
    auto output = rig.run(4800).left;
    const double steady = largest_step(output, 0, 4800);
    continue_with(rig, now.table, share);
    CHECK(energy(rig) < whole);
    CHECK(energy(rig) > .01 * whole);
    const auto after = rig.run(9600).left;
    CHECK(std::abs(after[0] - output.back()) < 1.2 * steady);
    output.insert(output.end(), after.begin(), after.end());
    CHECK(largest_step(output, 4700, output.size()) < 1.5 * steady);
    CHECK(rig.body.contacts() == 0);
  }
}

TEST_CASE("a mode without a successor fades within 1024 samples, the others sound as if alone") {
  const Plate plate = simply_supported(.32, .2, 3);
  const auto all = [&](bool lose) {
    Rig rig(kRate, plate.table);
    rig.hit({.06, .03, 0}, 1);
    static_cast<void>(rig.run(9600));
    std::vector<ModeShare> share{{0, 0, 1}, {1, 1, 1}, {2, 2, 1}};
    if (lose)
      share.erase(share.begin() + 1);
    continue_with(rig, plate.table, share);
    return rig.run(9600).left;
  };
  const auto whole = all(false), less = all(true);
  CHECK(std::abs(whole[0] - less[0]) < 1e-4F * std::abs(whole[0]) + 1e-9F); // no step
  // What is missing is the second mode: a tone of its frequency, that begins with half a cosine.
  const double omega = 2 * std::numbers::pi * plate.table.frequency_hz[1] / kRate;
  const auto amplitude = [&](std::size_t from, std::size_t count) { // of the missing tone
    std::complex<double> sum = 0;
    for (std::size_t n = from; n < from + count; ++n) {
      const double window = 1 - std::cos(2 * std::numbers::pi * static_cast<double>(n - from) /
                                         static_cast<double>(count));
      sum += window * static_cast<double>(whole[n] - less[n]) *
             std::polar(1.0, -omega * static_cast<double>(n));
    }
    return std::abs(sum) / static_cast<double>(count);
  };
  const double early = amplitude(1200, 2400), late = amplitude(6000, 2400);
  CHECK(early > 0);
  // It decays as the mode does, alpha = omega eta/2: what is taken away is the mode and no more.
  const double decay = std::exp(-.5 * omega * 1e-3 * 4800);
  CHECK(late / early == approx(decay).epsilon(.02));
  float rest = 0, sound = 0;
  for (std::size_t n = 0; n < 200; ++n) {
    rest = std::max(rest, std::abs(whole[n] - less[n]));
    sound = std::max(sound, std::abs(whole[n]));
  }
  CHECK(rest < .12F * sound); // 1 - (1 + cos(pi 200/1024))/2 = 0.09
}

TEST_CASE("where a mode's weight changes sign at the exchange it glides from its old value") {
  const Plate plate = simply_supported(.32, .2, 1);
  Rig rig(kRate, plate.table);
  rig.hit({.06, .03, 0}, 1);
  auto output = rig.run(9600).left;
  const double steady = largest_step(output, 4800, 9600);
  continue_with(rig, plate.table, {{0, 0, -1}}); // the same shape, said to be the opposite motion
  const auto after = rig.run(4800).left;
  CHECK(std::abs(after[0] - output.back()) < 1.2 * steady);
  CHECK(largest_step(after, 0, 4800) < 1.2 * steady);
  Rig same(kRate, plate.table); // in the end it is heard with the new sign
  same.hit({.06, .03, 0}, 1);
  static_cast<void>(same.run(9600));
  const auto whole = same.run(4800).left;
  CHECK(std::abs(after[4700] + whole[4700]) < 1e-3F * std::abs(whole[4700]) + 1e-7F);
}

TEST_CASE("two modes that mix are rotated into each other with their energy and their sound") {
  Plate plate = simply_supported(.32, .2, 4);
  plate.table.frequency_hz = {400, 401, 900, 1500};
  Rig rig(kRate, plate.table);
  rig.hit({.06, .03, 0}, 1);
  static_cast<void>(rig.run(9600));
  const double c = std::cos(.7), s = std::sin(.7), whole = energy(rig);
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
  const std::vector<ModeShare> own{{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {3, 3, 1}},
      mixed{{0, 0, c}, {1, 0, s}, {0, 1, -s}, {1, 1, c}, {2, 2, 1}, {3, 3, 1}};
  Rig other(kRate, plate.table);
  other.hit({.06, .03, 0}, 1);
  static_cast<void>(other.run(9600));
  continue_with(rig, turned, mixed);
  continue_with(other, equal, own);
  CHECK(energy(rig) == approx(whole).epsilon(1e-5));
  const auto a = rig.run(9600).left, b = other.run(9600).left;
  float maximum = 0, difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    maximum = std::max(maximum, std::abs(b[i]));
    difference = std::max(difference, std::abs(a[i] - b[i]));
  }
  CHECK(maximum > 0);
  CHECK(static_cast<double>(difference / maximum) < 2e-4); // single precision of bank and shapes
}

TEST_CASE("a contact continues through an exchange: its impulse is that of the strike") {
  const Plate before = simply_supported(.32, .2, kModes), now = simply_supported(.32, .202, kModes);
  const auto struck = [&](bool exchange) {
    Rig rig(kRate, before.table);
    rig.body.set_striker({.05, .02, 1e7, .4}); // soft: some milliseconds
    rig.hit({.06, .03, 0}, 1);
    Output output = rig.run(64);
    REQUIRE(rig.body.contacts() == 1);
    if (exchange)
      continue_with(rig, now.table, shares(before, now));
    CHECK(rig.body.contacts() == 1);
    const Output rest = rig.run(4800);
    CHECK(rig.body.contacts() == 0);
    output.contact.insert(output.contact.end(), rest.contact.begin(), rest.contact.end());
    return impulse(output, kRate);
  };
  CHECK(struck(true) == approx(struck(false)).epsilon(.03)); // by 1 % of stiffer plate
}

TEST_CASE("the force inlet's point stays on the same material point of the surface") {
  const Plate before = simply_supported(.32, .2, kModes), now = simply_supported(.32, .22, kModes);
  Rig rig(kRate, before.table);
  const SurfacePoint at = rig.body.model()->nearest({.08, .05, 0});
  rig.body.set_point(at, at.normal);
  continue_with(rig, now.table, shares(before, now));
  const SurfacePoint& point = rig.body.point();
  CHECK(point.triangle == at.triangle);
  CHECK(point.position.y == approx(1.1 * at.position.y).epsilon(1e-6));
  CHECK(point.position.x == approx(at.position.x).epsilon(1e-6));
}

TEST_CASE("a table that follows no other is another body: it begins silent") {
  const Plate before = simply_supported(.32, .2, kModes);
  Rig rig(kRate, before.table);
  rig.hit({.06, .03, 0}, 1);
  static_cast<void>(rig.run(4800));
  rig.loaded = std::make_shared<const LoadedTable>(before.table);
  rig.rebuild();
  CHECK(energy(rig) == 0);
}

// ---- what the program answers
