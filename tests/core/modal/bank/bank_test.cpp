#include "core/modal/bank/mode_bank.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

using namespace tactus::modal;
using Complex = std::complex<double>;

namespace {

constexpr double kRate = 48000, kPi = std::numbers::pi;
constexpr VectorSet kSets[] = {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512};

Complex mode(double frequency, double t60) {
  return {-std::log(1000.0) / t60, 2 * kPi * frequency};
}

/// The equation itself, sample by sample, in double precision.
std::vector<double> by_recursion(std::span<const Complex> rates, std::span<const double> gain,
                                 std::span<const Complex> weight, std::span<const float> force) {
  std::vector<double> out(force.size(), 0);
  for (std::size_t k = 0; k < rates.size(); ++k) {
    const Complex p = std::exp(rates[k] / kRate);
    Complex z = 0;
    for (std::size_t n = 0; n < force.size(); ++n) {
      z = p * z + gain[k] * static_cast<double>(force[n]) / kRate;
      out[n] += (weight[k] * z).imag();
    }
  }
  return out;
}

double size_of(std::span<const double> x) {
  double sum = 0;
  for (const double v : x)
    sum += v * v;
  return std::sqrt(sum);
}

/// 20 log10 of |a - b| / |b|.
double error_db(std::span<const float> a, std::span<const double> b) {
  std::vector<double> difference(b.size());
  for (std::size_t n = 0; n < b.size(); ++n)
    difference[n] = static_cast<double>(a[n]) - b[n];
  return 20 * std::log10(size_of(difference) / size_of(b) + 1e-30);
}

std::vector<float> run(ModeBank& bank, std::span<const float> force, std::size_t block) {
  std::vector<float> out(force.size());
  for (std::size_t n = 0; n < force.size(); n += block) {
    const float* in = force.data() + n;
    float* to = out.data() + n;
    bank.process({&in, 1}, {&to, 1}, std::min(block, force.size() - n));
  }
  return out;
}

struct Random {
  std::mt19937 engine{5};
  double operator()(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(engine);
  }
};

} // namespace

TEST_CASE("pitch is within 0.01 cent and error below -60 dB, 20 Hz to 0.45 fs, T60 0.05 to 20 s") {
  for (const VectorSet set : kSets) {
    if (!bank_kernel(set))
      continue;
    CAPTURE(static_cast<int>(set));
    for (const double frequency : {20.0, 30.0, 100.0, 440.0, 2000.0, 7919.0, 12000.0, 21600.0})
      for (const double t60 : {0.05, 0.3, 1.0, 5.0, 20.0}) {
        if (kSanitized && t60 != 0.05 && t60 != 1)
          continue;
        CAPTURE(frequency);
        CAPTURE(t60);
        const Complex rate = mode(frequency, t60);
        ModeBank bank({&rate, 1}, kRate, 1, 1, set);
        const double gain = 1;
        const Complex weight(0.6, -0.8);
        bank.set_gain(0, {&gain, 1});
        bank.jump_to_weight(0, {&weight, 1});
        std::vector<float> force(48000, 0.0F);
        force[0] = 48000;
        const std::vector<float> output = run(bank, force, 64);
        std::vector<double> exact(force.size());
        for (std::size_t n = 0; n < exact.size(); ++n)
          exact[n] = (weight * std::exp(rate * (static_cast<double>(n) / kRate))).imag();
        CHECK(error_db(output, exact) < -60);
        // Phase drift over the decay: compare with the exact phasor late in the sound.
        bank.flush_pending();
        const Complex after = bank.state(0);
        const Complex should = std::exp(rate * (47999.0 / kRate));
        if (t60 < 0.3)
          continue;
        const double turned = std::arg(after / should) / (2 * kPi); // turns in one second
        CHECK(std::abs(1200 * std::log2(1 + turned / frequency)) < 0.01);
        CHECK(std::abs(std::log(std::abs(after) / std::abs(should))) < 0.005 * 6.9 / t60 + 2e-3);
      }
  }
}

TEST_CASE("a bank under a continuous force follows its equation, in every instruction set") {
  Random random;
  for (const std::size_t count : {1UL, 5UL, 31UL, 32UL, 33UL, 64UL, 200UL}) {
    std::vector<Complex> rates, weight;
    std::vector<double> gain;
    for (std::size_t k = 0; k < count; ++k) {
      rates.push_back(mode(random(20, 21600), random(0.05, 5)));
      weight.emplace_back(random(-1, 1), random(-1, 1));
      gain.push_back(random(-1, 1));
    }
    std::vector<float> force(4096);
    for (float& f : force)
      f = static_cast<float>(random(-100, 100));
    const auto exact = by_recursion(rates, gain, weight, force);
    for (const VectorSet set : kSets) {
      if (!bank_kernel(set))
        continue;
      CAPTURE(static_cast<int>(set));
      CAPTURE(count);
      ModeBank bank(rates, kRate, 1, 1, set);
      bank.set_gain(0, gain);
      bank.jump_to_weight(0, weight);
      CHECK(error_db(run(bank, force, 64), exact) < -80);
    }
  }
}

TEST_CASE("the same force gives the same bits in blocks of any size") {
  Random random;
  std::vector<Complex> rates, weight;
  std::vector<double> gain;
  for (std::size_t k = 0; k < 77; ++k) {
    rates.push_back(mode(random(20, 21600), random(0.05, 5)));
    weight.emplace_back(random(-1, 1), random(-1, 1));
    gain.push_back(random(-1, 1));
  }
  std::vector<float> force(8192, 0.0F);
  for (std::size_t n = 0; n < force.size(); ++n)
    if (n % 700 < 300)
      force[n] = static_cast<float>(random(-1, 1));
  const auto play = [&](std::size_t block) {
    ModeBank bank(rates, kRate, 1, 1);
    bank.set_gain(0, gain);
    bank.jump_to_weight(0, weight);
    bank.set_weight(0, weight); // a fade under way
    return run(bank, force, block);
  };
  const auto reference = play(64);
  for (const std::size_t block : {1UL, 3UL, 16UL, 63UL, 65UL, 128UL, 1000UL, 4096UL})
    CHECK(play(block) == reference);
}

TEST_CASE("forces at several points add up, and their order makes no difference") {
  Random random;
  std::vector<Complex> rates, weight;
  std::vector<std::vector<double>> gain(3);
  for (std::size_t k = 0; k < 40; ++k) {
    rates.push_back(mode(random(50, 20000), 1));
    weight.emplace_back(1, 0);
    for (auto& g : gain)
      g.push_back(random(-1, 1));
  }
  std::vector<std::vector<float>> force(3, std::vector<float>(640));
  for (auto& f : force)
    for (float& x : f)
      x = static_cast<float>(random(-1, 1));
  const auto play = [&](std::array<std::size_t, 3> order) {
    ModeBank bank(rates, kRate, 3, 1);
    bank.jump_to_weight(0, weight);
    std::array<const float*, 3> in{};
    for (std::size_t d = 0; d < 3; ++d) {
      bank.set_gain(d, gain[order[d]]);
      in[d] = force[order[d]].data();
    }
    std::vector<float> out(640);
    float* to = out.data();
    bank.process(in, {&to, 1}, out.size());
    return out;
  };
  const auto a = play({0, 1, 2}), b = play({2, 0, 1});
  std::vector<double> sum(640, 0);
  for (std::size_t d = 0; d < 3; ++d) {
    const auto one = by_recursion(rates, gain[d], weight, force[d]);
    for (std::size_t n = 0; n < sum.size(); ++n)
      sum[n] += one[n];
  }
  CHECK(error_db(a, sum) < -80);
  CHECK(error_db(b, sum) < -80);
  CHECK(error_db(b, std::vector<double>(a.begin(), a.end())) < -100);
}

TEST_CASE("each of two pick-ups gives the output of a single one with its weights") {
  const Complex rates[] = {mode(440, 1), mode(1234, 0.5)};
  const double gain[] = {1, 0.5};
  const Complex left[] = {{1, 0}, {0, 1}}, right[] = {{0.3, -0.2}, {-1, 0.5}};
  std::vector<float> force(320, 0.0F);
  force[7] = 1000;
  ModeBank bank(rates, kRate, 1, 2);
  bank.set_gain(0, gain);
  bank.jump_to_weight(0, left);
  bank.jump_to_weight(1, right);
  std::vector<float> l(320), r(320);
  const float* in = force.data();
  float* out[] = {l.data(), r.data()};
  bank.process({&in, 1}, out, 320);
  CHECK(error_db(l, by_recursion(rates, gain, left, force)) < -65);
  CHECK(error_db(r, by_recursion(rates, gain, right, force)) < -65);
}

TEST_CASE("new weights fade in without a step") {
  const Complex rate = mode(200, 20);
  const double gain = 1;
  const Complex before(0, 1), after(0, -1);
  ModeBank bank({&rate, 1}, kRate, 1, 1);
  bank.set_gain(0, {&gain, 1});
  bank.jump_to_weight(0, {&before, 1});
  std::vector<float> force(48000, 0.0F);
  force[0] = 48000;
  auto sound = run(bank, force, 64);
  bank.set_weight(0, {&after, 1});
  const auto more = run(bank, std::vector<float>(4800, 0.0F), 64);
  sound.insert(sound.end(), more.begin(), more.end());
  float step = 0;
  for (std::size_t n = 47000; n < 49000; ++n)
    step = std::max(step, std::abs(sound[n] - sound[n - 1]));
  CHECK(step < 2 * kPi * 200 / kRate * 1.2); // no steeper than the tone itself
}

TEST_CASE("a bank that has decayed is idle, and becomes active by a force") {
  const Complex rate = mode(1000, 0.05);
  const double gain = 1;
  const Complex weight(1, 0);
  ModeBank bank({&rate, 1}, kRate, 1, 1);
  bank.set_gain(0, {&gain, 1});
  bank.jump_to_weight(0, {&weight, 1});
  bank.set_audibility_floor(1e-8);
  CHECK(bank.idle());
  std::vector<float> force(48000, 0.0F);
  force[10] = 48000;
  static_cast<void>(run(bank, std::span(force).first(64), 64));
  CHECK(!bank.idle());
  static_cast<void>(run(bank, std::span(force).subspan(64), 64));
  CHECK(bank.idle());
  CHECK(bank.state(0) == 0.0);
}

TEST_CASE("a mode at rest stays at rest: no gain, no sound, to the bit") {
  const Complex rates[] = {mode(440, 1), mode(880, 1)};
  const double gain[] = {1, 0};
  const Complex weight[] = {{0, 0}, {1, 1}};
  ModeBank bank(rates, kRate, 1, 1);
  bank.set_gain(0, gain);
  bank.jump_to_weight(0, weight);
  for (const float x : run(bank, std::vector<float>(1000, 1.0F), 64))
    CHECK(x == 0);
}
