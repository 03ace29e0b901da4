#include "core/dsp/random.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/sole_sensor.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

using namespace tactus;
using namespace tactus::footstep;

namespace {

/// A force-sensing resistor in a divider, as its data sheet has it: conductance ~ F^p, more of it
/// while the force falls (hysteresis), noise and drift. Reads 0..1.
class Resistor {
public:
  Resistor(double hysteresis, double noise, double drift, std::uint64_t seed)
      : hysteresis_(hysteresis), noise_(noise), drift_(drift), random_(seed) {}

  static double reading_of(double force_n) {
    const double conductance = 1.2e-4 * std::pow(std::max(force_n, 0.0) / 100, 0.9); // siemens
    return conductance / (conductance + 1 / 3300.0); // of the supply
  }
  double read(double force_n, double t) {
    // The loop: the conductance lags behind on the way down.
    lag_ += (force_n > lag_ ? 1.0 : 0.002) * (force_n - lag_);
    const double sensed = force_n + hysteresis_ * std::min(lag_ - force_n, force_n);
    const double drifted = sensed * (1 + drift_ * std::log10(1 + t));
    return reading_of(drifted) + noise_ * random_.normal() * reading_of(sensed);
  }

private:
  double hysteresis_, noise_, drift_, lag_ = 0;
  Random random_;
};

std::vector<double> table() {
  std::vector<double> points;
  for (const double force : {0.0, 20.0, 60.0, 120.0, 250.0, 500.0, 900.0, 1600.0}) {
    points.push_back(Resistor::reading_of(force));
    points.push_back(force);
  }
  return points;
}

} // namespace

TEST_CASE("a thousand steps on noisy, drifting sensors with hysteresis are each found in time") {
  constexpr double kRate = 8000;
  Gait gait;
  gait.prepare(kRate);
  gait.set({1.4, 700, 0.4}, 0.04);
  gait.walk(true);
  SoleSensor sensor;
  sensor.prepare(kRate);
  sensor.set(700);
  REQUIRE(sensor.heel_calibration().set(table()));
  REQUIRE(sensor.ball_calibration().set(table()));
  Resistor heel(0.1, 0.01, 0.05, 1), ball(0.1, 0.01, 0.05, 2);
  std::array<SoleState, Gait::kFeet> feet{};
  std::vector<double> true_on, true_off, found_on, found_off;
  bool stood = false;
  for (int n = 0; n < 0.1 * kRate; ++n) // in the air
    static_cast<void>(sensor.next(heel.read(0, 0), ball.read(0, 0)));
  for (int n = 0; true_off.size() < (kSanitized ? 100 : 1000); ++n) {
    const double t = n / kRate;
    gait.next(feet);
    if (feet[0].heel_landing > 0)
      true_on.push_back(t);
    if (feet[0].toe_off)
      true_off.push_back(t);
    static_cast<void>(sensor.next(heel.read(feet[0].heel_n, t), ball.read(feet[0].ball_n, t)));
    if (sensor.in_stance() != stood)
      (stood ? found_off : found_on).push_back(t);
    stood = sensor.in_stance();
  }
  REQUIRE(found_on.size() == true_on.size());
  double latest = 0, worst_stance = 0;
  for (std::size_t k = 0; k + 1 < true_off.size(); ++k) {
    latest = std::max(latest, std::abs(found_on[k] - true_on[k]));
    const double stance = true_off[k] - true_on[k], found = found_off[k] - found_on[k];
    worst_stance = std::max(worst_stance, std::abs(found / stance - 1));
  }
  MESSAGE("latest onset " << latest * 1000 << " ms, worst stance " << worst_stance * 100 << " %");
  CHECK(latest < 0.005);
  CHECK(worst_stance < 0.03);
}

TEST_CASE(
    "sensors give the landing speeds of a walker's heel and ball, the ball's soon after landing") {
  for (const double rate : {8000.0, 48000.0}) {
    double slow = 0;
    for (const double speed : {0.9, 1.4, 1.9}) {
      Gait gait;
      gait.prepare(rate);
      gait.set({speed, 700, 0.4}, 0);
      gait.walk(true);
      SoleSensor sensor;
      sensor.prepare(rate);
      sensor.set(700);
      for (int n = 0; n < 0.1 * rate; ++n) // in the air
        static_cast<void>(sensor.next(0, 0));
      std::array<SoleState, Gait::kFeet> feet{};
      double begun = -1, heel = 0, ball = 0, ball_at = 0;
      int strides = 0, heels = 0, balls = 0;
      for (int n = 0; n < 3.2 * rate; ++n) {
        gait.next(feet);
        if (feet[0].heel_landing > 0) {
          begun = n / rate;
          ++strides;
        }
        const SoleState sensed = sensor.next(feet[0].heel_n, feet[0].ball_n);
        if (sensed.heel_landing > 0) {
          ++heels;
          heel = sensed.heel_landing;
          CHECK(n / rate - begun < 0.006);
        }
        if (sensed.ball_landing > 0) {
          ++balls;
          ball = sensed.ball_landing;
          ball_at = n / rate - begun;
        }
      }
      CHECK(heels == strides);
      CHECK(balls == strides);
      CHECK(ball_at > 0.06);
      CHECK(ball_at < 0.16);
      if (speed == 1.4) {
        CHECK(heel == doctest::Approx(0.5).epsilon(0.1));
        CHECK(ball == doctest::Approx(0.3).epsilon(0.1));
      }
      CHECK(heel > slow);
      slow = heel;
    }
  }
}

TEST_CASE("the slope is the least-squares slope of 5 ms, exact for a straight line") {
  for (const double rate : {8000.0, 48000.0}) {
    SoleChannel channel;
    channel.prepare(rate);
    double worst = 0;
    for (int n = 0; n < 60000; ++n) {
      channel.next(3000 * n / rate, false);
      if (n > 0.02 * rate)
        worst = std::max(worst, std::abs(channel.slope() / 3000 - 1));
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("a calibration needs five increasing points, and interpolates linearly") {
  Calibration made;
  const std::array<double, 8> few{0, 0, 1, 1, 2, 2, 3, 3};
  CHECK_FALSE(made.set(few));
  const std::array<double, 10> falling{0, 0, 1, 5, 2, 4, 3, 6, 4, 7};
  CHECK_FALSE(made.set(falling));
  CHECK(made.force(12) == 12);
  const std::array<double, 10> good{0, 0, 1, 10, 2, 30, 3, 70, 4, 150};
  CHECK(made.set(good));
  CHECK(made.force(0.5) == doctest::Approx(5));
  CHECK(made.force(2.5) == doctest::Approx(50));
  CHECK(made.force(5) == doctest::Approx(230));
}

TEST_CASE("a sensor stays finite under invalid input and recovers within a second") {
  SoleSensor sensor;
  sensor.prepare(48000);
  const double odd[] = {std::nan(""), std::numeric_limits<double>::infinity(), -1e308, 1e308,
                        1e-310};
  for (int n = 0; n < 48000; ++n) {
    const SoleState sole = sensor.next(odd[n % 5], odd[(n / 7) % 5]);
    REQUIRE(std::isfinite(sole.heel_n + sole.ball_n + sole.heel_slope + sole.ball_slope));
  }
  bool landed = false;
  for (int n = 0; n < 48000; ++n)
    landed = sensor.next(0, 0).heel_landing > 0;
  CHECK_FALSE(sensor.in_stance());
  for (int n = 0; n < 4800; ++n)
    landed = landed || sensor.next(n < 480 ? n : 480, 0).heel_landing > 0;
  CHECK(landed);
}
