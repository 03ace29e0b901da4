#include "core/modal/radiation/direct_sound.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kPi = std::numbers::pi;

/// Every mode arrives after its own delay, from so many places.
class ScatteredArrivals final : public Arrivals {
public:
  ScatteredArrivals(std::size_t modes, std::size_t samples) : modes_(modes), samples_(samples) {}
  std::size_t modes() const noexcept override { return modes_; }
  std::size_t samples() const noexcept override { return samples_; }
  void find(std::size_t motion, std::span<double> pressure) const override {
    const BandLimit& band = BandLimit::at_rate(48000);
    const double delay =
        static_cast<double>(motion * 37 % 101) / 101 * static_cast<double>(samples_ - 52);
    for (std::size_t n = 0; n < samples_; ++n)
      for (std::size_t m = 0; m < BandLimit::kNodes; ++m)
        pressure[n * BandLimit::kNodes + m] =
            band.kernel(static_cast<double>(n) + BandLimit::kNode[m] - delay - BandLimit::kLatency);
  }

private:
  std::size_t modes_, samples_;
};

std::vector<DirectKernels::Mode> ringing(std::size_t count) {
  std::vector<DirectKernels::Mode> modes;
  for (std::size_t k = 0; k < count; ++k)
    modes.push_back(
        {{-3.0 - static_cast<double>(k % 7) * 500,
          2 * kPi * (100 + 19000.0 * static_cast<double>(k) / static_cast<double>(count))},
         count - 1 - k, // the table has them in another order
         k % 11 == 5 ? DirectKernels::Mode::Part::kInaudible : DirectKernels::Mode::Part::kRinging,
         1 + 0.1 * static_cast<double>(k % 3)});
  return modes;
}

ModalTable many_modes(std::size_t count) {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  table.mass_kg = 1;
  for (std::size_t k = 0; k < count; ++k) {
    table.frequency_hz.push_back(50 +
                                 20000.0 * static_cast<double>(k) / static_cast<double>(count));
    table.decay_rate.push_back(5);
  }
  return table;
}

} // namespace

TEST_CASE("kernels summed beforehand equal those summed when a force begins") {
  // Single precision in another order: 1e-5 of the loudest sample.
  constexpr std::size_t kModes = 400, kVertices = 5;
  std::vector<float> shape(kVertices * kModes * 3);
  for (std::size_t i = 0; i < shape.size(); ++i)
    shape[i] = static_cast<float>(std::sin(static_cast<double>(i * i % 9973)));
  const ScatteredArrivals arrivals(kModes, 120);
  const auto modes = ringing(kModes);
  for (const VectorSet set : {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512}) {
    if (!bank_kernel(set))
      continue;
    DirectKernels plain, summed;
    plain.build(arrivals, modes, false, 48000);
    summed.build(arrivals, modes, false, 48000, {shape, kModes, bank_kernel(set)});
    REQUIRE(!plain.on_surface());
    REQUIRE(summed.on_surface());
    CHECK(summed.weight() == plain.weight());
    REQUIRE(summed.taps() >= plain.taps());
    const DirectKernels::SurfaceGain at{{{1, {0.3, -2, 0.7}}, {4, {1, 0, -1}}, {2, {0, 0, 0.2}}}};
    std::vector<double> gain(kModes), pulse(kModes);
    for (std::size_t k = 0; k < kModes; ++k) {
      for (const auto& [vertex, share] : at)
        for (int axis = 0; axis < 3; ++axis)
          gain[k] +=
              share[axis] *
              static_cast<double>(
                  shape[(vertex * kModes + modes[k].motion) * 3 + static_cast<std::size_t>(axis)]);
      pulse[k] = gain[k] * modes[k].pulse_gain;
    }
    const auto compare = [&](std::size_t rows, const std::vector<float>& one,
                             const std::vector<float>& two) {
      float loudest = 0, difference = 0;
      for (std::size_t j = 0; j < rows; ++j)
        for (std::size_t n = 0; n < plain.taps(); ++n) {
          loudest = std::max(loudest, std::abs(one[j * plain.taps() + n]));
          difference = std::max(difference,
                                std::abs(one[j * plain.taps() + n] - two[j * summed.taps() + n]));
        }
      CHECK(loudest > 0);
      CHECK(difference < 1e-5F * loudest);
    };
    std::vector<float> one(plain.taps()), two(summed.taps());
    plain.assemble_samples(gain, one);
    summed.assemble_samples(at, two);
    compare(1, one, two);
    plain.assemble_samples(pulse, one);
    summed.assemble_pulse(at, two);
    compare(1, one, two);
    REQUIRE(summed.moments() == plain.moments());
    one.resize(plain.moments() * plain.taps());
    two.resize(summed.moments() * summed.taps());
    plain.assemble_moments(gain, one);
    summed.assemble_moments(at, two);
    compare(plain.moments(), one, two);
  }
}

TEST_CASE("kernels of large bodies keep to their memory") {
  for (const std::size_t modes : {1UL, 400UL, 20000UL, 1000000UL})
    for (const std::size_t vertices : {0UL, 3UL, 9000UL, 2000000UL}) {
      const std::size_t spread = DirectKernels::max_spread(modes, vertices);
      CHECK(spread <= Arrivals::kMaxSpread);
      CHECK(spread >= 64);
      const std::size_t rows = vertices > 0 ? std::min(modes, 3 * vertices) : modes;
      if (rows <= 100000)
        CHECK(2 * rows * (spread + BandLimit::kLength) <= DirectKernels::kMaxNumbers);
    }
  CHECK(DirectKernels::max_spread(400, 9000) == Arrivals::kMaxSpread);
}

TEST_CASE(
    "a crowd of strikes on a large body begins block by block, on a small one at its sample") {
  struct Case {
    std::size_t modes;
    std::int64_t apart; // samples from one beginning to the next, at most
  };
  for (const Case& one : {Case{200, 0}, Case{20000, 64}}) {
    const std::size_t modes = one.modes;
    const std::int64_t apart = one.apart;
    CAPTURE(modes);
    Rig rig(48000, many_modes(modes));
    rig.settings.listeners = 2;
    rig.settings.voices = 16;
    rig.options.coupled = false;
    rig.rebuild(false);
    static_cast<void>(rig.run(64));
    Striker soft;
    soft.stiffness = 1e3;
    rig.body.set_striker(soft);
    const std::int64_t when = rig.body.clock() + 77;
    for (int i = 0; i < 8; ++i)
      rig.body.schedule_hit({{}, {0, 0, 1}, 1}, when);
    std::size_t before = 0;
    std::int64_t last = when;
    for (int n = 0; n < 700; ++n) { // sample by sample
      static_cast<void>(rig.run(1, 1));
      const std::size_t now = rig.body.contacts();
      if (now > before) {
        const std::int64_t start_sample = rig.body.clock() - 1;
        CHECK(start_sample >= when);
        CHECK(start_sample - last <= (before == 0 ? 0 : apart));
        last = start_sample;
      }
      before = std::max(before, now);
    }
    CHECK(before == 8);
    CHECK(last >= when + 6 * apart);
    CHECK(last <= when + 7 * apart);
  }
}

namespace {

/// A plate of more modes than take each new point at once: its own again, a little higher.
ModalTable many_modes() {
  ModalTable table = plate(0.32, 0.2, 0.005, 20000, 4, 4);
  const std::size_t own = table.modes(), each = table.vertices() * 3;
  while (table.modes() <= StruckBody::kMaxUnthrottledModes) {
    const std::size_t k = table.modes() - own;
    table.frequency_hz.push_back(table.frequency_hz.back() + 0.1);
    table.loss_factor.push_back(1e-3);
    const std::vector<float> shape(table.shape.begin() + static_cast<std::ptrdiff_t>(k * each),
                                   table.shape.begin() +
                                       static_cast<std::ptrdiff_t>((k + 1) * each));
    table.shape.insert(table.shape.end(), shape.begin(), shape.end());
  }
  return table;
}

} // namespace

TEST_CASE("of force points faster than a large body's rate limit the newest counts") {
  Rig rig(48000, many_modes());
  static_cast<void>(rig.run(64));
  const std::int64_t begin = rig.body.clock();
  const auto gain_at = [&](double x) {
    const SurfacePoint point = rig.body.model()->nearest({x, 0.01, 0});
    std::vector<double> gain(rig.body.model()->mode.size());
    rig.body.model()->gains(point, point.normal, gain);
    return static_cast<float>(gain[0]);
  };
  for (int i = 0; i < 200; ++i) { // every 4 samples
    const SurfacePoint point = rig.body.model()->nearest({0.0005 * i, 0.01, 0});
    rig.body.schedule_point(point, point.normal, begin + 4 * i);
  }
  int changes = 0;
  float before = rig.body.model()->force_gain[0];
  for (int n = 0; n < 900; ++n) {
    static_cast<void>(rig.run(1, 1));
    const float now = rig.body.model()->force_gain[0];
    changes += now != before ? 1 : 0;
    before = now;
  }
  CHECK(changes >= 800 / 64);
  CHECK(changes <= 900 / 64 + 1);
  CHECK(before == gain_at(0.0005 * 199));
}

TEST_CASE("of friction points faster than a large body's rate limit the newest counts") {
  Rig rig(48000, many_modes());
  const std::int64_t begin = rig.body.clock();
  Rub rub;
  rub.placed = true;
  for (int i = 0; i < 200; ++i) { // every 4 samples
    rub.point = rig.body.model()->nearest({0.0005 * i, 0.01, 0});
    rub.law.dynamic_coefficient = 0.3 + 0.001 * i;
    rig.body.schedule_rub(rub, begin + 4 * i);
  }
  const auto& contact = rig.body.model()->solver.contact(rig.settings.voices + 1);
  int changes = 0;
  double before = 0;
  for (int n = 0; n < 900; ++n) {
    const std::array<float, 1> none{}, normal{1}, velocity{0.1F};
    std::array<float, 1> left{}, force{}, friction{};
    const std::array<std::span<float>, 1> out{left};
    rig.body.process<float>(none, none, out, force, {normal, velocity, friction});
    const double now = contact.exciter.friction.law().dynamic_coefficient;
    changes += now != before ? 1 : 0;
    before = now;
  }
  CHECK(contact.active);
  CHECK(changes >= 800 / 64);
  CHECK(changes <= 900 / 64 + 2);
  CHECK(before == approx(0.3 + 0.001 * 199));
}
