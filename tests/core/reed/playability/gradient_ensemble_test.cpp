#include "core/reed/playability/gradient_ensemble.hpp"
#include "core/reed/playability/playability_map.hpp"

#include "tests/core/reed/playability/five_reeds.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

// Reeds side by side: each plays what it plays alone, and their gradient and its force are felt the
// same on every processor and in any stream.

namespace tactus::reed {
namespace {

using namespace test;
using simd::VectorSet;
using HandMode = ReedGradient::Mode;
constexpr VectorSet kAll[] = {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512};
constexpr HandMode kModes[] = {HandMode::kReed, HandMode::kGrowth, HandMode::kGuide};
constexpr double kForcePeriod_s = ReedGradient::kForcePeriod / kHandRate;

double size(const PlaneForce& force) { return std::hypot(force.y, force.z); }

ReedGradient five_noisy_trumpets(double noise) {
  ReedGradient gradient = five_trumpets();
  Parameters p = find_preset("trumpet").value();
  p.breath_noise = noise;
  gradient.set(p);
  gradient.set_range({0, 8000, 82.5, 907.5});
  return gradient;
}

double loudest(const std::vector<double>& sound) {
  double most = 0;
  for (const double x : sound)
    most = std::max(most, std::abs(x));
  return most;
}

/// Of a plane of lips, shares of nodes where theory grows as the played map sounds: with the lips
/// that the player takes for the note, and with those given.
std::pair<double, double> agreement(const char* preset, double note, std::size_t nodes) {
  Parameters p = with_player(preset);
  p.correct_pitch = false; // which trims what theory leaves
  PlayabilityMapSettings settings;
  settings.parameters = p;
  settings.bore_frequency = note;
  settings.range = {0, 8000, 0.25 * p.reed_frequency, 2.75 * p.reed_frequency};
  PlayabilityMap played;
  played.begin(settings, nodes, nodes);
  for (std::size_t n = 0; n < played.size();)
    n = played.advance(n);
  const auto share = [&](const PlayingSetup& playing) {
    GrowthMap theory;
    theory.prepare(nodes, nodes);
    theory.begin(playing, settings.range);
    (void)theory.advance(nodes * nodes);
    int same = 0, all = 0;
    for (std::size_t k = 0; k < nodes; ++k)
      for (std::size_t i = 0; i < nodes; ++i) {
        if (std::abs(theory.growth().node(i, k)) < 5)
          continue; // has not spoken, or died, within the half second it is given
        ++all;
        same += (theory.height().node(i, k) > 0) == (played.field().node(i, k) > 0.1);
      }
    return static_cast<double>(same) / all;
  };
  return {share(embouchure_for(p, note, played.length())), share({p, played.length()})};
}

TEST_CASE("eight reeds side by side play what each of them plays alone") {
  constexpr double kSeconds = 0.7;
  constexpr std::size_t kRamp = 960;
  // Lane i blows (1 + i/50) times as hard, all of them where the instrument speaks.
  for (const bool lips : {false, true})
    for (const VectorSet set : kAll) {
      if (!simd::runs(set))
        continue;
      const auto ensemble = make_reed_ensemble(set);
      const Parameters p = lips ? reference::trumpet() : reference::clarinet();
      ensemble->set(p);
      ensemble->prepare(kHandRate);
      ReedEnsemble::Pressure mouth;
      ReedEnsemble::PerLane pressure{}, reed{};
      for (std::size_t lane = 0; lane < ReedEnsemble::kLanes; ++lane) {
        pressure[lane] = (lips ? 4000 : 2000) * (1 + 0.02 * static_cast<double>(lane));
        reed[lane] = p.reed_frequency * (1 + 0.002 * static_cast<double>(lane));
        mouth.slope[lane] = pressure[lane] / kRamp;
      }
      std::vector<Recording> lanes(ReedEnsemble::kLanes);
      for (std::size_t n = 0; n < static_cast<std::size_t>(kSeconds * kHandRate); ++n) {
        mouth.first = n;
        if (n == kRamp)
          mouth.start = pressure, mouth.slope.fill(0);
        ensemble->process(mouth, reed, 0, 1, {});
        for (std::size_t lane = 0; lane < lanes.size(); ++lane)
          lanes[lane].bore_pressure.push_back(ensemble->bore_pressure(lane));
      }
      for (const std::size_t lane : {0u, 3u, 7u}) {
        Instrument alone = make_instrument(p);
        const Recording r =
            play(alone, ramp(pressure[lane], kSeconds, kHandRate), kHandRate, reed[lane]);
        const auto one = part(r, r.bore_pressure, 0.3, kSeconds);
        const auto other = part(lanes[lane], lanes[lane].bore_pressure, 0.3, kSeconds);
        INFO("lips ", lips, ", lane ", lane, " of ", static_cast<int>(set));
        CHECK(rms(one) > 100);
        const double low = lips ? 360 : 160, f = pitch(one, kHandRate, low, 1.2 * low);
        CHECK(std::abs(cents(pitch(other, kHandRate, low, 1.2 * low), f)) < 0.5);
        CHECK(std::abs(rms(other) / rms(one) - 1) < 2e-3);
      }
    }
}

TEST_CASE("sound, gradient and force have the same bits however the stream is cut into blocks") {
  const auto felt = [](std::size_t block) {
    ReedGradient gradient = five_trumpets(HandMode::kGuide);
    gradient.set_guide(&trumpet_guide());
    return feel(
        gradient,
        [](double t) {
          return std::pair(0.4 + 0.4 * std::sin(9 * t), 0.5 + 0.3 * std::sin(7 * t));
        },
        0.1, block);
  };
  const Felt whole = felt(4096);
  for (const std::size_t block : {1u, 100u}) {
    const Felt cut = felt(block);
    CHECK(cut.sound == whole.sound);
    REQUIRE(cut.force.size() == whole.force.size());
    for (std::size_t n = 0; n < whole.force.size(); ++n) {
      REQUIRE(cut.force[n].y == whole.force[n].y);
      REQUIRE(cut.force[n].z == whole.force[n].z);
    }
  }
}

TEST_CASE("each neighbour of the hand is what a hand in its place would hear") {
  // Lane k of a gradient at (y, z) against lane 0 of one at the stencil's k-th position: lanes do
  // not depend on each other. And the gradient is their central difference.
  const double y = 0.6, z = 0.42, delta = 0.02;
  const GradientStencil stencil(y, z, delta);
  const auto at = [&](double there_y, double there_z) {
    ReedGradient gradient = five_trumpets();
    gradient.set_delta(delta);
    stay(gradient, there_y, there_z, 600 * kHandPeriod_s);
    gradient.move(there_y, there_z, 0); // the force is made anew, from what the lanes are now
    std::array<double, GradientStencil::kPoints + 2> found{};
    for (std::size_t lane = 0; lane < GradientStencil::kPoints; ++lane)
      found[lane] = gradient.ensemble().playability(lane);
    gradient.move(there_y, there_z, 0); // one of two moves makes it
    found[GradientStencil::kPoints] = gradient.gradient().y;
    found[GradientStencil::kPoints + 1] = gradient.gradient().z;
    return found;
  };
  const auto here = at(y, z);
  for (std::size_t lane = 1; lane < GradientStencil::kPoints; ++lane) {
    CAPTURE(lane);
    CHECK(here[lane] == doctest::Approx(at(stencil.y[lane], stencil.z[lane])[0]).epsilon(1e-6));
    CHECK(here[lane] != here[0]);
  }
  const auto slope = [&](std::size_t a, std::size_t b, double distance) {
    return (here[a] - here[b]) / distance;
  };
  CHECK(here[GradientStencil::kPoints] ==
        doctest::Approx(slope(1, 2, stencil.y[1] - stencil.y[2])).epsilon(1e-9));
  CHECK(here[GradientStencil::kPoints + 1] ==
        doctest::Approx(slope(3, 4, stencil.z[3] - stencil.z[4])).epsilon(1e-9));
}

TEST_CASE("after reset a gradient is a new one, to the bit, wherever it was stopped") {
  const auto moved = [](ReedGradient& gradient, double y, double z, int readings) {
    return feel(
        gradient, [=](double t) { return std::pair(y + 1e-3 * t / kHandPeriod_s, z); },
        readings * kHandPeriod_s);
  };
  for (const int readings : {40, 41}) { // of which every second one moves the force
    ReedGradient used = five_trumpets(), fresh = five_trumpets();
    static_cast<void>(moved(used, 0.3, 0.7, readings));
    used.reset();
    CHECK(used.force().y == 0);
    CHECK(used.force().z == 0);
    const Felt again = moved(used, 0.5, 0.4, 300), first = moved(fresh, 0.5, 0.4, 300);
    CHECK(again.sound == first.sound);
    for (std::size_t n = 0; n < first.force.size(); ++n) {
      REQUIRE(again.force[n].y == first.force[n].y);
      REQUIRE(again.force[n].z == first.force[n].z);
    }
    CHECK(first.force.back().y != 0);
  }
}

TEST_CASE("every instruction set feels the same") {
  // Newer processors fuse products and sums, and so round single precision otherwise. What that
  // does to f_p, 1e-7, it does to the gradient fifty times over: the stencil is 0.02 wide.
  ReedGradient baseline = five_trumpets(HandMode::kReed, VectorSet::kBaseline);
  stay(baseline, 0.6, 0.42, 0.5);
  for (const VectorSet set : kAll) {
    if (!simd::runs(set))
      continue;
    ReedGradient other = five_trumpets(HandMode::kReed, set);
    stay(other, 0.6, 0.42, 0.5);
    CHECK(std::abs(other.playability() - baseline.playability()) < 1e-6);
    CHECK(std::abs(other.gradient().y - baseline.gradient().y) < 1e-4);
    CHECK(std::abs(other.gradient().z - baseline.gradient().z) < 1e-4);
  }
}

TEST_CASE("between two registers of a trumpet the slope flips from one to the next") {
  const auto slope = [](double z) { // mean of g_z over half a second, after one second
    ReedGradient gradient = five_trumpets();
    stay(gradient, 0.6, z, 1);
    double sum = 0;
    for (const Gradient& g : stay(gradient, 0.6, z, 0.5).gradient)
      sum += g.z;
    return sum;
  };
  CHECK(slope(0.42) > 0);
  CHECK(slope(0.57) < 0);
  CHECK(slope(0.50) > 0);
}

TEST_CASE("growth mode leads out of silence, where five silent reeds know nothing") {
  ReedGradient gradient = five_trumpets();
  stay(gradient, 0.05, 0.45, 1); // a firm lip, hardly blown
  CHECK(gradient.playability() < 1e-3);
  CHECK(std::abs(gradient.gradient().y) < 1e-2);
  gradient.set_mode(HandMode::kGrowth);
  stay(gradient, 0.05, 0.45, 2 * kHandPeriod_s);
  CHECK(gradient.gradient().y == 0); // without a map
  gradient.set_guide(&trumpet_guide());
  stay(gradient, 0.05, 0.45, 2 * kHandPeriod_s);
  CHECK(gradient.gradient().y > 0.5);
  stay(gradient, 0.9, 0.1, 0.5); // a slack lip blown apart
  CHECK(gradient.gradient().y < 0);
  // A change of anything that the map depends on asks for another.
  const PlaneSettings made_for = gradient.plane();
  CHECK(gradient.plane().matches(made_for));
  gradient.set_range({0, 6000, 80, 900});
  CHECK_FALSE(gradient.plane().matches(made_for));
}

TEST_CASE("a hand that is nowhere, or a bore without length, does no harm in any mode") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double strange[] = {kNan, kInf, -kInf, 1e300, -5, 0.5, 0, 3};
  for (const HandMode mode : kModes) {
    ReedGradient gradient = five_trumpets(mode);
    gradient.set_guide(&trumpet_guide());
    std::vector<double> sound(ReedGradient::kHandPeriod);
    for (int n = 0; n < 600; ++n) {
      gradient.move(strange[n % 8], strange[(n / 8) % 8], strange[(n / 64) % 8]);
      gradient.process(sound);
      for (const double x : sound)
        REQUIRE(std::isfinite(x));
      REQUIRE(std::isfinite(gradient.gradient().y + gradient.gradient().z));
      REQUIRE(std::hypot(gradient.force().y, gradient.force().z) <= 2 * std::sqrt(2.0));
    }
    // And afterwards it is as if nothing had been.
    stay(gradient, 0.05, 0.45, 0.5);
    if (mode == HandMode::kGuide)
      CHECK(gradient.force().y > 1);
  }
}

TEST_CASE("a hand that raises the pressure for 2 s makes a trumpet speak on its way") {
  // Above the threshold of fixed lips, at half the way, notes grow from the breath's noise.
  const auto raised = [](ReedGradient gradient, double to, double ramp_s, double seconds) {
    return feel(
        gradient, [=](double t) { return std::pair(to * std::min(1.0, t / ramp_s), 0.5); },
        seconds);
  };
  CHECK(loudest(raised(five_noisy_trumpets(5e-4), 0.6, 2, 2).sound) > 0.02);
  CHECK(loudest(raised(five_noisy_trumpets(1e-7), 0.6, 2, 2.2).sound) < 0.02);
  // Below it the noise is inaudible: -90 dB.
  std::vector<double> faint = raised(five_noisy_trumpets(5e-4), 0.15, 0.3, 2).sound;
  faint.erase(faint.begin(), faint.end() - 9600);
  CHECK(loudest(faint) < 3.2e-5);
}

TEST_CASE("mode guide pulls out of silence with all its ceiling, and lets go where a note plays") {
  const GuidanceField& field = trumpet_guide().distance_field;
  double y = 0, z = 0; // the place deepest inside the wall of 0.05
  for (double at_y = 0; at_y < 1; at_y += 0.02)
    for (double at_z = 0; at_z < 1; at_z += 0.02)
      if (field.distance(at_y, at_z) < field.distance(y, z)) {
        y = at_y;
        z = at_z;
      }
  REQUIRE(field.distance(y, z) < -0.06);
  for (const double ceiling : {0.5, 2.0}) {
    ReedGradient gradient = five_trumpets(HandMode::kGuide);
    gradient.set_ceiling(ceiling);
    stay(gradient, 0.05, 0.45, 0.5);
    CHECK(size(gradient.force()) == 0); // no map yet
    gradient.set_guide(&trumpet_guide());
    stay(gradient, 0.05, 0.45, 0.5);
    CHECK(gradient.playability() < 1e-3);
    CHECK(gradient.force().y > 0.5 * ceiling); // towards more pressure
    CHECK(size(gradient.force()) == doctest::Approx(ceiling).epsilon(0.02));
    // The list is the direction of the force.
    const Gradient slope = gradient.gradient();
    CHECK(std::hypot(slope.y, slope.z) == doctest::Approx(1).epsilon(0.02));
    CHECK(gradient.force().y == doctest::Approx(ceiling * slope.y).epsilon(1e-6));
    CHECK(gradient.force().z == doctest::Approx(ceiling * slope.z).epsilon(1e-6));
    stay(gradient, y, z, 0.8);
    CHECK(gradient.playability() > 0.5);
    CHECK(size(gradient.force()) == 0);
  }
}

TEST_CASE("modes reed and growth push with the patch's law of their slope") {
  for (const HandMode mode : {HandMode::kReed, HandMode::kGrowth}) {
    ReedGradient gradient = five_trumpets(mode);
    gradient.set_ceiling(1);
    gradient.set_force_gain(0.3);
    gradient.set_guide(&trumpet_guide());
    const Felt felt = stay(gradient, 0.5, 0.42, 0.5);
    ForceSmoother smoother; // 30 ms, 20 N/s
    PlaneForce expected;
    for (std::size_t n = 0; n < felt.force.size(); ++n) {
      if (n % 2 == 1)
        expected = smoother.advance(gradient_force(felt.gradient[n], 0.3, 1), kForcePeriod_s);
      REQUIRE(felt.force[n].y == expected.y);
      REQUIRE(felt.force[n].z == expected.z);
    }
    CHECK(std::abs(expected.y) > 0.01);
  }
}

TEST_CASE("another mode goes on from the force that was, and letting go ends it") {
  ReedGradient gradient = five_trumpets(HandMode::kGuide);
  gradient.set_guide(&trumpet_guide());
  stay(gradient, 0.05, 0.45, 0.5);
  const PlaneForce before = gradient.force();
  REQUIRE(size(before) > 1.9);
  gradient.set_mode(HandMode::kReed);
  stay(gradient, 0.05, 0.45, kForcePeriod_s);
  CHECK(std::abs(gradient.force().y - before.y) <= 20 * kForcePeriod_s * 1.001); // 20 N/s
  CHECK(std::abs(gradient.force().z - before.z) <= 20 * kForcePeriod_s * 1.001);
  gradient.release_force();
  CHECK(size(gradient.force()) == 0);
}

TEST_CASE("theory maps the lips that the player of a tuned note takes") {
  const auto [held, given] = agreement("trumpet", 311, 9); // not its own length's note
  CHECK(held > 0.9);
  CHECK(held > given);
}

TEST_CASE("theory maps the lips that the player of a tuned note takes, over the whole plane" *
          doctest::test_suite("slow")) {
  for (const auto& [preset, note] : {std::pair{"trumpet", 311.0}, {"trombone", 92.0}}) {
    const auto [held, given] = agreement(preset, note, 21);
    CHECK(held > 0.95);
    CHECK(held > given + 0.05);
  }
}

} // namespace
} // namespace tactus::reed
