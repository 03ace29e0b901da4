#include "core/reed/playability/gradient_ensemble.hpp"

#include "core/reed/instrument/instrument.hpp"
#include "core/reed/playability/gradient.hpp"
#include "tests/core/reed/playability/guides.hpp"
#include "tests/core/reed/reference_instruments.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kRate = 48000;
constexpr Instructions kAll[] = {Instructions::kBaseline, Instructions::kAvx2,
                                 Instructions::kAvx512};

struct Tone {
  double frequency, rms;
};

/// Pitch by interpolated upward crossings and strength of the alternating part, 1.2 to 1.9 s.
Tone measure(const std::vector<double>& x) {
  const std::size_t from = static_cast<std::size_t>(1.2 * kRate), to = x.size();
  double mean = 0, power = 0;
  for (std::size_t n = from; n < to; ++n)
    mean += x[n] / static_cast<double>(to - from);
  double first = 0, last = 0;
  int crossings = 0;
  for (std::size_t n = from; n < to; ++n) {
    power += (x[n] - mean) * (x[n] - mean) / static_cast<double>(to - from);
    if (n == from || x[n - 1] >= mean || x[n] < mean)
      continue;
    last = static_cast<double>(n) - (x[n] - mean) / (x[n] - x[n - 1]);
    if (crossings++ == 0)
      first = last;
  }
  return {kRate * (crossings - 1) / (last - first), std::sqrt(power)};
}

double cents(double f, double reference) { return 1200 * std::log2(f / reference); }

constexpr std::size_t kLength = static_cast<std::size_t>(1.9 * kRate);
constexpr std::size_t kRamp = 960;

std::vector<double> alone(const Parameters& p, double pressure, double reed_frequency) {
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(kRate, kLength);
  std::vector<double> mouth(kLength), reed(kLength, reed_frequency), bore(kLength, 0.0),
      sound(kLength), angle(kLength), pb(kLength), flow(kLength);
  for (std::size_t n = 0; n < kLength; ++n)
    mouth[n] = pressure * std::min(1.0, static_cast<double>(n + 1) / kRamp);
  instrument.process<double>({mouth, reed, bore}, {sound, angle, pb, flow});
  return pb;
}

TEST_CASE("eight reeds side by side play what each of them plays alone") {
  struct Case {
    std::string name;
    Parameters instrument;
    double pressure, spread;
  };
  // Lane i blows (1 + i spread) times as hard, all of them where the instrument speaks.
  const Case cases[] = {{"clarinet", reference::clarinet(), 2000, 0.02},
                        {"trumpet", reference::trumpet(), 4000, 0.02}};
  for (const Case& c : cases)
    for (const Instructions instructions : kAll) {
      const auto ensemble = make_reed_ensemble(instructions);
      if (!ensemble)
        continue;
      CAPTURE(c.name);
      CAPTURE(static_cast<int>(instructions));
      ensemble->set(c.instrument);
      ensemble->prepare(kRate);
      ReedEnsemble::Pressure mouth;
      ReedEnsemble::PerLane pressure{}, reed{};
      for (std::size_t lane = 0; lane < ReedEnsemble::kLanes; ++lane) {
        pressure[lane] = c.pressure * (1 + c.spread * static_cast<double>(lane));
        reed[lane] = c.instrument.reed_frequency * (1 + 0.002 * static_cast<double>(lane));
        mouth.slope[lane] = pressure[lane] / kRamp;
      }
      std::vector<std::vector<double>> bore(ReedEnsemble::kLanes, std::vector<double>(kLength));
      for (std::size_t n = 0; n < kLength; ++n) {
        mouth.first = n;
        if (n == kRamp)
          mouth.start = pressure, mouth.slope.fill(0);
        ensemble->process(mouth, reed, 0, 1, {});
        for (std::size_t lane = 0; lane < bore.size(); ++lane)
          bore[lane][n] = ensemble->bore_pressure(lane);
      }
      for (const std::size_t lane : {0u, 3u, 7u}) {
        CAPTURE(lane);
        const Tone one = measure(alone(c.instrument, pressure[lane], reed[lane]));
        const Tone lanes = measure(bore[lane]);
        CHECK(one.rms > 100);
        CHECK(std::abs(cents(lanes.frequency, one.frequency)) < 0.5);
        CHECK(std::abs(lanes.rms / one.rms - 1) < 2e-3);
      }
    }
}

/// f_p and gradient after some time at one place; blocks of the given size.
struct HandState {
  double playability;
  Gradient gradient;
  std::vector<double> sound;
};
HandState play_at(Instructions instructions, double y, double z, std::size_t block,
                  double seconds) {
  ReedGradient gradient(instructions);
  gradient.set(reference::trumpet());
  gradient.set_range({0, 8000, 80, 900});
  gradient.prepare(kRate);
  HandState state{};
  state.sound.resize(static_cast<std::size_t>(seconds * kRate));
  for (std::size_t at = 0; at < state.sound.size();) {
    const std::size_t end = std::min(at + block, state.sound.size());
    while (at < end) {
      if (gradient.samples_until_hand() == 0)
        gradient.move(y, z, 0);
      const std::size_t left =
          gradient.samples_until_hand() ? gradient.samples_until_hand() : ReedGradient::kHandPeriod;
      const std::size_t count = std::min(left, end - at);
      gradient.process(std::span(state.sound).subspan(at, count));
      at += count;
    }
  }
  state.playability = gradient.playability();
  state.gradient = gradient.gradient();
  return state;
}

TEST_CASE("the gradient is the same bits however the stream is cut") {
  const HandState whole = play_at(best_instructions(), 0.6, 0.42, 4096, 0.5);
  for (const std::size_t block : {1u, 7u, 64u}) {
    const HandState cut = play_at(best_instructions(), 0.6, 0.42, block, 0.5);
    CHECK(cut.gradient.y == whole.gradient.y);
    CHECK(cut.gradient.z == whole.gradient.z);
    CHECK(cut.sound == whole.sound);
  }
}

TEST_CASE("each neighbour of the hand is what a hand in its place would hear") {
  // Lane k of a gradient at (y, z) against lane 0 of one at the stencil's k-th position: lanes do
  // not depend on each other. And the gradient is their central difference.
  const double y = 0.6, z = 0.42, delta = 0.02;
  const GradientStencil stencil(y, z, delta);
  const auto at = [&](double there_y, double there_z) {
    ReedGradient gradient;
    gradient.set(reference::trumpet());
    gradient.set_range({0, 8000, 80, 900});
    gradient.set_delta(delta);
    gradient.prepare(kRate);
    std::array<double, ReedGradient::kHandPeriod> sound;
    std::array<double, GradientStencil::kPoints + 2> found{};
    for (int n = 0; n < 601; ++n) {
      gradient.move(there_y, there_z, 0);
      if (n == 600) // the force has just been made anew, from what the lanes are now
        break;
      gradient.process(sound);
    }
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
  const auto feel_on = [](ReedGradient& gradient, double y, double z, int readings) {
    std::vector<double> state;
    std::array<double, ReedGradient::kHandPeriod> sound;
    for (int n = 0; n < readings; ++n) {
      gradient.move(y + 1e-3 * n, z, 0);
      gradient.process(sound);
      state.insert(state.end(), sound.begin(), sound.end());
      state.push_back(gradient.force().y);
      state.push_back(gradient.force().z);
    }
    return state;
  };
  for (const int readings : {40, 41}) { // of which every second one moves the force
    const auto prepare = [](ReedGradient& gradient) {
      gradient.set(reference::trumpet());
      gradient.set_range({0, 8000, 80, 900});
      gradient.prepare(kRate);
    };
    ReedGradient used, fresh;
    prepare(used);
    prepare(fresh);
    static_cast<void>(feel_on(used, 0.3, 0.7, readings));
    used.reset();
    CHECK(used.force().y == 0);
    CHECK(used.force().z == 0);
    const auto again = feel_on(used, 0.5, 0.4, 300), first = feel_on(fresh, 0.5, 0.4, 300);
    CHECK(again == first);
    CHECK(std::any_of(first.begin(), first.end(), [](double x) { return x != 0; }));
  }
}

TEST_CASE("every instruction set feels the same") {
  // Newer processors fuse products and sums, and so round single precision otherwise. What that
  // does to f_p, 1e-7, it does to the gradient fifty times over: the stencil is 0.02 wide.
  const HandState baseline = play_at(Instructions::kBaseline, 0.6, 0.42, 64, 0.5);
  for (const Instructions instructions : kAll) {
    if (!make_reed_ensemble(instructions))
      continue;
    const HandState state = play_at(instructions, 0.6, 0.42, 64, 0.5);
    CHECK(std::abs(state.playability - baseline.playability) < 1e-6);
    CHECK(std::abs(state.gradient.y - baseline.gradient.y) < 1e-4);
    CHECK(std::abs(state.gradient.z - baseline.gradient.z) < 1e-4);
  }
}

/// Mean of g_z over one second, after one second.
double steady_slope(double z) {
  ReedGradient gradient;
  gradient.set(reference::trumpet());
  gradient.set_range({0, 8000, 80, 900});
  gradient.prepare(kRate);
  std::vector<double> sound(ReedGradient::kHandPeriod);
  double sum = 0;
  int count = 0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(2 * kRate); n += sound.size()) {
    gradient.move(0.6, z, 0);
    gradient.process(sound);
    if (n < static_cast<std::size_t>(kRate))
      continue;
    sum += gradient.gradient().z;
    ++count;
  }
  return sum / count;
}

TEST_CASE("between two registers of a trumpet the force flips from one to the next") {
  CHECK(steady_slope(0.42) > 0);
  CHECK(steady_slope(0.57) < 0);
  CHECK(steady_slope(0.50) > 0);
}

TEST_CASE("growth mode leads out of silence, where five silent reeds know nothing") {
  ReedGradient gradient;
  gradient.set(reference::trumpet());
  gradient.set_range({0, 8000, 80, 900});
  gradient.prepare(kRate);
  std::vector<double> sound(ReedGradient::kHandPeriod);
  const auto stay = [&](double y, double z, int readings = 1500) {
    for (int n = 0; n < readings; ++n) {
      gradient.move(y, z, 0);
      gradient.process(sound);
    }
  };
  stay(0.05, 0.45); // a firm lip, hardly blown
  CHECK(gradient.playability() < 1e-3);
  CHECK(std::abs(gradient.gradient().y) < 1e-2);
  gradient.set_mode(ReedGradient::Mode::kGrowth);
  stay(0.05, 0.45, 2);
  CHECK(gradient.gradient().y == 0); // without a map
  const PlaneGuide guide = test::guide_of(gradient.plane());
  gradient.set_guide(&guide);
  stay(0.05, 0.45, 2);
  CHECK(gradient.gradient().y > 0.5);
  stay(0.9, 0.1); // a slack lip blown apart
  CHECK(gradient.gradient().y < 0);
  // A change of anything that the map depends on asks for another.
  const PlaneSettings made_for = gradient.plane();
  CHECK(gradient.plane().matches(made_for));
  gradient.set_range({0, 6000, 80, 900});
  CHECK_FALSE(gradient.plane().matches(made_for));
}

TEST_CASE("a hand that is nowhere, or a bore without length, does no harm") {
  ReedGradient gradient;
  gradient.set(reference::trumpet());
  gradient.prepare(kRate);
  std::vector<double> sound(ReedGradient::kHandPeriod);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double strange[] = {kNan, kInf, -kInf, 1e300, -5, 0.5, 0, 3};
  for (int n = 0; n < 3000; ++n) {
    gradient.move(strange[n % 8], strange[(n / 8) % 8], strange[(n / 64) % 8]);
    gradient.process(sound);
    for (const double x : sound)
      REQUIRE(std::isfinite(x));
    REQUIRE(std::isfinite(gradient.gradient().y));
    REQUIRE(std::isfinite(gradient.gradient().z));
  }
}

} // namespace
} // namespace tactus::reed
