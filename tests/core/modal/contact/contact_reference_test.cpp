// A struck body's contacts beside an integration of the equations of motion by Runge and Kutta's
// method in steps a hundred times finer, which shares nothing with the solver.
#include "core/modal/contact/contact_solver.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using namespace tactus;
using modal::ContactSolver;
using Complex = std::complex<double>;

namespace {

constexpr double kRate = 48000, kPi = std::numbers::pi, kGravity = 9.80665;

struct Striker {
  ContactSolver::Strike strike;
  std::vector<double> gain;
};

/// q'' + 2 alpha q' + (omega^2 + alpha^2) q = sum b F for each mode, p'' = sum b F for a free
/// body's motion, m x'' = m g - F for each striker, F = k d^a (1 + mu d'), d = x - sum b q - b p.
class Reference {
public:
  Reference(std::vector<Complex> rate, std::vector<Striker> strikers, double rigid)
      : rate_(std::move(rate)), strikers_(std::move(strikers)), rigid_(rigid) {
    state_.assign(2 * (rate_.size() + 1 + strikers_.size()), 0);
    for (std::size_t i = 0; i < strikers_.size(); ++i) {
      position(state_, i) = strikers_[i].strike.position_m;
      speed(state_, i) = strikers_[i].strike.velocity_m_per_s;
    }
    impulse.assign(strikers_.size(), 0);
  }
  /// One sample in so many steps.
  void step(int steps = 400) {
    const double h = 1 / (kRate * steps);
    for (int s = 0; s < steps; ++s) {
      const auto a = slope(state_), b = slope(ahead(a, h / 2)), c = slope(ahead(b, h / 2)),
                 d = slope(ahead(c, h));
      for (std::size_t i = 0; i < strikers_.size(); ++i)
        impulse[i] += h * force(state_, i);
      for (std::size_t k = 0; k < state_.size(); ++k)
        state_[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
    }
  }
  [[nodiscard]] double displacement(std::size_t mode) const { return state_[2 * mode]; }
  [[nodiscard]] double velocity(std::size_t mode) const { return state_[2 * mode + 1]; }
  [[nodiscard]] double striker_speed(std::size_t i) { return speed(state_, i); }
  std::vector<double> impulse; ///< N s that each striker has given

private:
  using State = std::vector<double>;
  double& position(State& y, std::size_t i) const { return y[2 * (rate_.size() + 1 + i)]; }
  double& speed(State& y, std::size_t i) const { return y[2 * (rate_.size() + 1 + i) + 1]; }
  [[nodiscard]] State ahead(const State& slope, double h) const {
    State y = state_;
    for (std::size_t k = 0; k < y.size(); ++k)
      y[k] += h * slope[k];
    return y;
  }
  [[nodiscard]] double force(State y, std::size_t i) const {
    const auto& law = strikers_[i].strike.law;
    double depth = position(y, i), rate = speed(y, i);
    for (std::size_t k = 0; k <= rate_.size(); ++k) {
      const double b = k < rate_.size() ? strikers_[i].gain[k] : rigid_;
      depth -= b * y[2 * k];
      rate -= b * y[2 * k + 1];
    }
    return depth > 0 ? std::max(law.stiffness * std::pow(depth, law.exponent) *
                                    (1 + law.dissipation_s_per_m * rate),
                                0.0)
                     : 0;
  }
  [[nodiscard]] State slope(State y) const {
    State dy(y.size());
    for (std::size_t k = 0; k < rate_.size(); ++k) {
      dy[2 * k] = y[2 * k + 1];
      dy[2 * k + 1] = -std::norm(rate_[k]) * y[2 * k] + 2 * rate_[k].real() * y[2 * k + 1];
    }
    dy[2 * rate_.size()] = y[2 * rate_.size() + 1];
    for (std::size_t i = 0; i < strikers_.size(); ++i) {
      const double f = force(y, i);
      for (std::size_t k = 0; k <= rate_.size(); ++k)
        dy[2 * k + 1] += f * (k < rate_.size() ? strikers_[i].gain[k] : rigid_);
      position(dy, i) = speed(y, i);
      speed(dy, i) = strikers_[i].strike.fall_m_per_s2 - f / strikers_[i].strike.mass_kg;
    }
    return dy;
  }

  std::vector<Complex> rate_;
  std::vector<Striker> strikers_;
  double rigid_;
  State state_;
};

ContactSolver::Strike strike(double mass_kg, double stiffness, double exponent, double loss,
                             double velocity) {
  ContactSolver::Strike s;
  s.law = {stiffness, exponent, loss};
  s.mass_kg = mass_kg;
  s.velocity_m_per_s = velocity;
  return s;
}

/// Both for so many samples, or until nothing touches, when the modes pass to the bank; the
/// impulses and the modes' motion are the same within `tolerance` of
/// the largest.
void compare(const std::vector<Complex>& rate, const std::vector<Striker>& strikers, double rigid,
             int samples, double tolerance, std::size_t impact_count = 1) {
  Reference reference(rate, strikers, rigid);
  ContactSolver solver(rate, kRate, strikers.size(), rigid != 0);
  for (std::size_t i = 0; i < strikers.size(); ++i)
    solver.begin(i, strikers[i].strike, strikers[i].gain, {0, rigid, 0, 0, 0, 0});
  std::vector<double> impulse(strikers.size(), 0);
  for (int n = 0; n < samples && solver.touching(); ++n) {
    static_cast<void>(solver.step());
    reference.step();
    for (std::size_t i = 0; i < strikers.size(); ++i)
      impulse[i] += solver.contact(i).exciter.force_n / kRate;
  }
  CHECK(solver.contact(0).exciter.impact_count >= impact_count);
  double maximum = 0, fastest = 0;
  for (const double j : reference.impulse)
    maximum = std::max(maximum, j);
  for (std::size_t k = 0; k < rate.size(); ++k)
    fastest = std::max({fastest, std::abs(reference.velocity(k)),
                        std::abs(rate[k]) * std::abs(reference.displacement(k))});
  for (std::size_t i = 0; i < strikers.size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(impulse[i] - reference.impulse[i]) < tolerance * maximum);
    CHECK(std::abs(solver.contact(i).exciter.velocity_m_per_s - reference.striker_speed(i)) <
          tolerance * strikers[i].strike.velocity_m_per_s);
  }
  for (std::size_t k = 0; k < rate.size(); ++k) {
    CAPTURE(k);
    // z = q' + alpha q + j omega q
    const Complex z = solver.state(k);
    CHECK(std::abs(z.imag() - rate[k].imag() * reference.displacement(k)) < tolerance * fastest);
    CHECK(std::abs(z.real() + rate[k].real() * reference.displacement(k) - reference.velocity(k)) <
          tolerance * fastest);
  }
}

} // namespace

TEST_CASE("a striker that a slow mode meets several times follows a fine integration") {
  // Heavier than the mode is at its place: the surface runs away, comes back and meets it twice
  // more within ten milliseconds.
  const std::vector<Complex> rate{{-8, 2 * kPi * 310}, {-15, 2 * kPi * 905}};
  compare(rate, {{strike(.05, 1e6, 1, 0, 1), {9, 4}}}, 0, 500, .004, 3);
  compare(rate, {{strike(.05, 3e7, 1.5, .1, 1), {9, -4}}}, 2, 500, .004, 2);
}

TEST_CASE("strikers at several points of a free body interact through it") {
  std::vector<Complex> rate;
  std::vector<Striker> strikers;
  for (int k = 0; k < 6; ++k)
    rate.emplace_back(-5. - 3 * k, 2 * kPi * (240. + 530 * k));
  for (int i = 0; i < 4; ++i) {
    Striker s{strike(.004 + .003 * i, 4e7 + 1e7 * i, 1.5, .05 * i, .6 + .3 * i), {}};
    s.strike.position_m = -2e-4 * i; // one after the other
    for (int k = 0; k < 6; ++k)
      s.gain.push_back(4 * std::cos(.4 + i + 1.7 * k));
    strikers.push_back(s);
  }
  for (const std::size_t count : {2UL, 3UL, 4UL}) {
    CAPTURE(count);
    compare(rate, {strikers.begin(), strikers.begin() + static_cast<std::ptrdiff_t>(count)}, 3, 60,
            .005);
  }
}

TEST_CASE("gravity acts on a striker during its contact with a swinging body") {
  const std::vector<Complex> rate{{-3, 2 * kPi * 60}};
  Striker ball{strike(.2, 2e4, 1, 0, .3), {1.5}};
  ball.strike.fall_m_per_s2 = kGravity;
  compare(rate, {ball}, 0, 700, .004, 0);
}
