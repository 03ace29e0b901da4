// The modes that a contact meets: passes of one and two steps, in double and in single precision,
// against the recursion written out.
#include "core/modal/contact/contact_modes.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr std::size_t kSmall = 40, kLarge = ContactModes::kMaxModesInDouble + 88;

struct Body {
  explicit Body(std::size_t count) {
    std::mt19937 random(static_cast<unsigned>(count));
    std::uniform_real_distribution<> plain(-1, 1);
    for (std::size_t k = 0; k < count; ++k) {
      rate.emplace_back(-1 - 50 * std::abs(plain(random)),
                        2 * kPi *
                            (20 + 24000.0 * static_cast<double>(k) / static_cast<double>(count)));
      gain.push_back(plain(random));
      other.push_back(plain(random));
      weight.emplace_back(plain(random), plain(random));
    }
  }
  std::vector<Complex> rate, weight;
  std::vector<double> gain, other;
};

/// z <- p z + b F (p - 1)/s, mode by mode.
struct RecursionReference {
  explicit RecursionReference(const Body& of, double seconds)
      : body(of), step(seconds), z(of.rate.size()) {}
  double free_displacement() const {
    double sum = 0;
    for (std::size_t k = 0; k < z.size(); ++k)
      sum += body.gain[k] / body.rate[k].imag() * (exp(body.rate[k] * step) * z[k]).imag();
    return sum;
  }
  void move(double force, double beside = 0) {
    for (std::size_t k = 0; k < z.size(); ++k) {
      const Complex p = exp(body.rate[k] * step);
      z[k] = p * z[k] + (body.gain[k] * force + body.other[k] * beside) * (p - 1.0) / body.rate[k];
    }
  }
  double outputs() const {
    double sum = 0;
    for (std::size_t k = 0; k < z.size(); ++k)
      sum += (body.weight[k] * z[k]).imag();
    return sum;
  }
  const Body& body;
  double step;
  std::vector<Complex> z;
};

} // namespace

TEST_CASE("passes of one and two steps move the modes as the recursion written out does") {
  for (const std::size_t count : {std::size_t{1}, std::size_t{17}, kLarge}) {
    for (const std::size_t ahead : {1UL, 2UL}) {
      CAPTURE(count);
      CAPTURE(ahead);
      const double exact = count > ContactModes::kMaxModesInDouble ? 5e-5 : 1e-11;
      constexpr unsigned kSteps = 4;
      const Body body(count);
      RecursionReference plain(body, 1 / (kRate * kSteps));
      const auto modes = ContactModes::make(body.rate, kRate, 16, 2, 1);
      modes->set_steps(kSteps);
      modes->set_weight(0, body.weight);
      double squares = 0;
      for (const double b : body.gain)
        squares += b * b;
      CHECK(modes->set_gain(0, body.gain) == approx(squares));
      static_cast<void>(modes->set_gain(1, body.other));
      double largest = 0, displacement_error = 0, loudest = 0, output_error = 0;
      for (std::size_t n = 0; n < 1000; n += ahead) {
        const double* const found =
            modes->predict_displacement(0, ahead, n % kSteps + ahead == kSteps);
        double force[2] = {}, expected_displacement[2] = {found[0], ahead > 1 ? found[1] : 0};
        for (std::size_t j = 0; j < ahead; ++j) {
          force[j] = n % 97 < 40 ? 100 * std::sin(0.3 * static_cast<double>(n + j)) : 0;
          if (j == 1)
            expected_displacement[1] += modes->compliance(0, 0, 1) * force[0];
          const double should = plain.free_displacement();
          largest = std::max(largest, std::abs(should));
          displacement_error =
              std::max(displacement_error, std::abs(expected_displacement[j] - should));
          plain.move(force[j]);
        }
        modes->apply_forces(force);
        if (n % kSteps + ahead == kSteps) {
          loudest = std::max(loudest, std::abs(plain.outputs()));
          output_error = std::max(output_error, std::abs(modes->output(0) - plain.outputs()));
        }
        if (n == 500) { // an impulse from elsewhere, between two passes
          std::vector<float> gains(count, 0.25F);
          modes->apply_impulse(gains, 1e-3);
          for (Complex& z : plain.z)
            z += 0.25 * 1e-3;
        }
      }
      CHECK(displacement_error < exact * largest);
      CHECK(output_error < exact * loudest);
      for (std::size_t k = 0; k < count; k += 7)
        CHECK(abs(modes->state(k) - plain.z[k]) < exact * (abs(plain.z[k]) + 1e-2));
    }
  }
}

TEST_CASE("any number of listeners gives the output of each alone") {
  for (const std::size_t count : {kSmall, kLarge}) {
    const double exact = count > ContactModes::kMaxModesInDouble ? 5e-5 : 1e-11;
    const Body body(count);
    const auto weight = [&](std::size_t listener) {
      std::vector<Complex> w;
      for (std::size_t k = 0; k < count; ++k)
        w.push_back(body.weight[k] * tactus::math::polar(1., static_cast<double>(k * listener)));
      return w;
    };
    constexpr std::size_t kListeners = 12;
    const auto modes = ContactModes::make(body.rate, kRate, 4, 1, kListeners);
    modes->set_steps(4);
    static_cast<void>(modes->set_gain(0, body.gain));
    RecursionReference plain(body, 1 / (kRate * 4));
    for (std::size_t listening = 1; listening <= kListeners; ++listening) {
      for (std::size_t l = 0; l < listening; ++l)
        modes->set_weight(l, weight(l));
      modes->set_listening(listening);
      for (int n = 0; n < 3; ++n) {
        for (int pass = 0; pass < 2; ++pass) {
          const double force[2] = {1. + n, 2. - pass};
          static_cast<void>(modes->predict_displacement(0, 2, pass == 1));
          modes->apply_forces(force);
          plain.move(force[0]);
          plain.move(force[1]);
        }
        for (std::size_t l = 0; l < listening; ++l) {
          Complex sum = 0, size = 0;
          const auto w = weight(l);
          for (std::size_t k = 0; k < count; ++k) {
            sum += w[k] * plain.z[k];
            size += abs(w[k] * plain.z[k]);
          }
          CAPTURE(listening);
          CAPTURE(l);
          CHECK(std::abs(modes->output(l) - sum.imag()) < exact * size.real());
        }
      }
    }
  }
}

TEST_CASE("the force of a second contact is in its displacement, the output and the states") {
  for (const std::size_t count : {kSmall, kLarge}) {
    const double exact = count > ContactModes::kMaxModesInDouble ? 5e-5 : 1e-11;
    const Body body(count);
    RecursionReference plain(body, 1 / kRate);
    const auto modes = ContactModes::make(body.rate, kRate, 1, 2, 1);
    modes->set_weight(0, body.weight);
    static_cast<void>(modes->set_gain(0, body.gain));
    static_cast<void>(modes->set_gain(1, body.other));
    for (int n = 0; n < 200; ++n) {
      const double first = std::sin(0.2 * n), second = std::cos(0.11 * n);
      const double should = plain.free_displacement();
      const double found = *modes->predict_displacement(0, 1, true);
      CHECK(std::abs(found - should) < exact * (std::abs(should) + 1e-4));
      modes->apply_forces(&first);
      modes->apply_force_at(1, second);
      plain.move(first, second);
      if (n % 3 == 0) { // and an impulse from elsewhere
        modes->apply_impulse(std::vector<float>(count, 0.25F), 1e-3);
        for (Complex& z : plain.z)
          z += 0.25e-3;
      }
      CHECK(std::abs(modes->output(0) - plain.outputs()) <
            exact * (std::abs(plain.outputs()) + 1e-1));
    }
  }
}

TEST_CASE("the motion bounds of a point are above the largest amplitude, by little") {
  const Body body(kSmall);
  const auto modes = ContactModes::make(body.rate, kRate, 1, 1, 0);
  static_cast<void>(modes->set_gain(0, body.gain));
  double displacement = 0, speed = 0;
  for (std::size_t k = 0; k < kSmall; ++k) {
    const Complex z =
        tactus::math::polar(1.0 + 0.1 * static_cast<double>(k), static_cast<double>(k));
    modes->set_state(k, z);
    displacement += std::abs(body.gain[k] / body.rate[k].imag()) * abs(z);
    speed += std::abs(body.gain[k]) * abs(z);
  }
  const auto bounds = modes->motion_bounds(0);
  CHECK(bounds.displacement >= displacement);
  CHECK(bounds.speed >= speed);
  CHECK(bounds.displacement < 1.09 * displacement);
  CHECK(bounds.speed < 1.09 * speed);
}

TEST_CASE("every instruction set makes the same pass, but for rounding") {
  const auto play = [](auto one, VectorSet set) {
    using T = decltype(one);
    constexpr std::size_t kCount = 64;
    LaneArray<T> lanes[9];
    for (std::size_t a = 0; a < 9; ++a) {
      lanes[a] = LaneArray<T>(kCount);
      for (std::size_t k = 0; k < kCount; ++k)
        lanes[a][k] =
            static_cast<T>((a == 2 ? -1e-3 : 0.1) * std::sin(static_cast<double>(9 * k + a)));
    }
    const ConstSplitView<T> pickups[] = {{lanes[7].data(), lanes[8].data()},
                                         {lanes[8].data(), lanes[7].data()},
                                         {lanes[6].data(), lanes[7].data()}};
    ContactPass<T> pass;
    pass.count = kCount;
    pass.z = {lanes[0].data(), lanes[1].data()};
    pass.pole_minus_one = {lanes[2].data(), lanes[3].data()};
    pass.input_gain = {lanes[4].data(), lanes[5].data()};
    pass.gain = lanes[6].data();
    pass.pickup = pickups;
    std::vector<double> found;
    for (std::size_t n = 0; n < 60; ++n) {
      pass.pickups = n % 4;
      pass.steps = 1 + n % 2;
      pass.force[0] = 0.3;
      pass.force[1] = -0.1;
      contact_kernels(set).of<T>()->advance(pass);
      pass.pending = pass.steps == 2 && n % 3 ? 2 : 1;
      if (pass.pending == 2) // the next pass must be one of two steps
        ++n;
      found.insert(found.end(), {pass.displacement[0], pass.steps == 2 ? pass.displacement[1] : 0});
      for (std::size_t e = 0; e < pass.pickups; ++e)
        found.push_back(pass.outputs[e]);
    }
    return found;
  };
  for (const VectorSet set : {VectorSet::kAvx2, VectorSet::kAvx512}) {
    if (!tactus::simd::runs(set))
      continue;
    const auto exact = play(1.0, VectorSet::kBaseline), same = play(1.0, set);
    const auto single = play(1.0F, set);
    REQUIRE(exact.size() == same.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CHECK(same[i] == approx(exact[i]).epsilon(1e-11).scale(1));
      CHECK(single[i] == approx(exact[i]).epsilon(1e-4).scale(1));
    }
  }
}
