#include "core/dsp/random.hpp"
#include "core/haptic/chain/passivity.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

// The controller tick by tick against its equations (docs/phantom.md, "Passivity"), which are
// evaluated here from the motion. passivity_test.cpp tests it in a loop with walls and hands.

using namespace tactus::haptic;

namespace {

PassivitySettings settings_of(double period_s) {
  PassivitySettings settings;
  settings.period_s = period_s;
  settings.slew_n_per_s = 1e9;
  settings.tank_j = 1e6;
  return settings;
}

/// A handle with the motion x = v t + a t^2/2 in a rendered spring -K x. Other work, J, is given to
/// the observer as its allowance.
struct Motion {
  PassivitySettings settings;
  double stiffness = 0, velocity = 0, acceleration = 0;
  Vec3 direction{1, 0, 0};
  PassivityController controller{};
  int tick = 0;

  [[nodiscard]] double time_s() const { return tick * settings.period_s; }
  [[nodiscard]] double x() const {
    return velocity * time_s() + 0.5 * acceleration * time_s() * time_s();
  }
  [[nodiscard]] double speed() const { return velocity + acceleration * time_s(); }
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) {
      controller.observe(settings, direction * x(), {}, 0);
      static_cast<void>(
          controller.limit(settings, direction * (-stiffness * x()), {}, direction * speed()));
      ++tick;
    }
  }
  /// One tick with the observer's energy set to that value: what is added to the spring's force.
  double braked(double energy_j, double reading) {
    controller.observe(settings, direction * x(), {}, energy_j - controller.energy_j());
    return controller.limit(settings, {-stiffness * x(), 0, 0}, {}, {reading, 0, 0}).x +
           stiffness * x();
  }
};

} // namespace

TEST_CASE(
    "the observer sums the work of the force that acted on the handle, with and without latency") {
  for (const int latency : {-3, 0, 1, 2, 5, 8, 20}) {
    const auto felt_delay = static_cast<std::size_t>(std::clamp(latency, 0, 8));
    PassivitySettings settings = settings_of(1e-3);
    settings.latency_ticks = latency;
    PassivityController controller;
    tactus::Random random(9);
    const auto any = [&random] { return Vec3{random.normal(), random.normal(), random.normal()}; };
    std::vector<Vec3> written;
    Vec3 position = any() * 1e-2; // where it starts is no motion
    double energy_j = 0;
    for (std::size_t n = 0; n < 200; ++n) {
      const Vec3 moved = n == 0 ? Vec3{} : any() * 1e-3;
      position += moved;
      written.push_back(any());
      if (n >= felt_delay)
        energy_j -= dot(written[n - felt_delay], moved);
      controller.observe(settings, position, written.back(), 0);
      CAPTURE(latency);
      CHECK(controller.energy_j() == doctest::Approx(energy_j).epsilon(1e-9).scale(1e-3));
    }
  }
}

TEST_CASE(
    "negative energy is cleared after 50 ms at rest within the reading's error, positive is not") {
  constexpr double kRadius_m = 2e-5;
  for (const double noise_m : {0.0, 3e-5})
    for (const double energy_j : {-1e-3, 1e-3})
      for (const double sway : {0.9, 1.1}) { // of the radius within which it rests
        CAPTURE(noise_m);
        CAPTURE(sway);
        PassivitySettings settings = settings_of(1e-3);
        settings.position_noise_m = noise_m;
        PassivityController controller;
        controller.observe(settings, {0.01, 0, 0}, {}, energy_j);
        for (int n = 1; n < 49; ++n) {
          const double x = 0.01 + (n % 2 ? sway * (2 * noise_m + kRadius_m) : 0.0);
          controller.observe(settings, {x, 0, 0}, {}, 0);
          CHECK(controller.energy_j() == energy_j);
        }
        for (int n = 0; n < 3; ++n)
          controller.observe(settings, {0.01, 0, 0}, {}, 0);
        CHECK(controller.energy_j() == (energy_j > 0 || sway > 1 ? energy_j : 0.0));
      }
}

TEST_CASE(
    "negative energy is removed by min(-E/(T u^2), 3 K T, b_device) of damping, at every rate") {
  constexpr double kDevice = 5;
  for (const double period_s : {2.5e-4, 1e-3, 2e-3})
    for (const double stiffness : {100.0, 800.0, 30000.0})
      for (const double debt_j : {1e-7, 1e-5, 1.0}) {
        CAPTURE(period_s);
        CAPTURE(stiffness);
        CAPTURE(debt_j);
        Motion motion{settings_of(period_s), stiffness, 0.15, 0};
        motion.settings.damping_limit_n_s_per_m = kDevice;
        motion.run(40);
        const double u = 0.15;
        // What a device renders quietly at 1 kHz it renders at slower rates in proportion.
        const double device = kDevice * std::min(1.0, 1e-3 / period_s);
        const double damping =
            std::min({debt_j / (period_s * u * u), 3 * stiffness * period_s, device});
        CHECK(motion.braked(-debt_j, u) == doctest::Approx(-damping * u).epsilon(1e-6).scale(1e-3));
        CHECK(motion.controller.acted());
      }
}

TEST_CASE("with positive energy, or at zero velocity, nothing is braked") {
  for (const auto& [speed, energy_j] : {std::pair{0.15, 1e-9}, {0.9e-4, -1.0}}) {
    Motion motion{settings_of(1e-3), 800, speed, 0};
    motion.run(40);
    CHECK(motion.braked(energy_j, speed) == 0);
    CHECK_FALSE(motion.controller.acted());
  }
}

TEST_CASE("the braked velocity is the reading, no faster than 2 ms of displacement in one tick") {
  // x = v t + a t^2/2: the displacement of the last window w is (v - a w/2) w.
  for (const double period_s : {1e-4, 5e-4, 1e-3, 5e-3}) {
    const double window_s = std::clamp(std::floor(2e-3 / period_s + 0.5), 1.0, 15.0) * period_s;
    for (const double reading : {0.5, 1.0, 2.0, 20.0, -1.0}) { // of the true velocity
      CAPTURE(period_s);
      CAPTURE(reading);
      Motion motion{settings_of(period_s), 1e5, 0.1, 8 / (80 * period_s) * 0.1};
      motion.settings.damping_limit_n_s_per_m = 2;
      motion.run(40);
      const double true_speed = motion.speed();
      const double mean = true_speed - 0.5 * motion.acceleration * window_s;
      const double agreed =
          reading < 0 ? 0.0 : std::min(mean * window_s / period_s, reading * true_speed);
      CHECK(
          motion.braked(-10, reading * true_speed) ==
          doctest::Approx(-2 * std::min(1.0, 1e-3 / period_s) * agreed).epsilon(1e-6).scale(1e-3));
    }
  }
}

TEST_CASE("an encoder's step is no created energy, and a displacement counts beyond the reading's "
          "error") {
  constexpr double kNoise_m = 2e-5, kSpeed = 0.15;
  const auto braked = [](double stiffness, double speed, double energy_j, double reading) {
    Motion motion{settings_of(1e-3), stiffness, speed, 0};
    motion.settings.position_noise_m = kNoise_m;
    motion.run(40);
    const double force = motion.braked(energy_j, reading);
    CHECK(motion.controller.acted() == (force != 0));
    return force;
  };
  const auto close_to = [](double force) {
    return doctest::Approx(force).epsilon(1e-6).scale(1e-3);
  };
  for (const double moved_m : {3e-5, 1.5e-5, -1.5e-5}) // in 2 ms, read as 1 m/s
    CHECK(braked(1e6, moved_m / 2e-3, -10, 1) ==
          close_to(-5 * std::max(moved_m - kNoise_m, 0.0) / 1e-3));
  // A step q = 2 kNoise_m of a spring is an energy K q^2/2 that nobody has given. A spring stiffer
  // than any that the device could damp counts as b_device/T.
  for (const double stiffness : {400.0, 1e6})
    for (const double debt : {0.9, 1.1, 1.6}) { // of that energy
      CAPTURE(stiffness);
      CAPTURE(debt);
      const double step_j = 0.5 * std::min(stiffness, 5 / 1e-3) * 4 * kNoise_m * kNoise_m;
      CHECK(braked(stiffness, kSpeed, -debt * step_j, kSpeed) ==
            close_to(-std::max(debt - 1, 0.0) * step_j / (1e-3 * kSpeed)));
    }
}

TEST_CASE("the damper acts along the force, or along the last one when there is none") {
  const Vec3 direction = Vec3{1, 2, -2} * (1.0 / 3);
  Motion motion{settings_of(1e-3), 1e5, 0.12, 0, direction};
  motion.run(40);
  motion.controller.observe(motion.settings, direction * motion.x(), {}, -10);
  SUBCASE("along") {
    const Vec3 force = motion.controller.limit(motion.settings, {-7, 0, 0}, {}, direction * 0.12);
    CHECK(norm(force - Vec3{-7 - 5 * 0.12 / 3, 0, 0}) < 1e-9);
  }
  SUBCASE("none") {
    const Vec3 force = motion.controller.limit(motion.settings, {}, {}, direction * 0.12);
    CHECK(norm(force + direction * (5 * 0.12)) < 1e-9);
  }
}

TEST_CASE("the stiffness that bounds the damper decays with 50 ms") {
  // A spring while it moves, then a constant force: what remains of K after t is K exp(-t/2 tau)
  // for the changes of force; those of the position go on, so the ratio falls by the counts.
  Motion motion{settings_of(1e-3), 1000, 0.1, 0};
  motion.run(200);
  const double tau_ticks = 50, held = 60;
  double x = motion.x();
  const Vec3 force{-motion.stiffness * x, 0, 0};
  for (int n = 0; n < held; ++n, x += 1e-4) {
    motion.controller.observe(motion.settings, {x, 0, 0}, {}, 0);
    static_cast<void>(motion.controller.limit(motion.settings, force, {}, {0.1, 0, 0}));
  }
  motion.controller.observe(motion.settings, {x, 0, 0}, {}, -10);
  const double braked =
      force.x - motion.controller.limit(motion.settings, force, {}, {0.1, 0, 0}).x;
  // Sums of squares with a weight exp(-age/tau): one step of the force less than the motion's.
  double forces = 0, positions = 0;
  for (int age = 0; age < 200 + held; ++age) {
    const double weight = std::exp(-age / tau_ticks);
    positions += weight;
    forces += age >= held ? weight : 0.0;
  }
  const double remaining = 1000 * std::sqrt(forces / positions);
  CHECK(braked ==
        doctest::Approx(std::min(5.0, 3 * remaining * 1e-3) * 0.1).epsilon(0.01).scale(1e-3));
  CHECK(3 * remaining * 1e-3 < 4); // so that it is the bound that acts
}

TEST_CASE(
    "a contact that throws the handle back releases the remaining energy, as its force falls") {
  // A free handle M under a constant force from rest. At one instant the observer has E left: the
  // force that is then let through is felt `latency` ticks later, held for a tick, and falls by the
  // slew, while the handle goes on: what all this releases is integrated here in small steps.
  constexpr double kMass_kg = 0.1, T = 1e-3;
  double least = 1, most = 0;
  for (const int latency : {0, 1, 3, 8})
    for (const double force_n : {1.0, 4.0})
      for (const double fall_ticks : {0.1, 4.0, 16.0})
        for (const double share : {0.5, 0.9, 1.2}) { // of what the whole force would release
          PassivitySettings settings = settings_of(T);
          settings.latency_ticks = latency;
          settings.slew_n_per_s = force_n / (fall_ticks * T);
          double velocity = 0, position = 0;
          const auto advance = [&](double force, double seconds) { // the work of that force
            const double before = velocity;
            velocity += force / kMass_kg * seconds;
            position += 0.5 * (before + velocity) * seconds;
            return force * 0.5 * (before + velocity) * seconds;
          };
          PassivityController controller;
          const Vec3 contact{force_n, 0, 0};
          double last_tick_j = 0;
          for (int n = 0; n < 24; ++n) {
            controller.observe(settings, {position, 0, 0}, contact, 0);
            static_cast<void>(controller.limit(settings, contact, contact, {velocity, 0, 0}));
            last_tick_j = advance(force_n, T);
          }
          const double velocity_now = velocity, position_now = position;
          const auto release = [&](double first_n) {
            double sum = advance(first_n, T);
            const double h = 1e-3 * first_n / settings.slew_n_per_s;
            for (int n = 0; n < 1000; ++n)
              sum += advance(first_n - settings.slew_n_per_s * h * (n + 0.5), h);
            return sum;
          };
          const double in_transit_j = advance(force_n, latency * T);
          const double whole_j = release(force_n);
          velocity = velocity_now, position = position_now;
          const double left_j = in_transit_j + share * whole_j;
          controller.observe(settings, {position, 0, 0}, contact,
                             left_j - controller.energy_j() + last_tick_j);
          const double limited_force =
              controller.limit(settings, contact, contact, {velocity, 0, 0}).x;
          advance(force_n, latency * T);
          const double released = release(limited_force) / (share * whole_j);
          CAPTURE(latency);
          CAPTURE(fall_ticks);
          CAPTURE(share);
          CHECK(controller.acted() == (limited_force < force_n));
          if (share > 1) {
            CHECK(limited_force == doctest::Approx(force_n)); // there is enough
          } else {
            least = std::min(least, released);
            most = std::max(most, released);
          }
        }
  // The handle gains up to 1/24 of its velocity in a tick; what it gains while the force falls is
  // taken to be that of the whole force, which is too much where half of it is cut.
  CHECK(least > 0.75);
  CHECK(most < 1.03);
}

TEST_CASE(
    "the reduction of a contact is limited by its force, by the energy and to the first 0.1 s") {
  PassivitySettings settings = settings_of(1e-3);
  settings.slew_n_per_s = 2000;
  const auto limited_force = [&settings](int ticks, double energy_j, double velocity,
                                         const Vec3& desired,
                                         double read = 1) { // times the velocity, at the end
    PassivityController controller;
    const Vec3 contact{2, 0, 0};
    double x = 0;
    for (int n = 0; n < ticks; ++n, x += velocity * 1e-3) {
      controller.observe(settings, {x, 0, 0}, {}, 0);
      static_cast<void>(controller.limit(settings, desired, contact, {velocity, 0, 0}));
    }
    controller.observe(settings, {x, 0, 0}, {}, energy_j);
    return controller.limit(settings, desired, contact, {read * velocity, 0, 0});
  };
  const Vec3 desired{3, 1, 0}; // 1 N of it and what is across are no contact's
  CHECK(norm(limited_force(20, 0, 0.1, desired) - Vec3{1, 1, 0}) < 1e-12);
  CHECK(limited_force(20, 1, 0.1, desired) == desired);
  CHECK(limited_force(20, 0, -0.1, desired) == desired); // pressed in
  CHECK(limited_force(20, 0, 0.9e-4, desired) == desired);
  CHECK(limited_force(98, 0, 0.1, desired).x < desired.x);
  CHECK(limited_force(101, 0, 0.1, desired) == desired); // held there: it swings against the hand
  // E = v (F T + F^2/(2 slew)) at a constant velocity.
  const double v = 0.1, kept = 0.7, energy_j = v * (kept * 1e-3 + kept * kept / (2 * 2000.0));
  CHECK(limited_force(20, energy_j, v, desired).x ==
        doctest::Approx(1 + kept).epsilon(1e-9).scale(1e-3));
  // An exact device that reads more than the last 2 ms show is believed: the handle speeds up.
  const auto slower = [&](double times) {
    return limited_force(20, times * energy_j, v, desired, 3).x;
  };
  settings.slew_n_per_s = 1e9; // of which the acceleration that is seen takes its share, too
  CHECK(slower(3 * 1e-3 * kept * v / energy_j) ==
        doctest::Approx(1 + kept).epsilon(1e-6).scale(1e-3));
}
