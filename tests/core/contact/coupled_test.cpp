#include "tests/approx.hpp"
#include "tests/core/contact/bodies.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

// Masses on vibrating bodies, against integrations of the equations of motion.

using namespace tactus::contact;
using namespace tactus::test;

namespace {

constexpr double kNepers = 6.907755278982137; // of a decay by 60 dB
constexpr double kPi = std::numbers::pi;

} // namespace

TEST_CASE("a mass on three modes leaves with the speed and at the time of theory") {
  struct Row {
    double stiffness, speed_after, end_ms;
  };
  const std::array<Mode, 3> modes{
      {{220, kNepers / 12, .4}, {1130, kNepers / 25, .9}, {3270, kNepers / 60, 1.6}}};
  // Dormand and Prince's eighth order at 1e-12.
  for (const Row& row : {Row{1e6, -.79111888, 4.1324}, Row{1e8, -.60309547, .60781},
                         Row{1e10, -.51994836, .09242}}) {
    CAPTURE(row.stiffness);
    ExcitedBody body(3, 1);
    body.prepare(44100);
    body.set_modes(modes);
    body.set_impact(0, {row.stiffness, 1.5, .3}, .05);
    body.launch_mass(0, 0, 1);
    double before = body.energy();
    for (int n = 0; n < 300; ++n) {
      body.step();
      CHECK(body.energy() <= before * (1 + 1e-12));
      before = body.energy();
    }
    CHECK(body.exciter(0).velocity_m_per_s == approx(row.speed_after).epsilon(1e-3));
    CHECK(body.exciter(0).last.duration_s == approx(1e-3 * row.end_ms).epsilon(1e-2));
  }
}

TEST_CASE("a free mode keeps its frequency and decay time at any rate and step") {
  for (const double rate : {22050.0, 44100.0, 192000.0})
    for (const unsigned steps : {1U, 8U, 64U})
      for (const double share : {0.001, 0.1, 0.3, 0.48}) {
        const double t60 = 0.05, d = kNepers / t60;
        ExcitedBody body(1, 1);
        body.prepare(rate);
        body.set_min_steps(steps);
        body.set_modes(std::array{Mode{share * rate, t60, 0.25}});
        body.apply_impulse(0, 1);
        // Every sum of exp((-d +- j omega) t) satisfies this, and nothing else does.
        const double radius = std::exp(-d / rate), turn = 2 * radius * std::cos(2 * kPi * share);
        double two_ago = body.pickup_velocity(), worst = 0;
        CHECK(two_ago == approx(4));
        body.step();
        double ago = body.pickup_velocity();
        for (int n = 1; n <= 400; ++n) {
          body.step();
          worst = std::max(
              worst, std::abs(body.pickup_velocity() - turn * ago + radius * radius * two_ago));
          two_ago = std::exchange(ago, body.pickup_velocity());
        }
        CAPTURE(rate);
        CAPTURE(steps);
        CAPTURE(share);
        CHECK(worst < 1e-10);
      }
}

namespace {

void check_random_masses_on_random_bodies(int systems) {
  std::mt19937 source(3);
  double worst = 0;
  for (int system = 0; system < systems; ++system) {
    const double rate = std::array{44100.0, 48000.0, 96000.0}[source() % 3];
    std::vector<Mode> list(1 + source() % 8);
    std::vector<double> shape;
    for (Mode& m : list) {
      m = {log_random(source, 20, 0.489 * rate), log_random(source, 1e-3, 10),
           log_random(source, 1e-3, 10)};
      shape.push_back(random(source, -1, 1));
    }
    ExcitedBody body(8, 1);
    body.prepare(rate);
    body.set_modes(list);
    body.set_contact_shape(0, shape);
    body.set_impact(0,
                    {log_random(source, 1e2, 1e15), random(source, 1, 3.5),
                     source() % 3 ? log_random(source, 1e-3, 10) : 0},
                    log_random(source, 1e-4, 10));
    body.launch_mass(0, 0, log_random(source, 1e-3, 10));
    const double whole = body.energy();
    double before = whole;
    for (int n = 0; n < 200; ++n) {
      body.step();
      worst = std::max(worst, (body.energy() - before) / whole);
      before = body.energy();
    }
    REQUIRE(std::isfinite(before));
    REQUIRE(std::isfinite(body.pickup_velocity()));
  }
  CHECK(worst < 1e-12);
}

} // namespace

TEST_CASE("random masses on random bodies never gain energy and stay finite") {
  check_random_masses_on_random_bodies(400);
}
TEST_CASE("4000 random masses never gain energy" * doctest::test_suite("slow")) {
  check_random_masses_on_random_bodies(4000);
}
