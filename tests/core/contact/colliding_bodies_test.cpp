#include "core/contact/excited_body.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

// Several vibrating bodies that touch each other: their modes stand in one list, and a contact is a
// place with shapes on two of them.

using namespace tactus::contact;
using tactus::test::approx;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRate = 48000;

/// A free bar, square and slender, that is met at its middle from below and from above: rigid
/// motion and the symmetric bending modes, (n + 1/2) pi = beta l/2, of unit shape at the middle's
/// antinode.
struct Bar {
  double mass_kg, fundamental_hz;
  int bending;
};

/// Bars one above the other, a contact between neighbours, gaps in between.
class BarStack {
public:
  BarStack(const std::vector<Bar>& bars, const ImpactLaw& law, double gap_m, double t60 = 3)
      : bars_(bars), first_(1, 0), body_(count(bars), bars.size() - 1, bars.size()) {
    std::vector<Mode> modes;
    for (const Bar& bar : bars) {
      modes.push_back({0, 1, bar.mass_kg});
      for (int n = 0; n < bar.bending; ++n)
        modes.push_back({bar.fundamental_hz * std::pow((4 * n + 3) / 3., 2), t60, bar.mass_kg / 4});
      first_.push_back(modes.size());
    }
    body_.prepare(kRate);
    body_.set_modes(modes);
    for (std::size_t i = 0; i + 1 < bars.size(); ++i) {
      // Pressed downwards into the lower bar and upwards into the upper one.
      std::vector<double> shape(modes.size(), 0.0);
      for (std::size_t k = first_[i]; k < first_[i + 1]; ++k)
        shape[k] = -shape_of(k - first_[i]);
      for (std::size_t k = first_[i + 1]; k < first_[i + 2]; ++k)
        shape[k] = shape_of(k - first_[i + 1]);
      body_.set_contact_shape(i, shape);
      body_.set_held(i, law);
      body_.launch_mass(i, gap_m, 0);
    }
    // A listener at each bar's rigid motion, and a hand there.
    for (std::size_t i = 0; i < bars.size(); ++i) {
      std::vector<double> shape(modes.size(), 0.0);
      shape[first_[i]] = 1;
      body_.set_pickup(i, shape);
    }
  }
  /// Gives a bar's rigid motion a velocity (upwards).
  void set_off(std::size_t bar, double speed) { body_.set_modal_velocity(first_[bar], speed); }
  [[nodiscard]] double speed(std::size_t bar) const { return body_.pickup_velocity(bar); }
  [[nodiscard]] double momentum() const {
    double sum = 0;
    for (std::size_t i = 0; i < bars_.size(); ++i)
      sum += bars_[i].mass_kg * speed(i);
    return sum;
  }
  ExcitedBody& body() { return body_; }

private:
  static std::size_t count(const std::vector<Bar>& bars) {
    std::size_t sum = 0;
    for (const Bar& bar : bars)
      sum += 1 + static_cast<std::size_t>(bar.bending);
    return sum;
  }
  static double shape_of(std::size_t mode) { return mode == 0 ? 1 : (mode % 2 ? -.6 : .6); }
  std::vector<Bar> bars_;
  std::vector<std::size_t> first_;
  ExcitedBody body_;
};

} // namespace

TEST_CASE("two free bodies that collide keep momentum and energy to rounding, at any stiffness") {
  for (const double stiffness : {1e5, 1e8, 1e11})
    for (const double loss : {0., .4}) {
      CAPTURE(stiffness);
      CAPTURE(loss);
      BarStack stack({{.3, 310, 5}, {.2, 470, 4}}, {stiffness, 1.5, loss}, 1e-5, 1e4);
      stack.set_off(1, -1.3);
      stack.set_off(0, .4);
      const double momentum = stack.momentum(), energy = stack.body().energy();
      double before = energy, growth = 0, drift = 0;
      for (int n = 0; n < 9600; ++n) {
        stack.body().step();
        growth = std::max(growth, stack.body().energy() - before);
        before = stack.body().energy();
        drift = std::max(drift, std::abs(stack.momentum() - momentum));
      }
      CHECK(growth < 1e-13 * energy);
      CHECK(drift < 1e-13 * (.3 * .4 + .2 * 1.3));
      if (loss == 0) // modes that decay over hours: nothing is lost
        CHECK(before == approx(energy).epsilon(2e-3));
      CHECK(stack.speed(1) > stack.speed(0)); // they have parted
    }
}

TEST_CASE("two rigid bodies part with the restitution of their law") {
  for (const double mu : {0., .2, 1.}) {
    BarStack stack({{.3, 310, 0}, {.2, 470, 0}}, {1e7, 1.5, mu}, 1e-5);
    stack.set_off(1, -1.3);
    for (int n = 0; n < 960; ++n)
      stack.body().step();
    const double e = restitution(mu * 1.3), centre = -.2 * 1.3 / .5;
    CHECK(stack.speed(1) == approx(centre + .3 / .5 * e * 1.3).epsilon(1e-3));
    CHECK(stack.speed(0) == approx(centre - .2 / .5 * e * 1.3).epsilon(1e-3));
  }
}

TEST_CASE(
    "a row of five equal bodies hands a strike to the last, and a chain that swings keeps its "
    "energy") {
  // Newton's cradle with gaps: one impact after the other, each exchanges the speeds.
  BarStack rigid({{.2, 400, 0}, {.2, 400, 0}, {.2, 400, 0}, {.2, 400, 0}, {.2, 400, 0}},
                 {1e8, 1.5, 0}, 1e-3);
  rigid.set_off(0, 1);
  for (int n = 0; n < 4800; ++n)
    rigid.body().step();
  CHECK(rigid.speed(4) == approx(1).epsilon(1e-3));
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(std::abs(rigid.speed(i)) < 2e-3);

  BarStack vibrating({{.2, 400, 3}, {.1, 520, 3}, {.3, 330, 3}, {.2, 700, 3}, {.15, 610, 3}},
                     {3e8, 1.5, .1}, 2e-4);
  vibrating.set_off(0, 1.5);
  vibrating.set_off(4, -.5);
  const double momentum = vibrating.momentum(), energy = vibrating.body().energy();
  double before = energy, growth = 0;
  for (int n = 0; n < 48000; ++n) {
    vibrating.body().step();
    growth = std::max(growth, vibrating.body().energy() - before);
    before = vibrating.body().energy();
  }
  CHECK(growth < 1e-13 * energy);
  CHECK(std::abs(vibrating.momentum() - momentum) < 1e-12);
  for (std::size_t i = 0; i + 1 < 5; ++i)
    CHECK(vibrating.body().exciter(i).impact_count > 0);
}

TEST_CASE("a held striker that presses slowly feels the law in series with the body's stiffness") {
  // One mode: F = k (x - F c)^a at rest, c = sum b^2/(omega^2 + d^2).
  const double omega = 2 * kPi * 300, mass = .5, decay = 6.907755278982137 / .2;
  ExcitedBody body(1, 1);
  body.prepare(kRate);
  body.set_modes(std::vector<Mode>{{300, .2, mass}});
  const ImpactLaw law{2e7, 1.5, 0};
  body.set_held(0, law);
  body.launch_mass(0, 0, 0);
  body.set_held_velocity(0, 1e-4); // 0.1 mm in a second
  for (int n = 0; n < 48000; ++n)
    body.step();
  body.set_held_velocity(0, 0);
  for (int n = 0; n < 24000; ++n)
    body.step();
  const double compliance = 1 / (mass * (omega * omega + decay * decay)), compression = 1e-4;
  double force = 0;
  for (int i = 0; i < 200; ++i) // the root of a growing function, halved
    force += .5 * (law.force(std::max(compression - force * compliance, 0.), 0) - force) * .2;
  CHECK(body.force(0) == approx(force).epsilon(1e-4));
  body.set_held_velocity(0, -1); // and it lets go
  for (int n = 0; n < 4800; ++n)
    body.step();
  CHECK(body.force(0) == 0);
}
