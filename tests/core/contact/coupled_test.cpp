#include "core/contact/excited_body.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

// Masses on vibrating bodies, against integrations of the equations of motion.

using namespace tactus::contact;
using tactus::test::approx;

namespace {

constexpr double kNepers = 6.907755278982137; // of a decay by 60 dB
constexpr double kPi = std::numbers::pi;

struct Oscillator {
  double frequency_hz, decay_per_s, mass_kg;
};
constexpr std::array<Oscillator, 3> kThree{{{220, 12, .4}, {1130, 25, .9}, {3270, 60, 1.6}}};

std::vector<Mode> modes(std::span<const Oscillator> oscillators) {
  std::vector<Mode> list;
  for (const Oscillator& o : oscillators)
    list.push_back({o.frequency_hz, kNepers / o.decay_per_s, o.mass_kg});
  return list;
}

/// Runge and Kutta's fourth order for a mass against three oscillators.
class Reference {
public:
  Reference(const ImpactLaw& law, double mass, double speed) : law_(law), mass_(mass) {
    y_[1] = speed;
  }
  void step(double h) {
    const State a = slope(y_), b = slope(add(y_, a, 0.5 * h)), c = slope(add(y_, b, 0.5 * h)),
                d = slope(add(y_, c, h));
    const double before = depth(y_);
    for (std::size_t i = 0; i < y_.size(); ++i)
      y_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    time_ += h;
    if (before > 0 && depth(y_) <= 0)
      end_ = time_ + h * depth(y_) / (before - depth(y_));
  }
  [[nodiscard]] double velocity() const { return y_[1]; }
  [[nodiscard]] double surface_velocity() const { return y_[3] + y_[5] + y_[7]; }
  [[nodiscard]] double end() const { return end_; }

private:
  using State = std::array<double, 8>; // X, V, then q, u of each
  static State add(State y, const State& k, double h) {
    for (std::size_t i = 0; i < y.size(); ++i)
      y[i] += h * k[i];
    return y;
  }
  static double depth(const State& y) { return y[0] - y[2] - y[4] - y[6]; }
  [[nodiscard]] State slope(const State& y) const {
    const double x = depth(y), rate = y[1] - y[3] - y[5] - y[7];
    const double force =
        x > 0 ? std::max(law_.stiffness * x * std::sqrt(x) * (1 + law_.dissipation_s_per_m * rate),
                         0.0)
              : 0.0;
    State k{y[1], -force / mass_};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& [f, d, m] = kThree[i];
      const double omega = 2 * kPi * f;
      k[2 + 2 * i] = y[3 + 2 * i];
      k[3 + 2 * i] = force / m - 2 * d * y[3 + 2 * i] - (omega * omega + d * d) * y[2 + 2 * i];
    }
    return k;
  }
  ImpactLaw law_;
  double mass_, time_ = 0, end_ = 0;
  State y_{};
};

double random(std::mt19937& source, double low, double high) {
  return std::uniform_real_distribution<>(low, high)(source);
}
double log_random(std::mt19937& source, double low, double high) {
  return std::exp(random(source, std::log(low), std::log(high)));
}

} // namespace

TEST_CASE("a mass on three modes leaves with the speed, at the time and the sound of theory") {
  struct Row {
    double stiffness, speed_after, end_ms;
  };
  // Dormand and Prince's eighth order at 1e-12.
  for (const Row& row : {Row{1e6, -.79111888, 4.1324}, Row{1e8, -.60309547, .60781},
                         Row{1e10, -.51994836, .09242}}) {
    const auto [stiffness, speed_after, end_ms] = row;
    CAPTURE(row.stiffness);
    constexpr double kRate = 44100;
    constexpr int kSamples = 1323; // 30 ms
    const ImpactLaw law{stiffness, 1.5, .3};
    ExcitedBody body(3, 1);
    body.prepare(kRate);
    body.set_modes(modes(kThree));
    body.set_impact(0, law, .05);
    body.launch_mass(0, 0, 1);
    Reference exact(law, .05, 1);
    constexpr int kFine = 200;
    double error = 0, signal = 0, before = body.energy();
    for (int n = 0; n < kSamples; ++n) {
      body.step();
      CHECK(body.energy() <= before * (1 + 1e-12));
      before = body.energy();
      for (int i = 0; i < kFine; ++i)
        exact.step(1 / (kRate * kFine));
      if (n + 1 < 1e-3 * end_ms * kRate)
        continue;
      error += std::pow(body.pickup_velocity() - exact.surface_velocity(), 2);
      signal += std::pow(exact.surface_velocity(), 2);
    }
    // The reference itself, and then the object.
    CHECK(exact.velocity() == approx(speed_after).epsilon(1e-5));
    CHECK(exact.end() == approx(1e-3 * end_ms).epsilon(1e-3));
    CHECK(body.exciter(0).velocity_m_per_s == approx(speed_after).epsilon(1e-3));
    CHECK(body.exciter(0).last.duration_s == approx(1e-3 * end_ms).epsilon(1e-2));
    const double decibels = 10 * std::log10(error / signal);
    MESSAGE("sound beside the exact one: ", decibels, " dB");
    CHECK(decibels < -60);
  }
}

TEST_CASE("restitution follows from mu v alone, over three decades and any mass and stiffness") {
  for (int i = 0; i < 50; ++i) {
    const double mu_v = 0.01 * std::pow(2000.0, i / 49.0);
    // Any soft enough contact: here of three kinds, at least four samples long.
    struct Kind {
      double mass, stiffness, exponent, speed;
    };
    for (const auto& [mass, stiffness, exponent, speed] :
         {Kind{.01, 1e4, 1.5, 1}, Kind{1, 1e5, 2.5, .2}, Kind{.1, 2e4, 1, 3}}) {
      ExcitedBody wall(0, 1);
      wall.prepare(44100);
      wall.set_impact(0, {stiffness, exponent, mu_v / speed}, mass);
      wall.launch_mass(0, 0, speed);
      for (int n = 0; n < 200000 && wall.exciter(0).impact_count == 0; ++n)
        wall.step();
      REQUIRE(wall.exciter(0).impact_count == 1);
      CHECK(wall.exciter(0).last.duration_s * 44100 >= 4);
      CAPTURE(mu_v);
      CHECK(-wall.exciter(0).velocity_m_per_s / speed == approx(restitution(mu_v)).epsilon(1e-3));
    }
    // The equation that defines e.
    const double e = restitution(mu_v);
    CHECK(-e * mu_v - std::log1p(-e * mu_v) == approx(mu_v - std::log1p(mu_v)).epsilon(1e-7));
  }
  CHECK(restitution(0) == 1);
  CHECK(restitution(1e-3) == approx(1 - 2e-3 / 3).epsilon(1e-6));
  CHECK(restitution(1.0000001e-4) == approx(restitution(0.9999999e-4)).epsilon(1e-9));
  CHECK(restitution(1e6) == approx(1e-6).epsilon(1e-3));
}

TEST_CASE("a free mode keeps its frequency and decay time at any rate and step") {
  for (const double rate : {22050.0, 44100.0, 192000.0})
    for (const unsigned steps : {1U, 8U, 64U})
      for (const double share : {0.001, 0.1, 0.3, 0.48}) {
        const double t60 = 0.05, d = kNepers / t60;
        ExcitedBody body(1, 1);
        body.prepare(rate);
        body.set_min_steps(steps);
        body.set_modes(std::array{Mode{share * rate, t60, 0.25}});
        body.apply_impulse(0, 1);
        // Every sum of exp((-d +- j omega) t) satisfies this, and nothing else does.
        const double radius = std::exp(-d / rate), turn = 2 * radius * std::cos(2 * kPi * share);
        double two_ago = body.pickup_velocity(), worst = 0;
        CHECK(two_ago == approx(4));
        body.step();
        double ago = body.pickup_velocity();
        for (int n = 1; n <= 400; ++n) {
          body.step();
          worst = std::max(
              worst, std::abs(body.pickup_velocity() - turn * ago + radius * radius * two_ago));
          two_ago = std::exchange(ago, body.pickup_velocity());
        }
        CAPTURE(rate);
        CAPTURE(steps);
        CAPTURE(share);
        CHECK(worst < 1e-10);
      }
}

TEST_CASE("4000 random masses on random bodies never gain energy and stay finite") {
  std::mt19937 source(3);
  double worst = 0;
  for (int system = 0; system < 4000; ++system) {
    const double rate = std::array{44100.0, 48000.0, 96000.0}[source() % 3];
    std::vector<Mode> list(1 + source() % 8);
    std::vector<double> shape;
    for (Mode& m : list) {
      m = {log_random(source, 20, 0.489 * rate), log_random(source, 1e-3, 10),
           log_random(source, 1e-3, 10)};
      shape.push_back(random(source, -1, 1));
    }
    ExcitedBody body(8, 1);
    body.prepare(rate);
    body.set_modes(list);
    body.set_contact_shape(0, shape);
    body.set_impact(0,
                    {log_random(source, 1e2, 1e15), random(source, 1, 3.5),
                     source() % 3 ? log_random(source, 1e-3, 10) : 0},
                    log_random(source, 1e-4, 10));
    body.launch_mass(0, 0, log_random(source, 1e-3, 10));
    const double whole = body.energy();
    double before = whole;
    for (int n = 0; n < 200; ++n) {
      body.step();
      worst = std::max(worst, (body.energy() - before) / whole);
      before = body.energy();
    }
    REQUIRE(std::isfinite(before));
    REQUIRE(std::isfinite(body.pickup_velocity()));
  }
  MESSAGE("largest relative growth of energy in a sample: ", worst);
  CHECK(worst < 1e-12);
}
