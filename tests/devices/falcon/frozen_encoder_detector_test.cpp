#include "devices/falcon/frozen_encoder_detector.hpp"

#include "core/dsp/random.hpp"
#include "core/haptic/device/hand.hpp"
#include "devices/falcon/kinematics.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numbers>
#include <span>

using namespace tactus;
using devices::falcon::FrozenEncoderDetector;

namespace {

constexpr double kPeriod_s = 1e-3, kForever = std::numeric_limits<double>::infinity();

struct Holder {
  const char* name;
  double stiffness_n_per_m, damping_n_s_per_m, tremor_m, wander_m;
};
constexpr Holder kPerson{"person (core/haptic/hand)", 200, 2, 100e-6, 1e-3};
constexpr Holder kStill{"very still, 20 um rms", 200, 2, 20e-6, 0};
constexpr Holder kBraced{"braced on a table", 3000, 30, 10e-6, 0};

/// A Falcon's grip of 0.15 kg with Coulomb friction in a hand, and its encoders: whole counts of
/// the three arms through the inverse kinematics.
class Grip {
public:
  Grip(const Holder& holder, double friction_n, std::uint64_t seed) : friction_n_(friction_n) {
    haptic::HandSettings settings;
    settings.hold = haptic::HandSettings::Hold::kPerson;
    settings.stiffness_n_per_m = holder.stiffness_n_per_m;
    settings.damping_n_s_per_m = holder.damping_n_s_per_m;
    settings.tremor_m = holder.tremor_m;
    settings.wander_m = holder.wander_m;
    settings.yield_s = 0;
    settings.seed = seed;
    hand_.set(settings, kPeriod_s);
    stiffness_ = holder.stiffness_n_per_m;
    damping_ = holder.damping_n_s_per_m;
    // Anywhere within a count.
    Random random(seed);
    for (int axis = 0; axis < 3; ++axis)
      centre_[axis] = 35e-6 * random.uniform();
  }

  /// One tick under that force; true when a count has changed.
  bool step(const Vec3& force_n) {
    constexpr int kSubsteps = 4;
    constexpr double kMass_kg = 0.15, dt = kPeriod_s / kSubsteps;
    const haptic::PathPoint hand = hand_.point();
    for (int i = 0; i < kSubsteps; ++i) {
      const Vec3 push = force_n + (hand.position + centre_ - position_) * stiffness_ +
                        (hand.velocity - velocity_) * damping_;
      // Karnopp: friction stops what it can stop within the step.
      const Vec3 free = velocity_ + push * (dt / kMass_kg);
      const double speed = norm(free), stops = friction_n_ * dt / kMass_kg;
      velocity_ = speed <= stops ? Vec3{} : free * (1 - stops / speed);
      position_ += velocity_ * dt;
    }
    hand_.advance(position_);
    return count();
  }

private:
  bool count() {
    const auto angles = devices::falcon::inverse(devices::falcon::kCentre + position_);
    if (!angles) // an assertion in each tick would take longer than the tick
      FAIL("the grip has left the workspace");
    bool changed = false;
    for (std::size_t arm = 0; arm < 3; ++arm) {
      const double exact =
          ((*angles)[arm] - devices::falcon::kRadiansAtZero) / devices::falcon::kRadiansPerCount;
      const int counts = static_cast<int>(std::lround(exact));
      changed = changed || counts != counts_[arm];
      counts_[arm] = counts;
    }
    return changed;
  }

  haptic::Hand hand_;
  double friction_n_, stiffness_ = 0, damping_ = 0;
  Vec3 centre_{}, position_{}, velocity_{};
  std::array<int, 3> counts_{};
};

using Force = std::function<Vec3(double time_s)>;

Force constant(double newton) {
  return [newton](double) { return Vec3{0, -0.6, 0.8} * newton; };
}
/// Between 0.5 and 2.5 N in 10 s, as one who leans on a virtual wall.
Vec3 slow(double time_s) { return Vec3{0, 0, 1.5 + std::sin(2 * std::numbers::pi * 0.1 * time_s)}; }
/// 1 N with 1 N of vibration at 250 Hz, which no count shows.
Vec3 buzzing(double time_s) {
  return Vec3{0, 0, 1 + std::sin(2 * std::numbers::pi * 250 * time_s)};
}

struct Outcome {
  double found_s = kForever; ///< after the encoders froze
  bool false_alarm = false;
  int questions = 0;
  double min_gain = 1;
};

Outcome run(const Holder& holder, double friction_n, const Force& force, std::uint64_t seed,
            double frozen_at_s, double end_s) {
  Grip grip(holder, friction_n, seed);
  FrozenEncoderDetector detector;
  Outcome outcome;
  bool asking = false;
  for (int tick = 0; tick * kPeriod_s < end_s; ++tick) {
    const double time_s = tick * kPeriod_s;
    const Vec3 commanded = force(time_s);
    const bool changed = grip.step(commanded * detector.gain());
    detector.update(changed && time_s < frozen_at_s, commanded, kPeriod_s, true);
    const bool asks = detector.gain() < 1;
    outcome.questions += asks && !asking && time_s < frozen_at_s;
    asking = asks;
    outcome.min_gain = std::min(outcome.min_gain, detector.gain());
    if (!detector.frozen())
      continue;
    outcome.false_alarm = time_s < frozen_at_s;
    outcome.found_s = time_s - frozen_at_s;
    break;
  }
  return outcome;
}

struct Push {
  const char* name;
  Force force;
  double limit_s; ///< waiting 3 s (12 s for a hand that was still before), 0.5 s of fading, 0.2 s
                  ///< of nothing
};
// Half a newton lies within kBand_n, which friction may hold: it asks nothing and finds nothing.
const Push kPushes[] = {{"0.5 N", constant(0.5), kForever},
                        {"slow 0.5..2.5 N", slow, 7},
                        {"1 N, 250 Hz", buzzing, 13},
                        {"1 N", constant(1), 13},
                        {"3 N", constant(3), 13},
                        {"5 N", constant(5), 13},
                        {"2 N", constant(2), 13}};
const std::span kFindable = std::span(kPushes).subspan(1), kHeld = std::span(kPushes).first(6);

/// So many encoders freeze, each at an instant of its own, with each holder under each push.
void find_frozen(int runs, std::span<const Push> pushes) {
  for (const Holder& holder : {kPerson, kStill, kBraced})
    for (const Push& push : pushes) {
      double sum_s = 0, max_s = 0;
      Random random(7);
      for (int i = 0; i < runs; ++i) {
        const double frozen_at_s = 5 + 25 * random.uniform();
        const Outcome outcome =
            run(holder, FrozenEncoderDetector::kFriction_n, push.force,
                static_cast<std::uint64_t>(i + 1), frozen_at_s, frozen_at_s + 40);
        CHECK_FALSE(outcome.false_alarm);
        CHECK(outcome.found_s < push.limit_s);
        sum_s += outcome.found_s;
        max_s = std::max(max_s, outcome.found_s);
      }
      std::printf("%-26s %-16s found after %.1f s, %.1f s at most\n", holder.name, push.name,
                  sum_s / runs, max_s);
    }
}

/// A hand that holds still for so long, with each holder, friction and push.
void hold_still(double minutes, std::span<const double> frictions_n, std::span<const Push> pushes) {
  for (const Holder& holder : {kPerson, kStill, kBraced})
    for (const double friction_n : frictions_n) {
      int questions = 0;
      double min_gain = 1;
      for (const Push& push : pushes) {
        const Outcome outcome = run(holder, friction_n, push.force, 3, kForever, 60 * minutes);
        INFO(holder.name << ", " << push.name << ", friction " << friction_n << " N");
        CHECK_FALSE(outcome.false_alarm);
        questions += outcome.questions;
        min_gain = std::min(min_gain, outcome.min_gain);
      }
      std::printf("%-26s friction %.1f N: %.0f questions an hour, force never below %.0f %%\n",
                  holder.name, friction_n,
                  questions / (static_cast<double>(pushes.size()) * minutes / 60), 100 * min_gain);
    }
}

constexpr double kFriction_n[] = {FrozenEncoderDetector::kFriction_n, 0, 0.2};

} // namespace

TEST_CASE("encoders that freeze are found under a force above the friction") {
  find_frozen(1, kFindable.first(2));
}

TEST_CASE("encoders that freeze at any instant are found under any force above the friction" *
          doctest::test_suite("slow")) {
  find_frozen(12, kFindable);
}

TEST_CASE("a hand that holds still for ten seconds is no frozen encoder") {
  hold_still(1. / 6, std::span(kFriction_n).first(1), kFindable.first(2));
}

TEST_CASE("a hand that holds still is no frozen encoder" * doctest::test_suite("slow")) {
  const char* text = std::getenv("ENCODER_WATCH_MINUTES");
  hold_still(text ? std::atof(text) : 1, kFriction_n, kHeld);
}

TEST_CASE("no motion and no force, or none that counts, is no frozen encoder") {
  FrozenEncoderDetector detector;
  const auto pass = [&](double seconds, const Vec3& force, bool active) {
    for (int i = 0; i < seconds / kPeriod_s; ++i)
      detector.update(false, force, kPeriod_s, active);
  };
  pass(100, {}, true);
  CHECK(detector.gain() == 1);
  pass(100, {0, 0.7, 0}, true); // friction may hold that
  CHECK(detector.gain() == 1);
  pass(100, {0, 5, 0}, false); // not homed
  CHECK(detector.gain() == 1);
  pass(100, {NAN, 5, 0}, true);
  CHECK(detector.gain() == 1);
  CHECK_FALSE(detector.frozen());
}

TEST_CASE("a frozen encoder has no force until a count changes, and then softly") {
  FrozenEncoderDetector detector;
  const Vec3 force{0, 2, 0};
  for (int i = 0; i < 1000; ++i)
    detector.update(true, force, kPeriod_s, true);
  double time_s = 0;
  while (!detector.frozen() && time_s < 10) {
    detector.update(false, force, kPeriod_s, true);
    time_s += kPeriod_s;
  }
  CHECK(time_s == doctest::Approx(FrozenEncoderDetector::kWait_s + FrozenEncoderDetector::kFade_s +
                                  FrozenEncoderDetector::kZeroForce_s)
                      .epsilon(0.01));
  for (int i = 0; i < 1000; ++i) {
    detector.update(false, force, kPeriod_s, true);
    CHECK(detector.gain() == 0);
  }
  double last = 0;
  int ticks = 0;
  for (; detector.gain() < 1 && ticks < 1000; ++ticks) {
    detector.update(ticks == 0, force, kPeriod_s, true);
    CHECK_FALSE(detector.frozen());
    CHECK(detector.gain() - last <= kPeriod_s / FrozenEncoderDetector::kReturn_s + 1e-9);
    last = detector.gain();
  }
  CHECK(ticks == doctest::Approx(200).epsilon(0.01));
}

TEST_CASE("a change of the force that nothing answers is asked about without waiting") {
  FrozenEncoderDetector detector;
  const auto until = [&](const Vec3& force, auto holds) {
    double time_s = 0;
    for (; !holds() && time_s < 20; time_s += kPeriod_s)
      detector.update(false, force, kPeriod_s, true);
    return time_s;
  };
  detector.update(true, {0, 1, 0}, kPeriod_s, true); // it counts, and freezes
  const double found_s = until({0, -1, 0}, [&] { return detector.frozen(); });
  CHECK(found_s < 1.2);
}

TEST_CASE("a force that friction may have held before is asked about twice") {
  FrozenEncoderDetector detector;
  for (int i = 0; i < 1000; ++i)
    detector.update(true, {0, 0.3, 0}, kPeriod_s, true);
  // From 0.3 N, where it last moved, neither to 1 N nor to none is more than friction holds; from
  // none to 1 N is.
  bool asked = false, returned = false;
  for (double time_s = 0; !detector.frozen() && time_s < 20; time_s += kPeriod_s) {
    detector.update(false, {0, 1, 0}, kPeriod_s, true);
    asked = asked || detector.gain() == 0;
    returned = returned || (asked && detector.gain() == 1);
  }
  CHECK(asked);
  CHECK(returned);
  CHECK(detector.frozen());
}
