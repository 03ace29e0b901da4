// What a body of a table, a material, a size and a sample rate consists of: which modes ring, which
// only give way, how they decay, recoil and sound, by the laws of elasticity; and what a new model
// takes over.
#include "core/haptic/scene/pose.hpp"
#include "core/modal/body/body_model.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::cross;
using tactus::dot;
using tactus::Vec3;

namespace {

BodyModel make_model(ModalTable table, BodySettings settings = no_radiation()) {
  return BodyModel(std::make_shared<const LoadedTable>(std::move(table)), settings);
}

ModalTable modes(const std::vector<double>& hz, const std::vector<double>& decay_per_s) {
  ModalTable table = mode_table(hz);
  table.decay_rate = decay_per_s;
  return table;
}

Complex rate(const BodyModel& model, std::size_t mode) { return model.rate[model.index_of[mode]]; }

/// The closed form's plate, let go: with inertia that is no cube's, slopes, radiation and what lies
/// beyond.
ModalTable plate_with_all() {
  ModalTable table = free_plate(.32, .2, .005, 3000, 16, 10);
  table.centre_of_mass_m = {.01, -.02, 0};
  table.inertia_kg_m2 = {Vec3{4e-3, 5e-4, -2e-4}, Vec3{5e-4, 9e-3, 3e-4},
                         Vec3{-2e-4, 3e-4, 1.2e-2}};
  for (const Vec3& v : table.vertex_m) // straight over the surface: exact between vertices
    table.residual_compliance.push_back(static_cast<float>(1e-8 * (2 + 3 * v.x)));
  for (std::size_t k = 0; k < table.modes(); ++k) {
    table.radiation_decay_rate.push_back(2 + static_cast<double>(k));
    table.poisson_slope.push_back(.1 + .01 * static_cast<double>(k));
  }
  return table;
}

struct Body {
  std::shared_ptr<const LoadedTable> loaded = std::make_shared<const LoadedTable>(plate_with_all());
  BodySettings settings = no_radiation();
  [[nodiscard]] BodyModel model() const { return BodyModel(loaded, settings); }
};

/// 1/m + (r x n) I^-1 (r x n), Cramer's rule.
double mobility(double mass, const std::array<Vec3, 3>& inertia, const Vec3& arm, const Vec3& n) {
  const Vec3 turn = cross(arm, n);
  const auto det = [](const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)); };
  const Vec3 &a = inertia[0], &b = inertia[1], &c = inertia[2]; // symmetric: rows are columns
  const double whole = det(a, b, c);
  const Vec3 w{det(turn, b, c) / whole, det(a, turn, c) / whole, det(a, b, turn) / whole};
  return 1 / mass + dot(turn, w);
}

} // namespace

TEST_CASE("modes below .45 of the sample rate ring, those below 60 kHz add compliance, others are "
          "left out") {
  for (const double rate : {44100., 48000., 96000.}) {
    BodySettings settings = no_radiation();
    settings.sample_rate = rate;
    const double limit = .45 * rate;
    const ModalTable table =
        modes({61000, 59900, 100, 1.001 * limit, .999 * limit, 700}, {1, 2, 3, 4, 5, 6});
    const BodyModel m = make_model(table, settings);
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
    const BodyModel fewer = make_model(table, settings);
    CHECK(fewer.audible_modes == 1);
    CHECK(fewer.mode == std::vector<std::size_t>{2, 1, 3, 4, 5});
  }
}

TEST_CASE("a limit of modes that would part a pair of equal frequencies keeps both") {
  BodySettings settings = no_radiation();
  settings.max_modes = 2;
  CHECK(make_model(modes({300, 500, 500.2, 900}, {1, 1, 1, 1}), settings).audible_modes == 3);
  CHECK(make_model(modes({300, 500, 500.2, 500.4}, {1, 1, 1, 1}), settings).audible_modes == 4);
  CHECK(make_model(modes({300, 500, 501, 900}, {1, 1, 1, 1}), settings).audible_modes == 2);
}

TEST_CASE("a rate is the frequency with its decay, which follows the frequency to near critical") {
  BodySettings settings = no_radiation();
  for (const double size : {1., 2.}) {
    settings.size = size;
    const BodyModel m = make_model(modes({100, 1000}, {300, 1e6}), settings);
    CHECK(rate(m, 0).real() == approx(-300 / size));
    CHECK(abs(rate(m, 0)) == approx(2 * kPi * 100 / size));
    CHECK(abs(rate(m, 1)) == approx(2 * kPi * 1000 / size));
    CHECK(rate(m, 1).real() == approx(-.999 * 2 * kPi * 1000 / size));
  }
}

TEST_CASE("frequencies follow modulus, density, size and Poisson's ratio from the table's, or "
          "from aluminium") {
  struct Case {
    double table_modulus, table_density; // 0: not given
    double modulus, density, size, poisson, ratio;
  };
  const double e = 70.3e9;
  for (const Case& c : {Case{0, 0, 0, 0, 1, 0, 1},
                        {0, 0, 4 * 70e9, 0, 1, 0, 2},
                        {0, 0, 0, 4 * 2700, 1, 0, .5},
                        {200e9, 7800, 0, 0, 1, 0, 1},
                        {200e9, 7800, 50e9, 0, 1, 0, .5},
                        {200e9, 7800, 0, 31200, 1, 0, .5},
                        {e, 2700, 9 * e, 0, 1, 0, 3},
                        {e, 2700, 9 * e, 10800, 3, 0, .5},
                        {e, 2700, 0, 0, 1, .33, 1},
                        {e, 2700, 0, 0, 1, .33 + .05, std::exp(.05 * .13)}}) {
    CAPTURE(c.ratio);
    ModalTable table = plate_with_all();
    table.material.youngs_modulus_pa = c.table_modulus;
    table.material.density_kg_per_m3 = c.table_density;
    const double own = 2 * kPi * table.frequency_hz[3];
    BodySettings settings = no_radiation();
    settings.youngs_modulus_pa = c.modulus;
    settings.density_kg_per_m3 = c.density;
    settings.size = c.size;
    if (c.poisson > 0)
      settings.poisson = c.poisson;
    CHECK(rate(make_model(std::move(table), settings), 3).imag() ==
          approx(c.ratio * own).epsilon(1e-5));
  }
}

TEST_CASE("a free body's recoil is that of its mass and inertia, in any size and density") {
  Body body;
  const ModalTable table = plate_with_all();
  for (const double size : {1., 2., .5})
    for (const double density : {2700., 7800.}) {
      CAPTURE(size);
      CAPTURE(density);
      body.settings.size = size;
      body.settings.density_kg_per_m3 = density;
      const BodyModel model = body.model();
      const double heavier = density / 2700;
      CHECK(model.mass_kg == approx(table.mass_kg * heavier * std::pow(size, 3)));
      std::array<Vec3, 3> inertia = table.inertia_kg_m2;
      for (Vec3& row : inertia)
        row = row * (heavier * std::pow(size, 5));
      for (const Vec3& point :
           {Vec3{.1, .07, .0025}, Vec3{-.13, .02, .0025}, Vec3{0, -.09, .0025}}) {
        const SurfacePoint at = model.nearest(size * point);
        const Vec3 arm = size * (point - table.centre_of_mass_m);
        for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{.6, 0, .8}, Vec3{.48, -.6, .64}}) {
          double square = 0;
          for (const double b : model.rigid_gains(at, n))
            square += b * b;
          CHECK(square == approx(mobility(model.mass_kg, inertia, arm, n)).epsilon(1e-6));
        }
      }
    }
}

TEST_CASE("residual compliance scales as 1 over modulus and size") {
  Body body;
  const auto compliance = [&](double size, double modulus) {
    body.settings.size = size;
    body.settings.youngs_modulus_pa = modulus;
    const BodyModel model = body.model();
    return model.residual_compliance(model.nearest(size * Vec3{.05, .03, .0025}));
  };
  const double own = compliance(1, 0);
  CHECK(own == approx(1e-8 * (2 + 3 * .05)).epsilon(1e-5));
  CHECK(compliance(2, 0) == approx(own / 2).epsilon(1e-6));
  CHECK(compliance(1, 2 * 70.3e9) == approx(own / 2).epsilon(1e-6));
  CHECK(compliance(3, 70.3e9 / 3) == approx(own).epsilon(1e-6));
}

TEST_CASE("decay is the material's, the radiation's and the choke's together") {
  Body body;
  BodySettings& s = body.settings;
  const ModalTable table = plate_with_all();
  const std::size_t k = 4;
  const double omega = 2 * kPi * table.frequency_hz[k], air = table.radiation_decay_rate[k];
  const auto decay = [&] { return -rate(body.model(), k).real(); };
  const double own = decay() - air; // of the table
  CHECK(own > 0);
  s.choke_t60_s = .5;
  CHECK(decay() == approx(own + air + std::log(1000.) / .5));
  s.choke_t60_s = 0;
  s.damping = Damping::kLoss;
  s.loss_factor = .004;
  CHECK(decay() == approx(.5 * omega * .004 + air));
  s.damping = Damping::kRayleigh;
  s.rayleigh_a_per_s = 3;
  s.rayleigh_b_s = 2e-7;
  CHECK(decay() == approx(.5 * (3 + 2e-7 * omega * omega) + air));
  s.damping = Damping::kCurve;
  const double f = table.frequency_hz[k];
  s.loss_curve = {{f / 2, .001}, {2 * f, .003}}; // logarithms on a straight line: their mean at f
  CHECK(decay() == approx(.5 * omega * std::sqrt(.001 * .003) + air).epsilon(1e-6));
  s.loss_curve = {{2 * f, .003}, {4 * f, .001}}; // level before the first and after the last
  CHECK(decay() == approx(.5 * omega * .003 + air).epsilon(1e-6));
  s.loss_curve = {{f / 4, .003}, {f / 2, .001}};
  CHECK(decay() == approx(.5 * omega * .001 + air).epsilon(1e-6));
  // Radiation: rho_air c area/mass at the same shape: as 1/(rho L); the rest is as without it.
  s.damping = Damping::kLoss;
  s.size = 2;
  CHECK(decay() == approx(.5 * omega / 2 * .004 + air / 2));
  s.density_kg_per_m3 = 3 * 2700;
  CHECK(decay() == approx(.5 * omega / 2 / std::sqrt(3.) * .004 + air / 6));
}

TEST_CASE("loudness is the A-weighting of IEC 61672-1 times the weight at the loudest listener") {
  // dB at nominal frequencies, class 1, table 3.
  const std::vector<std::pair<double, double>> table{
      {31.62, -39.4}, {63.1, -26.2}, {125.9, -16.1}, {251.2, -8.6}, {501.2, -3.2},
      {1000, 0},      {1995, 1.2},   {3981, 1.0},    {7943, -1.1},  {15849, -6.6}};
  std::vector<double> hz;
  for (const auto& [f, db] : table)
    hz.push_back(f);
  const BodyModel m = make_model(mode_table(hz, 1e-3));
  REQUIRE(m.audible_modes == hz.size());
  for (std::size_t k = 0; k < hz.size(); ++k) {
    CAPTURE(hz[k]);
    const std::size_t i = m.index_of[k];
    CHECK(std::abs(20 * std::log10(m.a_weight[i]) - table[k].second) < .11);
    const double loudest = std::max(abs(m.weight[0][i]), abs(m.weight[1][i]));
    CHECK(m.loudest_weight(i) == approx(loudest));
    CHECK(m.loudness[i] == approx(m.a_weight[i] * loudest));
  }
}

TEST_CASE("a pulse's gain x/sin x compensates the mean over a sample, up to the highest mode") {
  const BodyModel m = make_model(mode_table({100, 3000, 12000, 21000}, 1));
  for (std::size_t i = 0; i < m.audible_modes; ++i) {
    const double x = .5 * m.rate[i].imag() / kRate;
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

TEST_CASE("a new model continues every mode's state, and so its energy, in bank and contact") {
  for (const bool contacting : {false, true}) {
    CAPTURE(contacting);
    const auto table =
        std::make_shared<const LoadedTable>(modes({300, 900, 40000, 2000}, {40, 90, 3, 10}));
    BodySettings settings = no_radiation();
    BodyModel before(table, settings);
    settings.size = 1.7;
    settings.damping = Damping::kLoss;
    settings.loss_factor = .05;
    settings.density_kg_per_m3 = 5000;
    BodyModel after(table, settings);
    CHECK(after.mode != before.mode); // another order
    const std::vector<Complex> z{{.1, .2}, {-.3, .1}, {.2, -.4}, {.05, .3}};
    if (contacting) {
      before.in_solver = true;
      before.solver.write_states(z);
    } else {
      before.bank.write_states(std::span(z).first(before.audible_modes));
    }
    after.continue_from(before);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = before.index_of[k], j = after.index_of[k];
      if (!contacting && (i >= before.audible_modes || j >= after.audible_modes))
        continue;
      CAPTURE(k);
      const Complex was = contacting ? before.solver.state(i) : before.bank.state(i);
      const Complex is = contacting ? after.solver.state(j) : after.bank.state(j);
      CHECK(abs(is - was) < 1e-5 * abs(was));
    }
  }
}

TEST_CASE("gains are the shape against the direction, between the corners of a triangle") {
  ModalTable table = plate(.3, .2, .005, 3000, 4, 4);
  std::mt19937 random(1);
  for (float& x : table.shape)
    x = static_cast<float>(random() % 2000) / 1000.F - 1;
  const ModalTable copy = table;
  BodySettings settings = no_radiation();
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
  const BodyModel plain = make_model(mode_table({100, 200}), settings);
  plain.gains({}, direction, std::span(two).first(2));
  CHECK(two[0] == approx(plain.shape_scale));
  CHECK(two[1] == approx(plain.shape_scale));
}
