#include "core/dsp/random.hpp"
#include "core/haptic/chain/passivity.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

// The controller tick by tick against its equations (docs/theory/passivity.md), which are
// evaluated here from the motion. passivity_test.cpp tests it in a loop with walls and hands.

using namespace tactus::haptic;
using tactus::Vec3;
using Parts = PassivityController::Parts;

namespace {

PassivitySettings settings_of(double period_s, int latency_ticks = 0) {
  PassivitySettings settings;
  settings.period_s = period_s;
  settings.latency_ticks = latency_ticks;
  settings.slew_n_per_s = 1e9;
  settings.tank_j = 1e6;
  return settings;
}

/// A controller that is written what it returns.
struct Loop {
  PassivitySettings settings;
  PassivityController controller{};
  Vec3 written{};
  Parts tick(const Vec3& position, const Vec3& velocity, const Parts& desired) {
    controller.observe(settings, position, written);
    const Parts parts = controller.limit(settings, desired, velocity);
    written = parts.contact + parts.command;
    return parts;
  }
};

const Vec3 kAlong = Vec3{1, 2, -2} * (1.0 / 3);

} // namespace

TEST_CASE("the observer sums the work of the contact's force that acted on the handle, with and "
          "without latency") {
  for (const int latency : {-3, 0, 1, 2, 5, 8, 20}) {
    const auto felt_delay = static_cast<std::size_t>(std::clamp(latency, 0, 8));
    Loop loop{settings_of(1e-3, latency)};
    tactus::Random random(9);
    std::vector<Vec3> written;
    Vec3 position{0.1, 0.2, 0.3}; // where it starts is no motion
    double energy_j = 0;
    for (std::size_t n = 0; n < 200; ++n) {
      const Vec3 moved = n == 0 ? Vec3{} : kAlong * (random.normal() * 1e-3);
      position += moved;
      written.push_back(loop.written);
      if (n >= felt_delay)
        energy_j -= dot(written[n - felt_delay], moved);
      static_cast<void>(loop.tick(position, {}, {kAlong * (1 + random.uniform()), {}}));
      CAPTURE(latency);
      CHECK(loop.controller.energy_j() == doctest::Approx(energy_j).epsilon(1e-9).scale(1e-3));
    }
  }
}

TEST_CASE("negative energy is cleared after 50 ms at rest within the reading's error, positive is "
          "not") {
  for (const double noise_m : {0.0, 3e-5})
    for (const double moved_m : {-1e-3, 1e-3})
      for (const double sway : {0.9, 1.1}) { // of the radius within which it rests, and 20 um
        Loop loop{settings_of(1e-3)};
        loop.settings.position_noise_m = noise_m;
        const auto at = [&](double x) {
          static_cast<void>(loop.tick({x, 0, 0}, {}, {{1, 0, 0}, {}}));
          return loop.controller.energy_j();
        };
        at(0);
        const double energy_j = at(moved_m);
        CHECK(energy_j == doctest::Approx(-moved_m));
        const double there = moved_m + sway * (2 * noise_m + 2e-5);
        for (int n = 1; n <= 60; ++n)
          at(n % 2 ? there : moved_m);
        if (energy_j > 0 || sway > 1)
          CHECK(at(moved_m) == doctest::Approx(energy_j));
        else // but for the work of swaying with 1 N
          CHECK(std::abs(at(moved_m)) <= std::abs(there - moved_m) * (1 + 1e-9));
      }
}

TEST_CASE("of a held spring K the damper removes what the hold creates, K T (1/2 + L) u^2, within "
          "what the device can damp, at every rate") {
  for (const double period_s : {2.5e-4, 1e-3, 2e-3})
    for (const int latency : {0, 1, 3})
      for (const double stiffness : {100.0, 800.0, 30000.0})
        for (const bool command : {false, true})
          for (const double u : {-0.15, 0.15}) { // into the spring's wall and out
            CAPTURE(period_s);
            CAPTURE(latency);
            CAPTURE(stiffness);
            CAPTURE(command);
            Loop loop{settings_of(period_s, latency)};
            Vec3 force;
            const double depth = 200 * 0.15 * period_s;
            Parts parts;
            double last = 0;
            for (int n = 0; n < 150; ++n) {
              const double x = (u < 0 ? 0 : -depth) + n * u * period_s;
              // The host computes it from the position before.
              force = kAlong * (-stiffness * (command ? std::exchange(last, x) : x));
              if (n == 0 && u < 0)
                continue;
              const Parts desired = command ? Parts{{}, force} : Parts{force, {}};
              // A handle that is held there for longer than 0.1 s is no bounce.
              parts = loop.tick(kAlong * x, kAlong * u, desired);
            }
            const double device = 5 * std::min(1.0, 1e-3 / period_s);
            const double lead = latency + (command ? 1.5 : 0.5);
            const double damping = std::min(device, stiffness * period_s * lead);
            if (u < 0 || 150 * period_s > 0.1)
              CHECK(dot((command ? parts.command : parts.contact) - force, kAlong) ==
                    doctest::Approx(-std::min(damping * u, norm(force))).epsilon(1e-3));
          }
}

TEST_CASE("an encoder's steps are no created energy: a slow hand feels the spring") {
  constexpr double kStep_m = 4e-5;
  Loop loop{settings_of(1e-3, 1)};
  loop.settings.position_noise_m = kStep_m / 2;
  for (int n = 0; n < 4000; ++n) { // 5 mm in and out at 2.5 mm/s
    const double x = -5e-3 * (1 - std::abs(n / 2000.0 - 1)) - 1e-4;
    const double read = kStep_m * std::floor(x / kStep_m + 0.5);
    const Vec3 force{-500 * read, 0, 0};
    const Parts parts = loop.tick({read, 0, 0}, {n < 2000 ? -2.5e-3 : 2.5e-3, 0, 0}, {force, {}});
    REQUIRE(norm(parts.contact - force) <= 500 * kStep_m);
  }
}

TEST_CASE("no part of the force is turned round, one that is zero stays zero, and none grows by "
          "more than the device's damping of the speed") {
  tactus::Random random(5);
  Loop loop{settings_of(1e-3)};
  Vec3 position;
  for (int n = 0; n < 20000; ++n) {
    const auto any = [&](double scale) {
      return Vec3{random.normal(), random.normal(), random.normal()} * scale;
    };
    if (n % 100 == 0)
      loop.settings = settings_of(2e-4 * (1 + 9 * random.uniform()), n / 100 % 5);
    const Vec3 velocity = any(0.3);
    position += velocity * loop.settings.period_s;
    const bool stiff = n / 1000 % 2 == 0;
    Parts desired{stiff ? position * -2000 : any(2), n / 500 % 2 ? position * -3000 : any(1)};
    if (n / 30 % 4 == 0)
      desired.contact = {};
    const Parts parts = loop.tick(position, velocity, desired);
    for (const auto& [is, was] :
         {std::pair{parts.contact, desired.contact}, std::pair{parts.command, desired.command}}) {
      REQUIRE(norm(cross(is, was)) <= 1e-9 * (1 + norm(is) * norm(was)));
      REQUIRE(dot(is, was) >= 0);
      REQUIRE(norm(is) <= norm(was) + 5 * norm(velocity) + 1e-12);
      if (was == Vec3{})
        REQUIRE(is == Vec3{});
    }
  }
}

TEST_CASE(
    "a bounce returns no more than the momentum of the approach, whatever latency, slew limit "
    "and encoder, and a hand that presses keeps its force") {
  // A free handle at a force that is constant in the contact, so that a contact without controller
  // returns more the later it ends.
  for (const int latency : {0, 1, 3})
    for (const double slew : {1e9, 2000.0})
      for (const double step_m : {0.0, 3.4e-5}) {
        Loop loop{settings_of(1e-3, latency)};
        loop.settings.slew_n_per_s = slew;
        loop.settings.position_noise_m = step_m / 2;
        constexpr double kMass_kg = 0.1, kArrival = 0.1;
        double x = 0.05 * kArrival, v = -kArrival;
        std::vector<double> read(4, x), speeds(4, v);
        double force = 0;
        for (int n = 0; n < 200; ++n) {
          read.push_back(step_m > 0 ? step_m * std::floor(x / step_m + 0.5) : x);
          speeds.push_back(v);
          const auto late = read.size() - 1 - static_cast<std::size_t>(latency);
          const Vec3 desired{read[late] < 0 ? 1.0 : 0.0, 0, 0};
          loop.controller.observe(loop.settings, {read[late], 0, 0}, {force, 0, 0});
          const double asked =
              loop.controller.limit(loop.settings, {desired, {}}, {speeds[late], 0, 0}).contact.x;
          force += std::clamp(asked - force, -slew * 1e-3, slew * 1e-3);
          x += (v + 0.5 * force / kMass_kg * 1e-3) * 1e-3;
          v += force / kMass_kg * 1e-3;
        }
        CAPTURE(latency);
        CAPTURE(slew);
        CAPTURE(step_m);
        CHECK(v > 0.5 * kArrival);
        CHECK(v < 1.02 * kArrival);
      }
}
