#include "core/contact/excited_body.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

// Exciters that cannot arrive for some time are not looked at until then.

using namespace tactus::contact;
using tactus::test::approx;

TEST_CASE("a mass that is far flies as gravity says, and arrives when it should") {
  // Alone, the mass is stepped every sample; beside a second, far body it sleeps in between.
  const std::vector<Mode> two{{500, .3, .1}, {800, .3, .1}};
  ExcitedBody alone(2, 1), both(2, 2);
  for (ExcitedBody* body : {&alone, &both}) {
    body->prepare(48000);
    body->set_modes(two);
    for (std::size_t i = 0; i < body->exciters(); ++i) {
      std::vector<double> shape(2, 0.0);
      shape[i] = 1;
      body->set_contact_shape(i, shape);
      body->set_impact(i, {1e6, 1.5, .2}, .01);
      body->launch_mass(i, i == 0 ? .05 : 5, i == 0 ? -.2 : 0);
    }
    body->set_mass_force(0, .01 * 9.81);
  }
  double flight = 0, worst = 0, loudest = 0;
  for (int n = 0; n < 9600; ++n) {
    alone.step();
    both.step();
    const double expected = alone.exciter(0).position_m;
    if (n % 7 == 0) // looking changes nothing
      flight = std::max(flight, std::abs(both.exciter(0).position_m - expected));
    worst = std::max(worst, std::abs(both.pickup_velocity() - alone.pickup_velocity()));
    loudest = std::max(loudest, std::abs(alone.pickup_velocity()));
  }
  CHECK(alone.exciter(0).impact_count > 0);
  CHECK(loudest > 1e-2);
  CHECK(flight < 1e-9);
  CHECK(worst < 1e-6 * loudest);
  CHECK(both.exciter(1).position_m == approx(-5));
}

TEST_CASE("an exciter that sleeps wakes for messages and for what its neighbours do") {
  // Exciter 0 waits a hair above mode 0; exciter 1 moves that mode as well. Exciter 2 makes two
  // separate bodies of it.
  const auto make = [](std::size_t slots) {
    auto body = std::make_unique<ExcitedBody>(2, slots);
    body->prepare(48000);
    body->set_modes(std::array{Mode{100, 1, .1}, Mode{700, 1, .1}});
    for (std::size_t i = 0; i < slots; ++i) {
      body->set_contact_shape(i, std::array{i < 2 ? 1. : 0., i < 2 ? 0. : 1.});
      body->set_impact(i, {1e6, 1.5, .2}, .01);
      body->launch_mass(i, i == 0 ? 1e-3 : .5, 0);
    }
    for (int n = 0; n < 100; ++n)
      body->step();
    return body;
  };
  const auto struck = [](ExcitedBody& body) {
    for (int n = 0; n < 4800; ++n)
      body.step();
    return body.exciter(0).impact_count > 0;
  };
  struct Event {
    const char* name;
    std::function<void(ExcitedBody&)> act;
  };
  const Event strikes[] = {
      {"the body rises to the mass", [](ExcitedBody& b) { b.apply_impulse(0, -.2); }},
      {"from the neighbour's place", [](ExcitedBody& b) { b.apply_impulse(1, -.2); }},
      {"for 2 ms, by 1.1 mm", [](ExcitedBody& b) { b.apply_impulse(0, -.07); }},
      {"pushed", [](ExcitedBody& b) { b.set_mass_force(0, 10); }},
      {"the mode is struck and swings to the other mass",
       [](ExcitedBody& b) { b.launch_mass(1, 1e-4, 10); }}};
  CHECK_FALSE(struck(*make(3)));
  for (const Event& event : strikes) {
    CAPTURE(event.name);
    const auto body = make(3);
    event.act(*body);
    CHECK(struck(*body));
  }
  // A surface that has waited for 2 ms.
  const auto surface = make(3);
  surface->set_friction(0, {.8, .3, .1, .5, 1e5, 40, .5});
  for (int n = 0; n < 300; ++n) {
    if (n == 100)
      surface->rub(0, 5, .2);
    surface->step();
    CHECK((surface->force(0) != 0) == (n >= 100));
  }
}

TEST_CASE("the output of a vibrating body follows any change between two samples") {
  ExcitedBody body(2, 2);
  body.prepare(48000);
  const std::array modes{Mode{400, 0.5, 0.25}, Mode{900, 0.3, 0.25}};
  const auto ring = [&] {
    body.reset();
    body.set_modes(modes);
    body.set_pickup(0, std::array{1.0, 0.5});
    for (std::size_t i = 0; i < 2; ++i) {
      body.set_impact(i, {1e6, 1.5, 0.2}, 0.01);
      body.launch_mass(i, 5, 0);
    }
    body.set_contact_shape(0, std::array{1.0, 0.0});
    body.apply_impulse(0, 0.1 * 0.25);
    body.set_contact_shape(0, std::array{1.0, 1.0});
    for (int n = 0; n < 100; ++n)
      body.step();
  };
  ring();
  const double usual = body.pickup_velocity();
  CHECK(std::abs(usual) > 1e-3);
  body.set_pickup(0, std::array{2.0, 1.0});
  CHECK(body.pickup_velocity() == approx(2 * usual));
  ring();
  body.apply_impulse(0, 0.01); // J / m of each mode, heard by 1 and 0.5
  CHECK(body.pickup_velocity() == approx(usual + 0.04 * 1.5));
  ring();
  body.set_modes(std::array{Mode{400, 0.5, 0.25}, Mode{900, 0.3, 1.0}}); // the second is at rest
  CHECK(body.pickup_velocity() == approx(usual));
  body.set_modes(std::array{Mode{400, 0.5, 1.0}, Mode{900, 0.3, 0.25}}); // same energy
  CHECK(std::abs(body.pickup_velocity()) < 0.9 * std::abs(usual));
  ring();
  body.reset();
  CHECK(body.pickup_velocity() == 0);
}

TEST_CASE("a body sounds the same if its pickups are not read every sample") {
  const auto make = [](std::size_t pickups) {
    auto body = std::make_unique<ExcitedBody>(3, 2, pickups);
    body->prepare(48000);
    body->set_modes(std::array{Mode{300, 0.2, 0.1}, Mode{700, 0.1, 0.1}, Mode{1900, 0.1, 0.2}});
    for (std::size_t i = 0; i < 2; ++i) {
      body->set_impact(i, {1e7, 1.5, 0.3}, 0.02);
      body->launch_mass(i, 0.002 + 0.1 * static_cast<double>(i), 0.5);
    }
    return body;
  };
  // Pickup 0 of one body is read every sample; pickup 1 of the other, of the same shape, at times.
  const auto one = make(1), other = make(2);
  double largest = 0;
  for (int n = 0; n < 24000; ++n) {
    one->step();
    other->step();
    largest = std::max(largest, std::abs(one->pickup_velocity()));
    if (n % 3 == 0)
      REQUIRE(other->pickup_velocity(1) == one->pickup_velocity());
  }
  CHECK(largest > 1e-2);
  CHECK(one->exciter(1).impact_count > 0);
}
