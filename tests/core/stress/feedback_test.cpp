// Feedback scalars against their equations, and the fast kernel against the plain sum.
#include "core/stress/feedback.hpp"
#include "core/stress/stress_model.hpp"
#include "core/stress/vector_ramp.hpp"
#include "tests/approx.hpp"
#include "tests/core/stress/tables.hpp"

#include <limits>
#include <random>

using namespace tactus;
using namespace tactus::stress;
using test::approx;
using test::Cantilever;

namespace {

const std::vector<double> kAtRest{0, 0, 0};

Feedback feedback_of(StressTable table, FeedbackSettings settings,
                     std::optional<std::size_t> point = 0,
                     const std::vector<double>& displacement = kAtRest) {
  StressModel model(test::shared(std::move(table)));
  model.select(settings, point);
  return model.update(displacement);
}

void near(double value, double expected) { CHECK(std::abs(value - expected) <= 1e-10); }

} // namespace

TEST_CASE("the specification's four elements: mean, weighted and axis") {
  FeedbackSettings settings;
  settings.range = Range::kCurrent;
  const auto check = [&settings](Mapping mapping, const Vec3& raw, const Vec3& gamma) {
    settings.mapping = mapping;
    const Feedback f = feedback_of(test::four_elements(), settings);
    CHECK(norm(f.raw - raw) < 1e-10);
    CHECK(norm(f.gamma - gamma) < 1e-10);
    near(f.mean_pa, 25);
    return f;
  };
  check(Mapping::kMean, {25, 25, 25}, {0.5, 0.5, 0.5});
  const Feedback f = check(Mapping::kWeighted, {15, 15, 15}, Vec3{1, 1, 1} * (7.0 / 22.0));
  near(f.min.x, 10.0 / 3.0);
  near(f.max.x, 40);
  check(Mapping::kAxis, {12.5, 15, 17.5}, {0.3125, 0.375, 0.4375});
}

TEST_CASE("equal stresses give gamma 0, and gamma stays within 0 and 1") {
  StressTable even = test::four_elements();
  even.base.von_mises.stress = {7, 7, 7, 7};
  even.base.von_mises.sensitivity.assign(12, 2);
  for (const Mapping mapping : {Mapping::kMean, Mapping::kWeighted, Mapping::kAxis})
    for (const Range range : {Range::kCurrent, Range::kInitial}) {
      FeedbackSettings settings;
      settings.mapping = mapping;
      settings.range = range;
      CHECK(feedback_of(even, settings).gamma == Vec3{});
    }
  FeedbackSettings fixed;
  fixed.range = Range::kFixed;
  fixed.fixed_min = 30;
  fixed.fixed_max = 40;
  CHECK(feedback_of(test::four_elements(), fixed).gamma.x == 0);
  fixed.fixed_min = 0;
  fixed.fixed_max = 20;
  CHECK(feedback_of(test::four_elements(), fixed).gamma.x == 1);
  fixed.fixed_max = 100;
  near(feedback_of(test::four_elements(), fixed).gamma.x, 0.25);
  CHECK(gamma_of(std::nan(""), 0, 1) == 0);
  CHECK(gamma_of(1, 2, 1) == 0);
  CHECK(gamma_of(std::numeric_limits<double>::infinity(), 0, 1) == 1);
}

TEST_CASE(
    "a part that becomes stronger everywhere changes gamma in range initial, not in current") {
  StressTable table = test::four_elements();
  // One parameter scales all stresses: ds/dp = -s.
  table.base.von_mises.sensitivity = {-10, -20, -30, -40};
  table.parameters.resize(1);
  table.base.displacement_m = {0};
  FeedbackSettings settings;
  settings.range = Range::kCurrent;
  near(feedback_of(table, settings, 0, {0.5}).gamma.x, 0.5);
  settings.range = Range::kInitial;
  near(feedback_of(table, settings, 0, {0.5}).gamma.x, (12.5 - 10) / 30);
}

TEST_CASE("signed sensitivities cancel, magnitudes do not") {
  StressTable table = test::four_elements();
  table.base.von_mises.sensitivity = {1, -1, 1, -1, 0, 0, 0, 0, -2, 2, -2, 2};
  const auto of = [&table](Mapping mapping, Sensitivity sensitivity) {
    FeedbackSettings settings;
    settings.mapping = mapping;
    settings.sensitivity = sensitivity;
    return feedback_of(table, settings);
  };
  const Feedback axes = of(Mapping::kAxis, Sensitivity::kSigned);
  CHECK(norm(axes.raw - Vec3{(10 - 20 + 30 - 40) / 4.0, 0, (-20 + 40 - 60 + 80) / 4.0}) < 1e-10);
  near(axes.min.x, -40);
  CHECK(norm(of(Mapping::kAxis, Sensitivity::kAbsolute).raw - Vec3{25, 0, 50}) < 1e-10);
  near(of(Mapping::kWeighted, Sensitivity::kAbsolute).raw.x, 25); // (1 + 0 + 2)/3 = 1
  near(of(Mapping::kWeighted, Sensitivity::kSigned).raw.x, (-10 + 20 - 30 + 40) / 12.0);
}

TEST_CASE("the grabbed point's sensitivities weigh; with none the mean over those that can move") {
  StressTable table = test::four_elements();
  table.base.von_mises.sensitivity = {1, 1, 1, 1, -3, -3, -3, -3, 2, 2, 2, 2};
  table.parameters = {{0, 0, -1, 1}, {2, 0, -1, 1}, {2, 1, -1, 1}};
  table.control_point_m.resize(4); // 1 and 3 cannot move
  FeedbackSettings settings;
  settings.mapping = Mapping::kAxis;
  near(feedback_of(table, settings, 0).raw.x, 25);
  near(feedback_of(table, settings, 0).raw.y, 0);
  near(feedback_of(table, settings, 2).raw.x, 75);
  near(feedback_of(table, settings, 2).raw.y, 50);
  near(feedback_of(table, settings, std::nullopt).raw.x, 50); // (|1| + |-3|)/2
  near(feedback_of(table, settings, std::nullopt).raw.y, 25);
  settings.sensitivity = Sensitivity::kSigned;
  near(feedback_of(table, settings, std::nullopt).raw.x, -25);
}

TEST_CASE("weights by volume make the mean that of the body, whatever the mesh") {
  StressTable table = test::four_elements();
  table.weight = {1, 1, 1, 5};
  FeedbackSettings settings;
  near(feedback_of(table, settings).raw.x, 25);
  settings.weights = Weights::kVolume;
  near(feedback_of(table, settings).raw.x, (10 + 20 + 30 + 200) / 8.0);
  near(feedback_of(table, settings).mean_pa, 32.5);
  settings.norm = Norm::kSum;
  near(feedback_of(table, settings).raw.x, 4 * 32.5);
  settings.weights = Weights::kUniform;
  near(feedback_of(table, settings).raw.x, 100);
  near(feedback_of(table, settings).mean_pa, 25);
  table.weight.clear();
  settings.weights = Weights::kVolume;
  near(feedback_of(table, settings).raw.x, 100);
}

TEST_CASE("maximum shear is a field of its own; a table without it gives von Mises") {
  StressTable table = test::four_elements();
  FeedbackSettings settings;
  settings.state = State::kShear;
  near(feedback_of(table, settings).raw.x, 25);
  table.base.max_shear = {{1, 2, 3, 6}, table.base.von_mises.sensitivity};
  near(feedback_of(table, settings).raw.x, 3);
  near(feedback_of(table, settings, 0, {0, 0, 0.5}).raw.x, 3.25);
}

TEST_CASE("Taylor's series of a cantilever is exact to first order: its error grows as d^2") {
  StressModel model(test::shared(Cantilever::table()));
  double before = 0;
  for (const double d : {0.0005, 0.001, 0.002}) {
    const double mean = model.update(std::vector<double>{d, 0}).mean_pa;
    const double error = mean - Cantilever::mean_pa(d, 0);
    CHECK(std::abs(error) < 0.02 * mean);
    if (before != 0)
      CHECK(error / before == doctest::Approx(4).epsilon(0.15)); // and third-order terms
    before = error;
  }
  CHECK(model.update(std::vector<double>{0, 0}).mean_pa ==
        approx(Cantilever::mean_pa(0, 0)).epsilon(1e-7));
}

TEST_CASE("about a new base the series starts there, and the initial range stays the table's") {
  StressModel model(test::shared(Cantilever::table()));
  FeedbackSettings settings;
  model.select(settings, {});
  const Feedback first = model.update(std::vector<double>{0, 0});
  model.rebase(std::make_shared<StressBase>(Cantilever::solve(0.004, -0.002)));
  const Feedback there = model.update(std::vector<double>{0.004, -0.002});
  CHECK(there.mean_pa == approx(Cantilever::mean_pa(0.004, -0.002)).epsilon(1e-7));
  CHECK(there.trust_ratio == 0);
  CHECK(there.min == first.min);
  CHECK(there.max == first.max);
  CHECK(model.update(std::vector<double>{0.003, -0.002}).trust_ratio == approx(0.5));
  CHECK(model.update(std::vector<double>{0.0042, -0.002}).mean_pa ==
        approx(Cantilever::mean_pa(0.0042, -0.002)).epsilon(5e-4));
  settings.mapping = Mapping::kWeighted;
  model.select(settings, 1);
  StressModel fresh(test::shared(Cantilever::table()));
  fresh.select(settings, 1);
  const Feedback a = model.update(std::vector<double>{0.004, -0.002});
  const Feedback b = fresh.update(std::vector<double>{0, 0});
  CHECK(a.min == b.min);
  CHECK(a.max == b.max);
}

TEST_CASE(
    "the trust ratio is the longest displacement of a control point, as a vector; one that is "
    "not finite counts as 0") {
  StressModel model(test::shared(test::four_elements()));
  CHECK(model.update(std::vector<double>{0.003, 0, -0.004}).trust_ratio == approx(0.5));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Feedback f = model.update(std::vector<double>{std::nan(""), kInfinity, 0});
  CHECK(f.raw.x == 25);
  CHECK(std::isfinite(f.gamma.x));
}

TEST_CASE("the kernels agree with plain sums for any size, and with each other to the bit") {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> number(-1, 1);
  for (const std::size_t count : {1U, 2U, 7U, 8U, 9U, 100U, 1023U, 1024U, 1025U, 5003U}) {
    CAPTURE(count);
    const auto floats = [&](std::size_t n) {
      std::vector<float> values(n);
      for (float& x : values)
        x = number(random);
      return values;
    };
    const auto stress = floats(count), weight = floats(count), rows = floats(9 * count);
    for (std::size_t terms = 0; terms <= 9; ++terms)
      for (const Mapping mapping : {Mapping::kMean, Mapping::kWeighted, Mapping::kAxis}) {
        std::vector<TaylorTerm> given;
        std::vector<double> s(stress.begin(), stress.end());
        for (std::size_t t = 0; t < terms; ++t) {
          given.push_back({rows.data() + t * count, 0.1 * static_cast<double>(t + 1)});
          for (std::size_t i = 0; i < count; ++i)
            s[i] += given[t].displacement_m * static_cast<double>(given[t].row[i]);
        }
        FeedbackTask task;
        task.stress = stress;
        task.terms = given;
        task.weight = terms % 2 ? weight.data() : nullptr;
        task.h = {rows.data(), nullptr, rows.data() + count};
        task.absolute = terms % 3 == 0;
        task.mapping = mapping;
        task.power = static_cast<unsigned>(terms + 1);
        task.scale_pa = 0.75;
        const auto h = [&task](std::size_t axis, std::size_t i) {
          const double value = task.h[axis] ? static_cast<double>(task.h[axis][i]) : 0.0;
          return task.absolute ? std::abs(value) : value;
        };
        const auto power = [&](std::size_t i) {
          return std::pow(std::max(s[i], 0.0) / task.scale_pa, task.power);
        };
        const auto product = [&](std::size_t axis, std::size_t i) {
          return s[i] *
                 (mapping == Mapping::kAxis ? h(axis, i) : (h(0, i) + h(1, i) + h(2, i)) / 3);
        };
        const FeedbackSums fast = feedback_kernel()->run(task),
                           base = feedback_kernel(tactus::simd::Baseline{})->run(task);
        // The rounding is that of sums of some unit numbers, powers of up to (4/3 max)^10.
        const auto check = [&](bool wanted, const Extremes& a, const Extremes& b, auto&& value_at) {
          CHECK(a.sum == b.sum);
          CHECK(a.min == b.min);
          CHECK(a.max == b.max);
          Extremes plain;
          for (std::size_t i = 0; i < count && wanted; ++i) {
            const double value = value_at(i);
            plain.sum += (task.weight ? static_cast<double>(weight[i]) : 1.0) * value;
            plain.min = std::min(plain.min, value);
            plain.max = std::max(plain.max, value);
          }
          const double unit = wanted ? std::max(1.0, plain.max) : 1.0;
          CHECK(std::abs(a.sum - plain.sum) <= 1e-13 * static_cast<double>(count) * unit);
          if (!wanted)
            return;
          CHECK(std::abs(a.min - plain.min) <= 1e-14 * unit);
          CHECK(std::abs(a.max - plain.max) <= 1e-14 * unit);
        };
        check(true, fast.stress, base.stress, [&](std::size_t i) { return s[i]; });
        check(mapping == Mapping::kMean && task.power > 1, fast.power, base.power, power);
        for (std::size_t a = 0; a < 3; ++a)
          check(mapping == Mapping::kAxis || (mapping == Mapping::kWeighted && a == 0),
                fast.product[a], base.product[a], [&](std::size_t i) { return product(a, i); });
      }
  }
}

TEST_CASE("feedback is interpolated over the time between two values; a fade keeps its time "
          "although targets that come meanwhile are closer together") {
  VectorRamp glide;
  glide.go({1, 0, 0}, 10);
  CHECK(glide.at(10.05).x == 1); // the first is due at once, after 50 ms at most
  glide.go({3, 0, 0}, 10.02 + 0.05);
  CHECK(glide.at(10.08).x == approx(1.4));
  CHECK(glide.at(10.12).x == approx(3));
  CHECK(glide.at(20).x == 3);
  glide.jump({1, 0, 0});
  glide.fade({0, 0, 0}, 25, 0.1);
  CHECK(glide.moving());
  CHECK(glide.at(25.05).x == approx(0.5));
  glide.go({0.1, 0, 0}, 25.05);
  CHECK(glide.at(25.051).x == approx(0.5 - 0.4 / 50).epsilon(1e-9));
  const double before = 0.5 - 0.4 / 5; // at 25.06
  glide.go({0.2, 0, 0}, 25.06);
  CHECK(glide.at(25.08).x == approx((before + 0.2) / 2).epsilon(1e-9));
  CHECK(glide.at(25.1).x == approx(0.2));
  CHECK(!glide.moving());
  VectorRamp unseen; // nobody asked for its value meanwhile
  unseen.fade({1, 0, 0}, 1, 0.1);
  unseen.go({0.5, 0, 0}, 1.05);
  CHECK(unseen.at(1.05).x == approx(0.5));
  glide.go({0.3, 0, 0}, 26);
  CHECK(glide.at(26.05).x == approx(0.3));
}

TEST_CASE("a power q turns the mean into the q-th root of the mean of s^q") {
  StressTable table = test::four_elements();
  table.weight = {3, 1, 2, 0.5F};
  for (const unsigned q : {2U, 3U, 7U, 12U, 30U, 31U, kMaxPower}) {
    CAPTURE(q);
    double plain = 0, weighted = 0; // of s/40
    for (std::size_t i = 0; i < 4; ++i) {
      const double power = std::pow(static_cast<double>(i + 1) / 4, q);
      plain += power / 4;
      weighted += static_cast<double>(table.weight[i]) * power / 6.5;
    }
    FeedbackSettings settings;
    settings.power = q;
    const Feedback f = feedback_of(table, settings);
    CHECK(f.raw.x == approx(40 * std::pow(plain, 1.0 / q)).epsilon(1e-13));
    CHECK(f.mean_pa == 25);
    settings.norm = Norm::kSum; // (sum s^q)^(1/q)
    CHECK(feedback_of(table, settings).raw.x ==
          approx(40 * std::pow(4 * plain, 1.0 / q)).epsilon(1e-13));
    settings.norm = Norm::kMean;
    settings.weights = Weights::kVolume;
    CHECK(feedback_of(table, settings).raw.x ==
          approx(40 * std::pow(weighted, 1.0 / q)).epsilon(1e-13));
    settings.mapping = Mapping::kWeighted; // the others have none
    settings.weights = Weights::kUniform;
    near(feedback_of(table, settings).raw.x, 15);
  }
}

TEST_CASE("a sum of powers stays finite, and stresses below 0 do not count") {
  StressTable table = test::four_elements();
  FeedbackSettings settings;
  settings.power = 2;
  table.base.von_mises.stress = {-30, 0, 0, 40};
  near(feedback_of(table, settings).raw.x, 20); // sqrt(40^2/4)
  settings.power = kMaxPower;
  table.base.von_mises.sensitivity.assign(12, 1e30F);
  const Feedback far = feedback_of(table, settings, 0, {1e6, 0, 0});
  CHECK(std::isfinite(far.raw.x));
  CHECK(far.gamma.x == 1);
  table.base.von_mises.stress.assign(4, 0);
  table.base.von_mises.sensitivity.assign(12, 0);
  CHECK(feedback_of(table, settings).raw.x == 0);
}
