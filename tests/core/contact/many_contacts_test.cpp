#include "tests/approx.hpp"
#include "tests/core/contact/bodies.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

// Many exciters on one body at once.

using namespace tactus::contact;
using namespace tactus::test;

namespace {

/// Runge and Kutta's fourth order for masses on modes.
class ReferenceIntegration {
public:
  explicit ReferenceIntegration(const Part& part) : part_(part) {
    const std::size_t modes = part.modes.size(), masses = part.strikers.size();
    y_.assign(2 * (modes + masses), 0);
    for (std::size_t i = 0; i < masses; ++i) {
      y_[2 * (modes + i)] = -part.strikers[i].gap_m;
      y_[2 * (modes + i) + 1] = part.strikers[i].speed_m_per_s;
    }
  }
  void step(double h) {
    const auto a = slope(y_), b = slope(moved(a, h / 2)), c = slope(moved(b, h / 2)),
               d = slope(moved(c, h));
    for (std::size_t i = 0; i < y_.size(); ++i)
      y_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  [[nodiscard]] double output() const {
    double sum = 0;
    for (std::size_t k = 0; k < part_.modes.size(); ++k)
      sum += y_[2 * k + 1];
    return sum;
  }

private:
  using State = std::vector<double>;
  [[nodiscard]] State moved(const State& k, double h) const {
    State y = y_;
    for (std::size_t i = 0; i < y.size(); ++i)
      y[i] += h * k[i];
    return y;
  }
  [[nodiscard]] State slope(const State& y) const {
    const std::size_t modes = part_.modes.size();
    State k(y.size());
    std::vector<double> drive(modes, 0);
    for (std::size_t i = 0; i < part_.strikers.size(); ++i) {
      const Part::Striker& s = part_.strikers[i];
      double x = y[2 * (modes + i)], v = y[2 * (modes + i) + 1];
      for (std::size_t m = 0; m < modes; ++m) {
        x -= s.shape[m] * y[2 * m];
        v -= s.shape[m] * y[2 * m + 1];
      }
      const double force = s.law.force(x, v);
      for (std::size_t m = 0; m < modes; ++m)
        drive[m] += s.shape[m] * force;
      k[2 * (modes + i)] = y[2 * (modes + i) + 1];
      k[2 * (modes + i) + 1] = -force / s.mass_kg;
    }
    for (std::size_t m = 0; m < modes; ++m) {
      const double omega = 2 * std::numbers::pi * part_.modes[m].frequency_hz;
      const double d = 6.907755278982137 / part_.modes[m].t60_s;
      k[2 * m] = y[2 * m + 1];
      k[2 * m + 1] = drive[m] / part_.modes[m].mass_kg - 2 * d * y[2 * m + 1] -
                     (omega * omega + d * d) * y[2 * m];
    }
    return k;
  }
  const Part& part_;
  State y_;
};

} // namespace

TEST_CASE("three masses on one body at once sound as the equations of motion say") {
  Part part;
  part.modes = {{180, .6, .5}, {620, .4, .8}, {1900, .2, 1.2}, {4100, .1, 2}};
  part.strikers = {{{1e6, 1.5, .3}, .05, 0, 1, 0, {1, .7, -.4, .9}},
                   {{1e8, 2.3, .1}, .01, 2e-4, 2, 0, {.3, -1, .8, .2}},
                   {{1e5, 1, 0}, .2, 1e-4, .5, 0, {-.6, .5, 1, -.3}}};
  constexpr double kRate = 48000;
  constexpr int kSamples = 960, kFine = 100;
  std::vector<double> exact_sound;
  ReferenceIntegration exact(part);
  for (int n = 0; n < kSamples; ++n) {
    for (int i = 0; i < kFine; ++i)
      exact.step(1 / (kRate * kFine));
    exact_sound.push_back(exact.output());
  }
  std::vector<double> decibels;
  for (const unsigned steps : {1U, 4U, 16U}) {
    const auto body = body_of(part);
    body->set_min_steps(steps);
    double error = 0, signal = 0;
    for (const double sound : exact_sound) {
      body->step();
      error += std::pow(body->pickup_velocity() - sound, 2);
      signal += std::pow(sound, 2);
    }
    decibels.push_back(10 * std::log10(error / signal));
    MESSAGE("at least ", steps, " steps a sample: ", decibels.back(), " dB beside the exact sound");
  }
  CHECK(decibels[0] < -70);
  // Second order: a quarter of the step, a sixteenth of the error, 24.1 dB.
  CHECK(decibels[0] - decibels[1] == approx(24.1).epsilon(0.03));
  CHECK(decibels[1] - decibels[2] == approx(24.1).epsilon(0.03));
}

TEST_CASE("a system with one unknown a mode and one with an unknown a contact agree") {
  // Modes that nothing reaches change nothing but which of the two is smaller.
  std::mt19937 source(2);
  const Part few = random_part(source, 3, 6, 1e4, 1e8, 1e-4);
  Part many = few;
  for (int i = 0; i < 5; ++i)
    many.modes.push_back({1000, 1, 1});
  for (Part::Striker& s : many.strikers)
    s.shape.resize(8, 0);
  const auto by_mode = body_of(few), by_contact = body_of(many);
  double worst = 0, loudest = 0;
  for (int n = 0; n < 400; ++n) {
    by_mode->step();
    by_contact->step();
    worst = std::max(worst, std::abs(by_mode->pickup_velocity() - by_contact->pickup_velocity()));
    loudest = std::max(loudest, std::abs(by_mode->pickup_velocity()));
  }
  CHECK(worst < 1e-9 * loudest);
}

TEST_CASE("contacts far below a step are impulses with the exact restitution, also many at once") {
  ExcitedBody body(2, 3);
  body.prepare(44100);
  body.set_modes(std::array{Mode{500, 1, .4}, Mode{2000, .5, .7}});
  for (std::size_t i = 0; i < 3; ++i)
    body.set_impact(i, {1e16, 1.5, .4}, .01);
  body.launch_mass(0, 0, 2);
  const double effective = 1 / (1 / .01 + 1 / .4 + 1 / .7);
  const double impulse = (1 + restitution(.8)) * effective * 2;
  body.step();
  CHECK(body.force(0) / 44100 == approx(impulse).epsilon(1e-9));
  CHECK(body.exciter(0).velocity_m_per_s == approx(2 - impulse / .01).epsilon(1e-9));
  body.reset();
  for (std::size_t i = 0; i < 3; ++i)
    body.launch_mass(i, 0, 1 + static_cast<double>(i));
  double before = body.energy();
  for (int n = 0; n < 100; ++n) {
    body.step();
    CHECK(body.energy() <= before * (1 + 1e-13));
    before = body.energy();
  }
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(body.exciter(i).velocity_m_per_s < 0.5);
}

TEST_CASE("new modes, laws and rates while everything sounds add no energy") {
  std::mt19937 source(9);
  Part part = random_part(source, 6, 10, 1e4, 1e10, 1e-4);
  for (Part::Striker& s : part.strikers)
    s.push_n = 0;
  const auto body = body_of(part);
  const double whole = body->energy();
  double before = whole, worst = 0;
  for (int n = 0; n < 3000; ++n) {
    if (n % 7 == 6) {
      const Part next = random_part(source, 6, 1, 1e4, 1e10);
      const Part::Striker& s = next.strikers[0];
      switch (source() % 5) {
      case 0:
        body->set_modes(next.modes);
        break;
      case 1:
        body->set_impact(source() % 10, s.law, s.mass_kg);
        break;
      case 2:
        body->set_contact_shape(source() % 10, s.shape);
        break;
      case 3:
        body->prepare(std::array{22050.0, 48000.0, 192000.0}[source() % 3]);
        break;
      default:
        body->set_min_steps(1U << source() % 7);
      }
    } else {
      body->step();
    }
    worst = std::max(worst, (body->energy() - before) / whole);
    before = body->energy();
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("the body stays finite under any input and recovers from it") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::mt19937 source(21);
  const std::array invalid_values{kNan,   kInfinity, -kInfinity, 1e300, -1e300,
                                  1e-310, 0.0,       -1.0,       1e30,  5.0};
  const auto any = [&] { return invalid_values[source() % invalid_values.size()]; };
  ExcitedBody body(4, 3);
  body.prepare(48000);
  bool finite = true;
  for (int n = 0; n < 20000; ++n) {
    switch (source() % 9) {
    case 0:
      body.set_modes(std::array{Mode{any(), any(), any()}, Mode{any(), any(), any()}});
      break;
    case 1:
      body.set_impact(source() % 3, {any(), any(), any()}, any());
      break;
    case 2:
      body.set_friction(source() % 3, {any(), any(), any(), any(), any(), any(), any(), any()});
      break;
    case 3:
      body.launch_mass(source() % 3, any(), any());
      break;
    case 4:
      body.set_mass_force(source() % 3, any());
      break;
    case 5:
      body.rub(source() % 3, any(), any());
      break;
    case 6:
      body.apply_impulse(source() % 3, any());
      break;
    case 7:
      body.set_contact_shape(source() % 3, std::array{any(), any(), any()});
      break;
    default:
      body.prepare(any());
    }
    body.step();
    finite =
        finite && std::isfinite(body.pickup_velocity()) && std::isfinite(body.force(source() % 3));
  }
  CHECK(finite);
  body.reset();
  for (std::size_t i = 0; i < 3; ++i)
    body.clear(i);
  body.prepare(48000);
  body.set_modes(std::array{Mode{440, .1, .1}});
  body.set_contact_shape(0, std::array{1.0});
  body.set_impact(0, {1e6, 1.5, .1}, .01);
  body.launch_mass(0, 0, 1);
  for (int n = 0; n < 200; ++n)
    body.step();
  CHECK(body.exciter(0).impact_count > 0);
}

TEST_CASE("samples in a row give the same bits as one at a time, with any instructions") {
  std::mt19937 source(4);
  constexpr std::size_t kSamples = 6000;
  for (const bool rubs : {false, true}) {
    std::vector<double> drive, normal;
    for (std::size_t n = 0; n < kSamples; ++n) {
      const double t = static_cast<double>(n) / 6000;
      // Pressed and let go again; the body falls silent in between.
      const bool away = n % 3000 > 2000;
      drive.push_back(rubs   ? 0.2 * std::sin(40 * t)
                      : away ? (n % 3000 < 2010 ? -20 : 0)
                             : 20 * std::sin(60 * t) + 5);
      normal.push_back(n % 3000 > 1500 || n < 200 ? 0 : 10 + 5 * std::sin(30 * t));
    }
    std::vector<ExcitedBody> bodies(2, ExcitedBody(12, 1));
    bodies.emplace_back(12, 1, 1, tactus::simd::VectorSet::kBaseline);
    for (ExcitedBody& body : bodies) {
      body.prepare(48000);
      body.set_modes(std::array{Mode{200, .002, .2}, Mode{731, .001, .3}, Mode{2600, .001, .3}});
      if (rubs) {
        body.set_friction(0, {.8, .3, .1, .5, 1e5, 40, .5, .1});
      } else {
        body.set_impact(0, {1e7, 2.3, .3}, .02);
        body.launch_mass(0, 1e-4, 1);
      }
    }
    std::vector<double> output(kSamples), force(kSamples);
    std::size_t contact_samples = 0, silent = 0;
    for (std::size_t from = 0; from < kSamples;) {
      const std::size_t count = std::min<std::size_t>(1 + source() % 100, kSamples - from);
      const auto part = [&](std::vector<double>& all) {
        return std::span(all).subspan(from, count);
      };
      for (ExcitedBody* body : {&bodies[0], &bodies[2]}) {
        if (rubs)
          body->run_rub(0, part(drive), part(normal), part(output), part(force));
        else
          body->run_mass(0, part(drive), part(output), part(force));
        if (body == &bodies[2])
          break;
        for (std::size_t n = from; n < from + count; ++n) {
          rubs ? bodies[1].rub(0, normal[n], drive[n]) : bodies[1].set_mass_force(0, drive[n]);
          bodies[1].step();
          REQUIRE(output[n] == bodies[1].pickup_velocity());
          REQUIRE(force[n] == bodies[1].force(0));
          contact_samples += force[n] != 0;
          silent += !bodies[1].active();
        }
      }
      REQUIRE(output[from + count - 1] == bodies[1].pickup_velocity());
      from += count;
    }
    CHECK(contact_samples > kSamples / 10);
    CHECK(silent > 500);
    CHECK(bodies[0].energy() == bodies[1].energy());
    CHECK(bodies[0].energy() == bodies[2].energy());
  }
}
