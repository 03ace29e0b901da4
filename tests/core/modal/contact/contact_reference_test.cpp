// A struck body's contacts beside an integration of the equations of motion in steps a hundred
// times finer.
#include "core/modal/contact/contact_solver.hpp"
#include "tests/core/modal/contact/reference.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

struct FlyingStriker {
  ContactSolver::Strike strike;
  std::vector<double> gain;
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
/// impulses, the strikers' and the modes' motion are the same within `tolerance` of the largest.
void compare(const std::vector<Complex>& rate, const std::vector<FlyingStriker>& strikers,
             double rigid, int samples, double tolerance, std::size_t impact_count = 1) {
  FineIntegration fine;
  for (const Complex& s : rate)
    fine.add(s, 0, 0);
  const std::size_t recoil = fine.add(0, 0, 0);
  for (const FlyingStriker& s : strikers) {
    const double root = std::sqrt(s.strike.mass_kg);
    fine.contacts.push_back({s.strike.law, 0, s.gain});
    fine.contacts.back().gain.resize(recoil + fine.contacts.size());
    fine.contacts.back().gain[recoil] = rigid;
    const std::size_t own =
        fine.add(0, root * s.strike.position_m, root * s.strike.velocity_m_per_s,
                 root * s.strike.fall_m_per_s2);
    fine.contacts.back().gain[own] = -1 / root;
  }
  ContactSolver solver(rate, kRate, strikers.size(), rigid != 0);
  for (std::size_t i = 0; i < strikers.size(); ++i)
    solver.begin(i, strikers[i].strike, strikers[i].gain, {0, rigid, 0, 0, 0, 0});
  std::vector<double> impulse(strikers.size(), 0);
  for (int n = 0; n < samples && solver.touching(); ++n) {
    static_cast<void>(solver.step());
    fine.step(1 / kRate, 100);
    for (std::size_t i = 0; i < strikers.size(); ++i)
      impulse[i] += solver.contact(i).exciter.force_n / kRate;
  }
  CHECK(solver.contact(0).exciter.impact_count >= impact_count);
  double maximum = 0, fastest = 0;
  for (const auto& contact : fine.contacts)
    maximum = std::max(maximum, contact.impulse_ns);
  for (std::size_t k = 0; k < rate.size(); ++k)
    fastest =
        std::max({fastest, std::abs(fine.velocity(k)), abs(rate[k]) * std::abs(fine.position(k))});
  for (std::size_t i = 0; i < strikers.size(); ++i) {
    CAPTURE(i);
    const auto& s = strikers[i].strike;
    CHECK(std::abs(impulse[i] - fine.contacts[i].impulse_ns) < tolerance * maximum);
    CHECK(std::abs(solver.contact(i).exciter.velocity_m_per_s -
                   fine.velocity(recoil + 1 + i) / std::sqrt(s.mass_kg)) <
          tolerance * s.velocity_m_per_s);
  }
  for (std::size_t k = 0; k < rate.size(); ++k) {
    CAPTURE(k);
    // z = q' + alpha q + j omega q
    const Complex z = solver.state(k);
    CHECK(std::abs(z.imag() - rate[k].imag() * fine.position(k)) < tolerance * fastest);
    CHECK(std::abs(z.real() + rate[k].real() * fine.position(k) - fine.velocity(k)) <
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
  std::vector<FlyingStriker> strikers;
  for (int k = 0; k < 6; ++k)
    rate.emplace_back(-5. - 3 * k, 2 * kPi * (240. + 530 * k));
  for (int i = 0; i < 4; ++i) {
    FlyingStriker s{strike(.004 + .003 * i, 4e7 + 1e7 * i, 1.5, .05 * i, .6 + .3 * i), {}};
    s.strike.position_m = -2e-4 * i; // one after the other
    for (int k = 0; k < 6; ++k)
      s.gain.push_back(4 * std::cos(.4 + i + 1.7 * k));
    strikers.push_back(s);
  }
  for (const std::ptrdiff_t count : {2, 3, 4}) {
    CAPTURE(count);
    compare(rate, {strikers.begin(), strikers.begin() + count}, 3, 60, .005);
  }
}

TEST_CASE("gravity acts on a striker during its contact with a swinging body") {
  FlyingStriker ball{strike(.2, 2e4, 1, 0, .3), {1.5}};
  ball.strike.fall_m_per_s2 = 9.80665;
  compare({{-3, 2 * kPi * 60}}, {ball}, 0, 700, .004, 0);
}
