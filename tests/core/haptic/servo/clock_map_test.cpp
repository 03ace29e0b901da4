#include "core/dsp/random.hpp"
#include "core/haptic/servo/clock_map.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace tactus::haptic;

TEST_CASE(
    "a map of clocks follows a sound card's drift within a tick, tells it, and joins no moments "
    "that lie apart") {
  for (const double ppm : {-100.0, 0.0, 37.0, 100.0})
    for (const double block_ms : {1.3333, 5.8}) {
      ClockMap map;
      tactus::Random random(3);
      double servo_s = 5e5; // a week of uptime
      const double begin_s = servo_s;
      const auto host_of = [&](double s) { return (s - begin_s) * 1e3 * (1 + 1e-6 * ppm) + 20; };
      double last_ms = 0;
      while (servo_s < begin_s + 200) {
        servo_s += 5e-3 * (0.5 + random.uniform());
        const double true_ms = host_of(servo_s);
        map.follow(block_ms * std::floor(true_ms / block_ms), servo_s);
        if (servo_s < begin_s + 150)
          continue;
        // Blocks come half of their length late in the mean.
        REQUIRE(std::abs(map.host_ms(servo_s) - (true_ms - 0.5 * block_ms)) < 1);
        REQUIRE(map.host_ms(servo_s) > last_ms);
        last_ms = map.host_ms(servo_s);
      }
      CAPTURE(ppm);
      CAPTURE(block_ms);
      CHECK(std::abs(map.drift_ppm() - ppm) < 20);
      CHECK(map.leaps() == 0);
      map.follow(host_of(servo_s) + 400, servo_s + 0.005); // a stall of the sound
      CHECK(map.leaps() == 1);
      CHECK(map.host_ms(servo_s + 0.005) == doctest::Approx(host_of(servo_s) + 400));
    }
}
