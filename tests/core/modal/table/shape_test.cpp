// A body whose shape moves while it sounds: frequencies and decays against beam theory, no click.
#include "core/modal/table/shape_sensitivity.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

constexpr double kLength = 0.3, kHeight = 0.006, kYoung = 200e9, kDensity = 7850;

/// Euler and Bernoulli's cantilever in bending: f_n = (beta_n L)^2/(2 pi L^2) sqrt(E h^2/(12 rho)).
std::vector<double> bending(double length, double height) {
  std::vector<double> frequency;
  for (const double root : {1.8751040687, 4.6940911330, 7.8547574382, 10.995540735, 14.137168391})
    frequency.push_back(root * root / (2 * kPi * length * length) *
                        std::sqrt(kYoung * height * height / (12 * kDensity)));
  return frequency;
}

/// It with the height of its section and its length as shape parameters: omega^2 ~ h^2/L^4. Without
/// shapes: every mode rings with the same gain.
ModalTable cantilever(double loss = 2e-3) {
  ModalTable table;
  table.free = false;
  table.material = {"steel", kYoung, 0.3, kDensity};
  table.frequency_hz = bending(kLength, kHeight);
  table.loss_factor.assign(5, loss);
  table.sensitivity.shape.parameters = {{0, 1, -0.003, 0.003}, {0, 0, -0.1, 0.1}};
  table.sensitivity.shape.control_point_m = {{kLength, kHeight / 2, 0}};
  table.sensitivity.shape.trust_m = 0.0006;
  for (const double of_scale : {2 / kHeight, -4 / kLength})
    for (const double f : table.frequency_hz)
      table.sensitivity.eigenvalue_slope.push_back(of_scale * 4 * kPi * kPi * f * f);
  return table;
}

std::unique_ptr<Rig> ringing(double loss = 2e-3) {
  auto made = std::make_unique<Rig>(kRate, cantilever(loss));
  Rig& rig = *made;
  rig.body.hit({{}, {0, 0, 1}, 0.5});
  static_cast<void>(rig.run(4800));
  REQUIRE(rig.body.contacts() == 0);
  return made;
}

void move(Rig& rig, double height, double length = 0) {
  rig.settings.shape_displacement_m = {height, length};
  rig.rebuild();
}

/// What each mode holds, (q'^2 + omega^2 q^2)/2.
std::vector<double> energies(Rig& rig) {
  const BodyModel& model = *rig.body.model();
  std::vector<double> energy;
  for (std::size_t k = 0; k < model.audible_modes; ++k) {
    const auto [q, speed] = rig.motion(k);
    energy.push_back((speed * speed + norm(model.rate[model.index_of[k]]) * q * q) / 2);
  }
  return energy;
}

} // namespace

TEST_CASE("a cantilever's bending modes follow height and length of its section to first order") {
  const auto loaded = std::make_shared<const LoadedTable>(cantilever());
  BodySettings settings = no_radiation();
  for (const double x : {-0.2, -0.05, -0.01, 0.01, 0.05, 0.2})
    for (const bool of_length : {false, true}) {
      CAPTURE(x);
      CAPTURE(of_length);
      settings.shape_displacement_m = {of_length ? 0 : x * kHeight, of_length ? x * kLength : 0};
      const BodyModel model(loaded, settings);
      const auto exact =
          of_length ? bending(kLength * (1 + x), kHeight) : bending(kLength, kHeight * (1 + x));
      // ln f ~ n ln(1 + x) against n x, n = 1 and -2: the error is n (x^2/2 - x^3/3 ...).
      const double n = of_length ? -2 : 1, error = n * (x - std::log1p(x));
      for (std::size_t k = 0; k < 5; ++k) {
        const Complex s = model.rate[model.index_of[k]];
        const double f = abs(s) / (2 * kPi);
        CHECK(std::log(f / exact[k]) == approx(error).epsilon(1e-9));
        CHECK(std::abs(std::log(f / exact[k])) < std::abs(n) * x * x / (2 - std::abs(x) * 4));
        CHECK(-s.real() == approx(kPi * f * 2e-3).epsilon(1e-9)); // the loss factor stays
      }
    }
}

TEST_CASE("two bodies in one list take the shape of the first alone") {
  ModalTable one = plate(.32, .2, .005, 2000, 8, 6), two = plate(.4, .3, .008, 2000, 8, 6);
  one.sensitivity.shape.parameters = {{0, 2, -0.001, 0.001}};
  one.sensitivity.shape.control_point_m = {{0, 0, 0}};
  one.sensitivity.shape.trust_m = 0.001;
  for (const double f : one.frequency_hz)
    one.sensitivity.eigenvalue_slope.push_back(2 / 0.005 * 4 * kPi * kPi * f * f);
  const auto f1 = one.frequency_hz, f2 = two.frequency_hz;
  const auto joined = std::make_shared<const LoadedTable>(
      std::make_shared<const LoadedTable>(std::move(one)),
      std::make_shared<const LoadedTable>(std::move(two)), Vec3{0, 0, -0.01});
  BodySettings settings = no_radiation();
  settings.shape_displacement_m = {0.0005};
  const BodyModel model(joined, settings);
  const auto frequency = [&](std::size_t part, std::size_t k) {
    return abs(model.rate[model.index_of[joined->parts[part].mode[k]]]) / (2 * kPi);
  };
  for (std::size_t k = 0; k < f1.size(); ++k)
    CHECK(frequency(0, k) == approx(f1[k] * std::exp(0.1)).epsilon(1e-9));
  for (std::size_t k = 0; k < f2.size(); ++k)
    CHECK(frequency(LoadedTable::kBoard, k) == approx(f2[k]).epsilon(1e-9));
}

TEST_CASE("displacements of 0 and of another table leave every bit as it is") {
  const auto play = [](const std::vector<double>& displacement) {
    Rig rig(kRate, cantilever());
    rig.settings.shape_displacement_m = displacement;
    rig.rebuild(false);
    rig.body.hit({{}, {0, 0, 1}, 0.5});
    return rig.run(4800).left;
  };
  const auto still = play({});
  CHECK(loudest(still) > 0);
  CHECK(play({0, 0}) == still);
  CHECK(play({0.001}) == still);
  CHECK(play({0.001, 0}) != still);
}

TEST_CASE("a ringing mode keeps its energy when its pitch moves, at once or by and by") {
  for (const int steps : {1, 250}) {
    auto made = ringing(0);
    const auto before = energies(*made);
    for (int step = 1; step <= steps; ++step) {
      move(*made, 0.1 * kHeight * step / steps);
      static_cast<void>(made->run(64));
    }
    const auto after = energies(*made);
    for (std::size_t k = 0; k < after.size(); ++k)
      CHECK(after[k] == approx(before[k]).epsilon(1e-3));
  }
}

TEST_CASE("no displacement leads to rates outside the bank's range") {
  const ModalTable table = cantilever();
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity(), huge = 1e300;
  for (const double height : {nan, infinite, -infinite, huge, -huge, 1e-320})
    for (const double length : {nan, -infinite, huge, 0.}) {
      for (const double factor :
           frequency_factors(table.sensitivity, table.frequency_hz, std::array{height, length})) {
        CHECK(factor >= 1 / kMaxShapeFactor);
        CHECK(factor <= kMaxShapeFactor);
      }
      const auto made = ringing();
      Rig& rig = *made;
      move(rig, height, length);
      for (const Complex& s :
           std::span(rig.body.model()->rate).first(rig.body.model()->audible_modes))
        CHECK(abs(s) / (2 * kPi) < 0.45 * kRate);
      CHECK(is_finite(rig.run(480).left));
      move(rig, 0);
      CHECK(is_finite(rig.run(480).left));
    }
}
