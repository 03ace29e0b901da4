// A bank of modes beside its equation written out: in every instruction set, while its weights
// glide, when it is released, and at rest.
#include "core/modal/bank/mode_bank.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

/// z <- p z + b F/rate for each mode, and the sum of Im(w z), in double precision.
struct Recursion {
  std::vector<Complex> rate;
  std::vector<double> gain;
  std::vector<Complex> z = std::vector<Complex>(rate.size());
  void move(double force) {
    for (std::size_t k = 0; k < z.size(); ++k)
      z[k] = exp(rate[k] / kRate) * z[k] + gain[k] * force / kRate;
  }
  [[nodiscard]] double output(const std::vector<Complex>& weight) const {
    double sum = 0;
    for (std::size_t k = 0; k < z.size(); ++k)
      sum += (weight[k] * z[k]).imag();
    return sum;
  }
};

Complex mode(double frequency, double t60) {
  return {-std::log(1000.0) / t60, 2 * kPi * frequency};
}

struct Random {
  std::mt19937 engine{5};
  double operator()(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(engine);
  }
  std::vector<float> force(std::size_t frames, double size) {
    std::vector<float> newtons(frames);
    for (float& f : newtons)
      f = static_cast<float>((*this)(-size, size));
    return newtons;
  }
};

struct Modes {
  Modes(Random& random, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      rate.push_back(mode(random(20, 21600), random(0.05, 5)));
      weight.emplace_back(random(-1, 1), random(-1, 1));
      gain.push_back(random(-1, 1));
    }
  }
  std::vector<Complex> rate, weight;
  std::vector<double> gain;
};

std::vector<Complex> weight(double turned) {
  return {tactus::math::polar(1., turned), tactus::math::polar(.5, 2 * turned),
          tactus::math::polar(2., -turned)};
}

Recursion three_modes() {
  return {{{-4, 2 * kPi * 210}, {-9, 2 * kPi * 777}, {-20, 2 * kPi * 3100}}, {1, -.7, 1.6}};
}

ModeBank make_bank(const Recursion& modes, const std::vector<Complex>& w,
                   VectorSet set = tactus::simd::kWidest) {
  ModeBank bank(modes.rate, kRate, 1, 1, set);
  bank.set_gain(0, modes.gain);
  bank.jump_to_weight(0, w);
  return bank;
}

std::vector<float> play(ModeBank& bank, const std::vector<float>& force, std::size_t block = 64) {
  std::vector<float> out(force.size());
  for (std::size_t n = 0; n < force.size(); n += block) {
    const float* const in = force.data() + n;
    float* const to = out.data() + n;
    bank.process({&in, 1}, {&to, 1}, std::min(block, force.size() - n));
  }
  return out;
}

template <class Check> void for_each_set(const Check& check) {
  for (const VectorSet set : {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512})
    if (tactus::simd::runs(set)) {
      CAPTURE(static_cast<int>(set));
      check(set);
    }
}

void check_pitch(VectorSet set, double frequency, double t60) {
  CAPTURE(frequency);
  CAPTURE(t60);
  const Complex rate = mode(frequency, t60), w(0.6, -0.8);
  ModeBank bank = make_bank({{rate}, {1}}, {w}, set);
  std::vector<float> force(48000, 0.0F), exact;
  force[0] = 48000;
  for (std::size_t n = 0; n < force.size(); ++n)
    exact.push_back(static_cast<float>((w * exp(rate * (static_cast<double>(n) / kRate))).imag()));
  CHECK(difference_db(exact, play(bank, force)) < -60);
  if (t60 < 0.3)
    return;
  // Phase drift over the decay: compare with the exact phasor late in the sound.
  bank.flush_pending();
  const Complex after = bank.state(0), should = exp(rate * (47999.0 / kRate));
  const double turned = arg(after / should) / (2 * kPi); // turns in one second
  CHECK(std::abs(1200 * std::log2(1 + turned / frequency)) < 0.01);
  CHECK(std::abs(std::log(abs(after) / abs(should))) < 0.005 * 6.9 / t60 + 2e-3);
}

} // namespace

TEST_CASE("pitch is within 0.01 cent and error below -60 dB at the ends of the range") {
  for_each_set([](VectorSet set) {
    check_pitch(set, 20, 20);
    check_pitch(set, 440, 1);
    check_pitch(set, 21600, 0.05);
  });
}

TEST_CASE("pitch is within 0.01 cent and error below -60 dB, 20 Hz to 0.45 fs, T60 0.05 to 20 s" *
          doctest::test_suite("slow")) {
  for_each_set([](VectorSet set) {
    for (const double frequency : {20.0, 30.0, 100.0, 440.0, 2000.0, 7919.0, 12000.0, 21600.0})
      for (const double t60 : {0.05, 0.3, 1.0, 5.0, 20.0})
        check_pitch(set, frequency, t60);
  });
}

TEST_CASE("a bank under continuous forces follows its equation, in every instruction set") {
  Random random;
  for (const std::size_t count : {1UL, 5UL, 31UL, 32UL, 33UL, 64UL, 200UL}) {
    CAPTURE(count);
    const Modes modes(random, count);
    const std::vector<float> force = random.force(4096, 100);
    Recursion plain{modes.rate, modes.gain};
    std::vector<float> exact;
    for (const float f : force) {
      plain.move(static_cast<double>(f));
      exact.push_back(static_cast<float>(plain.output(modes.weight)));
    }
    for_each_set([&](VectorSet set) {
      ModeBank bank = make_bank(plain, modes.weight, set);
      CHECK(difference_db(exact, play(bank, force)) < -80);
    });
  }
}

TEST_CASE("forces at several points add up in each pick-up, in any order") {
  Random random;
  constexpr std::size_t kPoints = 3, kFrames = 640;
  const Modes modes(random, 40), other(random, 40);
  std::vector<std::vector<double>> gain;
  std::vector<std::vector<float>> force;
  std::vector<float> exact[2] = {std::vector<float>(kFrames), std::vector<float>(kFrames)};
  for (std::size_t d = 0; d < kPoints; ++d) {
    gain.push_back(Modes(random, 40).gain);
    force.push_back(random.force(kFrames, 1));
    Recursion one{modes.rate, gain[d]};
    for (std::size_t n = 0; n < kFrames; ++n) {
      one.move(static_cast<double>(force[d][n]));
      exact[0][n] += static_cast<float>(one.output(modes.weight));
      exact[1][n] += static_cast<float>(one.output(other.weight));
    }
  }
  using Order = std::array<std::size_t, kPoints>;
  for (const Order& order : {Order{0, 1, 2}, Order{2, 0, 1}}) {
    ModeBank bank(modes.rate, kRate, kPoints, 2);
    bank.jump_to_weight(0, modes.weight);
    bank.jump_to_weight(1, other.weight);
    std::array<const float*, kPoints> in{};
    for (std::size_t d = 0; d < kPoints; ++d) {
      bank.set_gain(d, gain[order[d]]);
      in[d] = force[order[d]].data();
    }
    std::vector<float> one(kFrames), two(kFrames);
    const std::array<float*, 2> out{one.data(), two.data()};
    bank.process(in, out, kFrames);
    CHECK(difference_db(exact[0], one) < -80);
    CHECK(difference_db(exact[1], two) < -80);
  }
}

TEST_CASE("a force during a glide sounds by the B-spline blend of the three weights") {
  // Targets at 100 (at once), 300 (waits for 612), 400 (takes its place), 1700.
  const std::vector<std::vector<Complex>> target{weight(0), weight(.8), weight(-1.3), weight(2.2)};
  Recursion plain = three_modes();
  ModeBank bank = make_bank(plain, target[0]);
  std::vector<float> output, expected;
  struct Segment {
    std::size_t begin;
    std::size_t old, middle, latest;
  };
  const std::vector<Segment> segments{
      {100, 0, 0, 1}, {612, 0, 1, 3}, {1124, 1, 3, 3}, {1700, 3, 3, 2}, {2212, 3, 2, 2}};
  for (std::size_t n = 0; n < 3000; ++n) {
    for (const auto& [begin, goal] : {std::pair{100, 1}, {300, 2}, {400, 3}, {1700, 2}})
      if (n == static_cast<std::size_t>(begin))
        bank.set_weight(0, target[static_cast<std::size_t>(goal)]);
    const float force = n % 50 == 7 || (n > 900 && n < 1300)
                            ? static_cast<float>(std::sin(.1 * static_cast<double>(n)))
                            : 0;
    append(output, play(bank, {force}));
    plain.move(static_cast<double>(force));
    double value = plain.output(target[n < 100 ? 0 : n < 1700 ? 3 : 2]);
    for (const Segment& s : segments)
      if (n >= s.begin && n < s.begin + 512) {
        const double u = (static_cast<double>(n - s.begin) + .5) / 512;
        value = .5 * (1 - u) * (1 - u) * plain.output(target[s.old]) +
                (.5 + u * (1 - u)) * plain.output(target[s.middle]) +
                .5 * u * u * plain.output(target[s.latest]);
      }
    expected.push_back(static_cast<float>(value));
    CHECK(bank.glide(0).moving() == ((n >= 100 && n < 1635) || (n >= 1700 && n < 2723)));
  }
  CHECK(apart(expected, output) < 2e-3); // the bank's -60 dB
}

TEST_CASE("released states fade out by half a cosine, and later forces do not") {
  const auto w = weight(.3);
  Recursion old = three_modes(), latest = three_modes();
  ModeBank bank = make_bank(old, w);
  for (int n = 0; n < 100; ++n) {
    static_cast<void>(play(bank, {n == 0 ? 1.F : 0.F}));
    old.move(n == 0 ? 1 : 0);
  }
  bank.release();
  CHECK(bank.release_left() == ModeBank::kRelease);
  CHECK(bank.state(0) == Complex(0));
  std::vector<float> output, expected;
  for (std::size_t n = 0; n < 1500; ++n) {
    const double force = n == 200 ? .5 : 0;
    append(output, play(bank, {static_cast<float>(force)}));
    old.move(0);
    latest.move(force);
    const double turn = kPi * static_cast<double>(n) / static_cast<double>(ModeBank::kRelease);
    const double share = n < ModeBank::kRelease ? .5 + .5 * std::cos(turn) : 0;
    expected.push_back(static_cast<float>(share * old.output(w) + latest.output(w)));
  }
  CHECK(apart(expected, output) < 2e-3);
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
    CHECK(abs(half[k] - .5 * latest.z[k]) < 2e-3 * abs(half[k]) + 1e-9);
}

TEST_CASE("a bank is idle when silenced, released or decayed, and becomes active by a force only") {
  ModeBank bank = make_bank(three_modes(), weight(0));
  CHECK(bank.idle());
  static_cast<void>(play(bank, std::vector<float>(64, 1)));
  CHECK(!bank.idle());
  CHECK(bank.active_blocks() == 1);
  bank.silence();
  CHECK(bank.idle());
  CHECK(bank.active_blocks() == 0);
  CHECK(loudest(play(bank, std::vector<float>(128, 0))) == 0);
  CHECK(bank.idle());
  static_cast<void>(play(bank, {0, 0, 1}));
  CHECK(!bank.idle());
  bank.release();
  CHECK(!bank.idle()); // it is heard still
  static_cast<void>(play(bank, std::vector<float>(ModeBank::kRelease, 0)));
  CHECK(bank.idle());
  bank.release(); // nothing to fade
  CHECK(bank.idle());
  // 160 dB in 0.05 s of 60 dB each
  ModeBank brief = make_bank({{mode(1000, 0.05)}, {1}}, {{1, 0}});
  brief.set_audibility_floor(1e-8);
  static_cast<void>(play(brief, {48000}));
  CHECK(!brief.idle());
  static_cast<void>(play(brief, std::vector<float>(48000, 0)));
  CHECK(brief.idle());
  CHECK(brief.state(0) == 0.0);
}

TEST_CASE("states read and written in the middle of a leap are those of the present sample") {
  for (const std::size_t start_sample : {0UL, 3UL, 8UL, 13UL}) {
    Recursion plain = three_modes();
    ModeBank bank = make_bank(plain, weight(.2));
    for (std::size_t n = 0; n < start_sample; ++n) {
      static_cast<void>(play(bank, {1}));
      plain.move(1);
    }
    std::vector<Complex> z(3);
    bank.read_states(z);
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(abs(z[k] - plain.z[k]) < 1e-6 * abs(z[k]) + 1e-12);
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
  ModeBank bank = make_bank(three_modes(), weight(0));
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
  CHECK(abs(bank.weight(0, ModeBank::kLatest, 1) - weight(1)[1]) < 1e-6);
}

TEST_CASE("setting the present weights starts no glide") {
  ModeBank bank(three_modes().rate, kRate, 1, 2);
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
