#include "core/dsp/random.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/sole_sensor.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

// Every way of walking, through noisy sensors: each landing is found once, and in time.

using namespace tactus;
using namespace tactus::footstep;

namespace {

constexpr std::array kNames{"walk", "run", "sneak", "upstairs", "downstairs"};

/// How landings of one part of the left sole were found.
struct Found {
  std::vector<double> truth_s, found_s, truth_speed, found_speed;

  [[nodiscard]] double latest() const {
    double worst = 0;
    for (std::size_t i = 0; i < std::min(truth_s.size(), found_s.size()); ++i)
      worst = std::max(worst, std::abs(found_s[i] - truth_s[i]));
    return worst;
  }
};

struct Feet {
  Found heel, ball;
};

/// Multiplicative noise of 1 %, and additive noise of `noise` weights at 48 kHz, of the same
/// density at other rates.
template <class Move>
Feet sense(const Walker& walker, double rate, double seconds, double noise, Move move) {
  Gait gait;
  gait.prepare(rate);
  gait.set(walker, 0.04);
  SoleSensor sensor;
  sensor.prepare(rate);
  sensor.set(walker.weight_n);
  Random random(5);
  const double added = noise * std::sqrt(rate / 48000) * walker.weight_n;
  const auto read = [&](double force) {
    return force * (1 + 0.01 * random.normal()) + added * random.normal();
  };
  Feet feet;
  double slip = 0;
  std::array<SoleState, Gait::kFeet> reference{};
  const int still = static_cast<int>(0.3 * rate);
  for (int n = -still; n < seconds * rate; ++n) {
    if (n >= 0) {
      move(gait, n);
      gait.next(reference);
    }
    const SoleState& sole = reference[0];
    const SoleState sensed = sensor.next(read(sole.heel_n), read(sole.ball_n));
    slip = slip + sensed.heel_slip + sensed.ball_slip;
    const auto note = [&](Found& part, double real, double detected) {
      if (real > 0) {
        part.truth_s.push_back(n / rate);
        part.truth_speed.push_back(real);
      }
      if (detected > 0) {
        part.found_s.push_back(n / rate);
        part.found_speed.push_back(detected);
      }
    };
    note(feet.heel, sole.heel_landing, sensed.heel_landing);
    note(feet.ball, sole.ball_landing, sensed.ball_landing);
  }
  CHECK(slip == 0); // forces do not tell
  return feet;
}

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x)
    sum += value / static_cast<double>(x.size());
  return sum;
}

} // namespace

TEST_CASE("a step of any way of walking is felt within 6 ms, its second contact within 9, none is "
          "missed and none made up") {
  double latest = 0, second = 0;
  for (int style = 0; style < kStyles; ++style)
    for (const double speed : {0.4, 0.8, 1.4, 2.5, 4.0, 7.0})
      for (const double weight : {300.0, 700.0, 1200.0})
        for (const double rate : {8000.0, 48000.0}) {
          if (style != static_cast<int>(Style::kRun) && speed > 2.5)
            continue;
          if (rate > 8000 && (weight != 700 || speed != 1.4))
            continue;
          const double seconds = rate > 8000 ? 12 : 30, shoe = weight == 300 ? 0 : 0.4;
          const Feet feet = sense({speed, weight, shoe, static_cast<Style>(style)}, rate, seconds,
                                  0.001, [](Gait& gait, int n) {
                                    if (n == 0)
                                      gait.walk(true);
                                  });
          CAPTURE(std::string(kNames[static_cast<std::size_t>(style)]));
          CAPTURE(speed);
          CAPTURE(weight);
          CAPTURE(rate);
          // The last landing may be the last sample's.
          for (const Found* part : {&feet.heel, &feet.ball}) {
            CHECK(part->truth_s.size() >= 5);
            CHECK(part->found_s.size() <= part->truth_s.size());
            CHECK(part->found_s.size() + 1 >= part->truth_s.size());
            // How hard, within a factor of two.
            const double ratio = mean(part->found_speed) / mean(part->truth_speed);
            CHECK(ratio > 0.5);
            CHECK(ratio < 2.2);
          }
          const bool heel_first = feet.heel.truth_s[0] < feet.ball.truth_s[0];
          const Found &first = heel_first ? feet.heel : feet.ball,
                      &then = heel_first ? feet.ball : feet.heel;
          CHECK(first.latest() < 0.006);
          CHECK(then.latest() < 0.009);
          latest = std::max(latest, first.latest());
          second = std::max(second, then.latest());
        }
  MESSAGE("latest first contact " << latest * 1000 << " ms, second " << second * 1000 << " ms");
}

TEST_CASE("with four times the noise no step is missed or made up either") {
  for (int style = 0; style < kStyles; ++style) {
    CAPTURE(std::string(kNames[static_cast<std::size_t>(style)]));
    const Feet feet =
        sense({1.4, 700, 0.4, static_cast<Style>(style)}, 48000, 15, 0.004, [](Gait& gait, int n) {
          if (n == 0)
            gait.walk(true);
        });
    const Found& first = feet.heel.truth_s[0] < feet.ball.truth_s[0] ? feet.heel : feet.ball;
    CHECK(first.found_s.size() <= first.truth_s.size());
    CHECK(first.found_s.size() + 1 >= first.truth_s.size());
  }
}

TEST_CASE("noise alone is no step, whatever its size") {
  for (const double noise : {0.0, 1e-4, 1e-3, 5e-3, 2e-2}) {
    CAPTURE(noise);
    const Feet feet = sense({1.4, 700, 0.4}, 48000, kSanitized ? 4 : 20, noise, [](Gait&, int) {});
    CHECK(feet.heel.found_s.empty());
    CHECK(feet.ball.found_s.empty());
  }
}

TEST_CASE("a jump's landing, a scuff and a step after a stand are felt through sensors") {
  const Feet feet = sense({1.4, 700, 0.4}, 48000, 12, 0.001, [](Gait& gait, int n) {
    if (n == 0)
      gait.walk(true);
    if (n == 2 * 48000)
      gait.scuff(0);
    if (n == 4 * 48000)
      gait.jump(0.3);
    if (n == 8 * 48000)
      gait.walk(false);
  });
  for (const Found* part : {&feet.heel, &feet.ball}) {
    REQUIRE(part->found_s.size() == part->truth_s.size());
    CHECK(part->latest() < 0.009);
  }
  CHECK(feet.ball.found_s.size() == feet.heel.found_s.size() + 1); // the scuff
}
