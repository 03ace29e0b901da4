// A bank's states, weights and ends beside the recursion written out: what is pushed while weights
// glide, what is released, what rests.
#include "core/modal/bank/mode_bank.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using tactus::test::approx;
using Complex = std::complex<double>;

namespace {

constexpr double kRate = 48000, kPi = std::numbers::pi;

const std::vector<Complex> kRates{{-4, 2 * kPi * 210}, {-9, 2 * kPi * 777}, {-20, 2 * kPi * 3100}};
const std::vector<double> kGain{1, -.7, 1.6};

std::vector<Complex> weight(double turned) {
  return {std::polar(1., turned), std::polar(.5, 2 * turned), std::polar(2., -turned)};
}

/// One drive, one pick-up.
struct RecursionReference {
  std::vector<Complex> z = std::vector<Complex>(kRates.size());
  void move(double force) {
    for (std::size_t k = 0; k < z.size(); ++k)
      z[k] = std::exp(kRates[k] / kRate) * z[k] + kGain[k] * force / kRate;
  }
  [[nodiscard]] double output(const std::vector<Complex>& w) const {
    double sum = 0;
    for (std::size_t k = 0; k < z.size(); ++k)
      sum += (w[k] * z[k]).imag();
    return sum;
  }
};

std::vector<float> play(ModeBank& bank, const std::vector<float>& force) {
  std::vector<float> out(force.size());
  const float* const in = force.data();
  float* const to = out.data();
  bank.process({&in, 1}, {&to, 1}, force.size());
  return out;
}

ModeBank make_bank(const std::vector<Complex>& w) {
  ModeBank bank(kRates, kRate, 1, 1);
  bank.set_gain(0, kGain);
  bank.jump_to_weight(0, w);
  return bank;
}

} // namespace

TEST_CASE("a force during a glide sounds by the B-spline blend of the three weights") {
  // Targets at 100 (at once), 300 (waits for 612), 400 (takes its place), 1700.
  ModeBank bank = make_bank(weight(0));
  RecursionReference plain;
  std::vector<float> output;
  std::vector<double> expected;
  const std::vector<std::vector<Complex>> target{weight(0), weight(.8), weight(-1.3), weight(2.2)};
  struct Segment {
    std::size_t begin;
    std::size_t old, middle, latest;
  };
  const std::vector<Segment> segments{
      {100, 0, 0, 1}, {612, 0, 1, 3}, {1124, 1, 3, 3}, {1700, 3, 3, 2}, {2212, 3, 2, 2}};
  for (std::size_t n = 0; n < 3000; ++n) {
    if (n == 100)
      bank.set_weight(0, target[1]);
    if (n == 300)
      bank.set_weight(0, target[2]);
    if (n == 400)
      bank.set_weight(0, target[3]);
    if (n == 1700)
      bank.set_weight(0, target[2]);
    const float force = n % 50 == 7 || (n > 900 && n < 1300)
                            ? static_cast<float>(std::sin(.1 * static_cast<double>(n)))
                            : 0;
    output.push_back(play(bank, {force})[0]);
    plain.move(static_cast<double>(force));
    double value = plain.output(target[n < 100 ? 0 : n < 1700 ? 3 : 2]);
    for (const Segment& s : segments)
      if (n >= s.begin && n < s.begin + 512) {
        const double u = (static_cast<double>(n - s.begin) + .5) / 512;
        value = .5 * (1 - u) * (1 - u) * plain.output(target[s.old]) +
                (.5 + u * (1 - u)) * plain.output(target[s.middle]) +
                .5 * u * u * plain.output(target[s.latest]);
      }
    expected.push_back(value);
    CHECK(bank.glide(0).moving() == ((n >= 100 && n < 1635) || (n >= 1700 && n < 2723)));
  }
  double maximum = 0, apart = 0;
  for (std::size_t n = 0; n < output.size(); ++n) {
    maximum = std::max(maximum, std::abs(expected[n]));
    apart = std::max(apart, std::abs(static_cast<double>(output[n]) - expected[n]));
  }
  CHECK(apart < 2e-3 * maximum); // the bank's -60 dB
}

TEST_CASE("released states fade out by half a cosine, and later forces do not") {
  const auto w = weight(.3);
  ModeBank bank = make_bank(w);
  RecursionReference old, latest;
  for (int n = 0; n < 100; ++n) {
    static_cast<void>(play(bank, {n == 0 ? 1.F : 0.F}));
    old.move(n == 0 ? 1 : 0);
  }
  bank.release();
  CHECK(bank.release_left() == ModeBank::kRelease);
  CHECK(bank.state(0) == Complex(0));
  double maximum = 0, apart = 0;
  for (std::size_t n = 0; n < 1500; ++n) {
    const double force = n == 200 ? .5 : 0;
    const double output = static_cast<double>(play(bank, {static_cast<float>(force)})[0]);
    old.move(0);
    latest.move(force);
    const double turn = kPi * static_cast<double>(n) / static_cast<double>(ModeBank::kRelease);
    const double share = n < ModeBank::kRelease ? .5 + .5 * std::cos(turn) : 0;
    const double expected = share * old.output(w) + latest.output(w);
    maximum = std::max(maximum, std::abs(expected));
    apart = std::max(apart, std::abs(output - expected));
  }
  CHECK(apart < 2e-3 * maximum);
  CHECK(bank.release_left() == 0);
  // A second release takes what is left of the first along.
  bank.release();
  static_cast<void>(play(bank, std::vector<float>(512, 0)));
  bank.release();
  CHECK(bank.release_left() == ModeBank::kRelease);
  std::vector<Complex> half(3);
  bank.read_released(half);
  for (int n = 0; n < 512; ++n)
    latest.move(0);
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(std::abs(half[k] - .5 * latest.z[k]) < 2e-3 * std::abs(half[k]) + 1e-9);
}

TEST_CASE("a silenced bank is idle at once, and becomes active by a force only") {
  ModeBank bank = make_bank(weight(0));
  CHECK(bank.idle());
  static_cast<void>(play(bank, std::vector<float>(64, 1)));
  CHECK(!bank.idle());
  CHECK(bank.active_blocks() == 1);
  bank.silence();
  CHECK(bank.idle());
  CHECK(bank.active_blocks() == 0);
  for (const float x : play(bank, std::vector<float>(128, 0)))
    CHECK(x == 0);
  CHECK(bank.idle());
  static_cast<void>(play(bank, {0, 0, 1}));
  CHECK(!bank.idle());
  bank.release();
  CHECK(!bank.idle()); // it is heard still
  static_cast<void>(play(bank, std::vector<float>(ModeBank::kRelease, 0)));
  CHECK(bank.idle());
  // Released with nothing in it: nothing to fade.
  bank.release();
  CHECK(bank.idle());
}

TEST_CASE("states read and written in the middle of a leap are those of the present sample") {
  for (const std::size_t start_sample : {0UL, 3UL, 8UL, 13UL}) {
    ModeBank bank = make_bank(weight(.2));
    RecursionReference plain;
    for (std::size_t n = 0; n < start_sample; ++n) {
      static_cast<void>(play(bank, {1}));
      plain.move(1);
    }
    std::vector<Complex> z(3);
    bank.read_states(z);
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(std::abs(z[k] - plain.z[k]) < 1e-6 * std::abs(z[k]) + 1e-12);
    const std::vector<Complex> two{{1, 2}, {-.5, .25}};
    bank.write_states(two);
    bank.read_states(z);
    CHECK(z == std::vector<Complex>{{1, 2}, {-.5, .25}, {0, 0}});
    bank.set_state(2, {.5, -1});
    CHECK(bank.state(2) == Complex(.5, -1));
    CHECK(!bank.idle());
    plain.z = {{1, 2}, {-.5, .25}, {.5, -1}};
    for (int n = 0; n < 40; ++n) {
      const double output = static_cast<double>(play(bank, {0})[0]);
      plain.move(0);
      CHECK(std::abs(output - plain.output(weight(.2))) < 3e-3);
    }
  }
}

TEST_CASE("skip() moves the clock and the glides, and nothing else") {
  ModeBank bank = make_bank(weight(0));
  bank.set_clock(1003);
  bank.set_weight(0, weight(1));
  bank.skip(500);
  CHECK(bank.clock() == 1503);
  CHECK(bank.glide(0).moving());
  CHECK(bank.glide_left() == 12);
  const auto version = bank.glide_version();
  bank.skip(12);
  CHECK(bank.glide_version() != version);
  CHECK(bank.glide_left() == 512);
  bank.skip(1000);
  CHECK(!bank.glide(0).moving());
  CHECK(bank.clock() == 2515);
  CHECK(bank.idle());
  CHECK(std::abs(bank.weight(0, ModeBank::kLatest, 1) - weight(1)[1]) < 1e-6);
}

TEST_CASE("setting the present weights starts no glide") {
  ModeBank bank(kRates, kRate, 1, 2);
  const std::vector<std::vector<Complex>> both{weight(0), weight(1)};
  for (std::size_t i = 0; i < 2; ++i)
    bank.jump_to_weight(i, both[i]);
  bank.set_weight(0, both[0]);
  bank.set_weights(both);
  CHECK(!bank.glide(0).moving());
  CHECK(!bank.glide(1).moving());
  // One that hears anew makes all glide, in step.
  bank.set_weights(std::vector<std::vector<Complex>>{weight(0), weight(1.1)});
  CHECK(bank.glide(0).moving());
  CHECK(bank.glide(1).moving());
  bank.set_weight(2, weight(0)); // there is none
  bank.jump_to_weight(2, weight(0));
  bank.jump_to_weight(1, weight(2));
  CHECK(!bank.glide(1).moving());
  CHECK(bank.glide(0).moving());
}
