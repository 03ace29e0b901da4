// What a body of a table, a material and a sample rate consists of: which modes ring, which only
// give way, how they decay and their loudness; and what a new model takes over.
#include "core/modal/body/body_model.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/tables.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;
using Complex = std::complex<double>;

namespace {

constexpr double kPi = std::numbers::pi;

ModalTable modes(const std::vector<double>& hz, const std::vector<double>& decay_per_s) {
  ModalTable table;
  table.free = false;
  table.frequency_hz = hz;
  table.decay_rate = decay_per_s;
  return table;
}

BodyModel make_model(ModalTable table, BodySettings settings = {}) {
  settings.radiation = Radiation::kNone;
  return BodyModel(std::make_shared<const LoadedTable>(std::move(table)), settings);
}

/// Displacement and velocity, mass-normalised, of a mode's state.
std::pair<double, double> motion(Complex z, Complex s) {
  const double q = z.imag() / s.imag();
  return {q, z.real() + s.real() * q};
}

} // namespace

TEST_CASE("modes below .45 of the sample rate ring, those below 60 kHz add compliance, others are "
          "left out") {
  for (const double rate : {44100., 48000., 96000.}) {
    BodySettings settings;
    settings.sample_rate = rate;
    const double limit = .45 * rate;
    const BodyModel m = make_model(
        modes({61000, 59900, 100, 1.001 * limit, .999 * limit, 700}, {1, 2, 3, 4, 5, 6}), settings);
    CHECK(m.audible_modes == 3);
    REQUIRE(m.mode.size() == 5);
    // Those that ring by their decay, then the others in order.
    CHECK(m.mode == std::vector<std::size_t>{2, 4, 5, 1, 3});
    for (std::size_t i = 0; i < m.mode.size(); ++i)
      CHECK(m.index_of[m.mode[i]] == i);
    CHECK(m.index_of[0] == 5); // left out
    CHECK(m.bank.state(2) == Complex(0));
    CHECK(m.solver.modes() == 5);
    settings.max_modes = 4; // of the table: the others only give way
    const BodyModel fewer = make_model(
        modes({61000, 59900, 100, 1.001 * limit, .999 * limit, 700}, {1, 2, 3, 4, 5, 6}), settings);
    CHECK(fewer.audible_modes == 1);
    CHECK(fewer.mode == std::vector<std::size_t>{2, 1, 3, 4, 5});
  }
}

TEST_CASE("a rate is the frequency with its decay, and just below what would be critical") {
  const BodyModel m = make_model(modes({100, 1000}, {300, 1e6}));
  const Complex slow = m.rate[m.index_of[0]], dead = m.rate[m.index_of[1]];
  CHECK(slow.real() == approx(-300));
  CHECK(std::abs(slow) == approx(2 * kPi * 100));
  CHECK(std::abs(dead) == approx(2 * kPi * 1000));
  CHECK(dead.real() == approx(-.999 * 2 * kPi * 1000));
}

TEST_CASE("a table's decay rates stand for loss factors: they follow the frequency") {
  BodySettings settings;
  settings.size = 2;
  const BodyModel m = make_model(modes({400}, {6}), settings);
  CHECK(std::abs(m.rate[0]) == approx(2 * kPi * 200));
  CHECK(m.rate[0].real() == approx(-3));
}

TEST_CASE("a material that a table does not give is aluminium, and changes are relative to it") {
  const auto hz = [](double modulus, double density, double table_modulus, double table_density) {
    ModalTable table = modes({1000}, {1});
    table.material.youngs_modulus_pa = table_modulus;
    table.material.density_kg_per_m3 = table_density;
    BodySettings settings;
    settings.youngs_modulus_pa = modulus;
    settings.density_kg_per_m3 = density;
    const BodyModel m = make_model(std::move(table), settings);
    return std::abs(m.rate[0]) / (2 * kPi);
  };
  CHECK(hz(0, 0, 0, 0) == approx(1000));
  CHECK(hz(4 * 70e9, 0, 0, 0) == approx(2000));
  CHECK(hz(0, 4 * 2700, 0, 0) == approx(500));
  CHECK(hz(0, 0, 200e9, 7800) == approx(1000));
  CHECK(hz(50e9, 0, 200e9, 7800) == approx(500));
  CHECK(hz(0, 31200, 200e9, 7800) == approx(500));
}

TEST_CASE("loudness is the A-weighting of IEC 61672-1 times the weight at the loudest listener") {
  // dB at nominal frequencies, class 1, table 3.
  const std::vector<std::pair<double, double>> table{
      {31.62, -39.4}, {63.1, -26.2}, {125.9, -16.1}, {251.2, -8.6}, {501.2, -3.2},
      {1000, 0},      {1995, 1.2},   {3981, 1.0},    {7943, -1.1},  {15849, -6.6}};
  std::vector<double> hz;
  for (const auto& [f, db] : table)
    hz.push_back(f);
  const BodyModel m = make_model(modes(hz, std::vector<double>(hz.size(), 1e-3)));
  REQUIRE(m.audible_modes == hz.size());
  for (std::size_t k = 0; k < hz.size(); ++k) {
    CAPTURE(hz[k]);
    const std::size_t i = m.index_of[k];
    CHECK(std::abs(20 * std::log10(m.a_weight[i]) - table[k].second) < .11);
    const double loudest = std::max(std::abs(m.weight[0][i]), std::abs(m.weight[1][i]));
    CHECK(m.loudest_weight(i) == approx(loudest));
    CHECK(m.loudness[i] == approx(m.a_weight[i] * loudest));
  }
}

TEST_CASE("a pulse's gain x/sin x compensates the mean over a sample, up to the highest mode") {
  const BodyModel m = make_model(modes({100, 3000, 12000, 21000}, {1, 1, 1, 1}));
  for (std::size_t i = 0; i < m.audible_modes; ++i) {
    const double x = .5 * m.rate[i].imag() / 48000;
    CAPTURE(x);
    CHECK(m.pulse_gain[i] == approx(x / std::sin(x)).epsilon(x < .5 ? 1e-4 : .02));
  }
}

TEST_CASE("bands of four an octave begin where they say, and hold what lies in them") {
  for (std::size_t band = 0; band + 1 < kPulseBands; ++band) {
    const double begin = pulse_band_begin(band), next = pulse_band_begin(band + 1);
    CHECK(pulse_band(begin) == band);
    CHECK(pulse_band(.5 * (begin + next)) == band);
    CHECK(pulse_band(std::nextafter(next, 0)) == band);
    if (band % 4 == 0)
      CHECK(begin == std::exp2(static_cast<double>(band / 4)));
    CHECK(next / begin < 1.26);
  }
  CHECK(pulse_band(.1) == 0);
  CHECK(pulse_band(-5) == 0);
  CHECK(pulse_band(1e300) == kPulseBands - 1);
}

TEST_CASE("a new model continues every mode's displacement and velocity, in bank and contact") {
  for (const bool contacting : {false, true}) {
    CAPTURE(contacting);
    const auto table =
        std::make_shared<const LoadedTable>(modes({300, 900, 40000, 2000}, {40, 90, 3, 10}));
    BodySettings settings;
    settings.radiation = Radiation::kNone;
    BodyModel before(table, settings);
    settings.size = 1.7;
    settings.damping = Damping::kLoss;
    settings.loss_factor = .05;
    settings.density_kg_per_m3 = 5000;
    BodyModel after(table, settings);
    CHECK(after.mode != before.mode); // another order
    const std::vector<Complex> z{{.1, .2}, {-.3, .1}, {.2, -.4}, {.05, .3}};
    if (contacting) {
      before.solver.write_states(z);
      after.continue_in_contact(before);
    } else {
      before.bank.write_states(std::span(z).first(before.audible_modes));
      after.continue_from(before);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = before.index_of[k], j = after.index_of[k];
      if (!contacting && (i >= before.audible_modes || j >= after.audible_modes))
        continue;
      CAPTURE(k);
      const auto [q, v] =
          motion(contacting ? before.solver.state(i) : before.bank.state(i), before.rate[i]);
      const auto [p, w] =
          motion(contacting ? after.solver.state(j) : after.bank.state(j), after.rate[j]);
      CHECK(p == approx(q).epsilon(1e-5));
      CHECK(w == approx(v).epsilon(1e-4));
    }
  }
}

TEST_CASE("gains are the shape against the direction, between the corners of a triangle") {
  ModalTable table = plate(.3, .2, .005, 3000, 4, 4);
  table.material.density_kg_per_m3 = 2700;
  std::mt19937 random(1);
  for (float& x : table.shape)
    x = static_cast<float>(random() % 2000) / 1000.F - 1;
  const ModalTable copy = table;
  BodySettings settings;
  settings.size = 2;
  settings.density_kg_per_m3 = 8100;
  const BodyModel m = make_model(std::move(table), settings);
  CHECK(m.shape_scale == approx(1 / std::sqrt(3 * 8.)));
  CHECK(m.mass_kg == approx(copy.mass_kg * 24));
  const SurfacePoint at = m.loaded->surface.on(7, .2, .5);
  const Vec3 direction{.48, -.6, .64};
  std::vector<double> gain(m.mode.size());
  m.gains(at, direction, gain);
  for (std::size_t i = 0; i < gain.size(); ++i) {
    Vec3 shape{};
    for (std::size_t c = 0; c < 3; ++c)
      shape +=
          at.weight[c] * copy.shape_at(m.mode[i], static_cast<std::size_t>(copy.triangle[7][c]));
    CHECK(std::abs(gain[i] + m.shape_scale * dot(shape, direction)) < 1e-6);
  }
  // Fewer are asked for: no more are written. Without shapes every mode has the same.
  std::vector<double> two(m.mode.size(), 77);
  m.gains(at, direction, std::span(two).first(2));
  CHECK(two[1] == gain[1]);
  CHECK(two[2] == 77);
  const BodyModel plain = make_model(modes({100, 200}, {1, 1}), settings);
  plain.gains({}, direction, std::span(two).first(2));
  CHECK(two[0] == approx(plain.shape_scale));
  CHECK(two[1] == approx(plain.shape_scale));
}
