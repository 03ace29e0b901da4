// What a listener receives of multipoles: harmonics and waves beside the standard library's special
// functions, and the sound beside the exact field of a vibrating sphere: known at one frequency or
// in a band, from any side, in any size, air and sample rate.
#include "core/modal/radiation/multipole.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

std::complex<float> narrowed(Complex z) {
  return {static_cast<float>(z.real()), static_cast<float>(z.imag())};
}

constexpr double kRadius = .04, kAir = 1.184, kSound = 346.1;

/// Pressure at r for an acceleration P_l(cos theta) of a sphere of radius a, per P_l, its travel
/// from the sphere taken out: -rho h_l(k r)/(k h_l'(k a)) e^(j k (r - a)), outgoing waves.
Complex sphere(unsigned l, double a, double r, double omega, double air, double sound) {
  const double k = omega / sound;
  const auto hankel = [](unsigned degree, double x) {
    return Complex(std::sph_bessel(degree, x), -std::sph_neumann(degree, x));
  };
  const double x = k * a;
  const Complex slope = l == 0 ? -hankel(1, x) : hankel(l - 1, x) - (l + 1.) / x * hankel(l, x);
  return -air * hankel(l, k * r) / (k * slope) * tactus::math::polar(1., k * (r - a));
}

/// The sphere's velocity over that of its mode: it lags, causally, the more the faster.
Complex lag(double x) { return 1. / Complex(1, .4 * x); }

/// One mode of degree l, known at its own frequency or in a band; P_l about the z axis.
ModalTable make_table(unsigned l, double mode_hz, bool band = false) {
  ModalTable table;
  table.frequency_hz = {mode_hz};
  MultipoleTable& m = table.multipoles;
  m.centre = {.01, -.02, .03};
  m.highest_degree = {static_cast<std::int32_t>(l)};
  m.offset = {0, static_cast<std::int64_t>((l + 1) * (l + 1))};
  m.scales = {1};
  m.reference_radius_m = kRadius;
  const double harmonic = std::sqrt((2. * l + 1) / (4 * kPi)); // Y_l0 = this P_l
  const auto coefficient = [&](double hz) {
    const double omega = 2 * kPi * hz;
    return narrowed(Complex(0, omega) * sphere(l, kRadius, kRadius, omega, kAir, kSound) /
                    harmonic * (band ? lag(omega * kRadius / kSound) : 1.));
  };
  const std::size_t count = (l + 1) * (l + 1), at = l * l + l;
  m.coefficients.assign(count, 0);
  m.coefficients[at] = coefficient(mode_hz);
  if (!band)
    return table;
  for (double hz = 120; hz < 22000; hz *= 1.12)
    m.band.frequency_hz.push_back(hz);
  m.band.highest_degree = m.highest_degree;
  m.band.offset = m.offset;
  m.band.coefficients.assign(count * m.band.frequency_hz.size(), 0);
  for (std::size_t i = 0; i < m.band.frequency_hz.size(); ++i)
    m.band.coefficients[i * count + at] = coefficient(m.band.frequency_hz[i]);
  return table;
}

} // namespace

TEST_CASE("a table's harmonics are the orthonormal ones with Condon and Shortley's phase") {
  constexpr std::int32_t kHighest = 6;
  ModalTable table;
  MultipoleTable& m = table.multipoles;
  table.frequency_hz = {1000};
  m.highest_degree = {kHighest};
  m.offset = {0, (kHighest + 1) * (kHighest + 1)};
  m.scales = {1};
  m.band.frequency_hz = {100, 200, 300, 400};
  m.band.highest_degree = {kHighest};
  m.band.offset = m.offset;
  const std::size_t count = static_cast<std::size_t>(m.offset[1]);
  for (const double polar : {.1, .9, 1.7, 3.})
    for (const double azimuth : {0., .7, -2.1}) {
      const Vec3 direction{3 * std::sin(polar) * std::cos(azimuth),
                           3 * std::sin(polar) * std::sin(azimuth), 3 * std::cos(polar)};
      for (std::int32_t l = 0; l <= kHighest; ++l)
        for (std::int32_t order = -l; order <= l; ++order) {
          m.coefficients.assign(count, 0);
          const auto at = static_cast<std::size_t>(l * l + l + order);
          m.coefficients[at] = {2, 1};
          m.band.coefficients.assign(4 * count, 0);
          m.band.coefficients[2 * count + at] = {0, -1};
          const MultipoleDirection seen(table, direction);
          const auto size = static_cast<unsigned>(std::abs(order));
          // std::sph_legendre has the phase (-1)^m, of m >= 0; Y_l,-m = (-1)^m conj(Y_lm).
          const double sign = order < 0 && size % 2 ? -1 : 1;
          const Complex harmonic = sign * std::sph_legendre(static_cast<unsigned>(l), size, polar) *
                                   tactus::math::polar(1., order * azimuth);
          const auto sums = seen.sums(0, 1), band = seen.band_sums(0, 2);
          CAPTURE(l);
          CAPTURE(order);
          for (std::int32_t other = 0; other <= kHighest; ++other) {
            const Complex expected = other == l ? harmonic : 0.;
            const auto i = static_cast<std::size_t>(other);
            CHECK(abs(sums[i] - Complex(2, 1) * expected) < 1e-10);
            CHECK(abs(band[i] - Complex(0, -1) * expected) < 1e-10);
          }
          CHECK(seen.band_sums(0, 1)[static_cast<std::size_t>(l)] == 0.);
        }
    }
}

TEST_CASE(
    "between a table's ratios of frequency its coefficients are interpolated, and held beyond") {
  ModalTable table;
  MultipoleTable& m = table.multipoles;
  m.highest_degree = {0, 0};
  m.offset = {0, 1, 2};
  m.scales = {.5, 1, 2};
  m.coefficients = {0, 10, 0, 20, 0, 50}; // of the second mode
  const MultipoleDirection seen(table, {0, 0, 1});
  const double whole = std::sqrt(4 * kPi);
  const auto at = [&](double ratio) { return (seen.sums(1, ratio)[0] * whole).real(); };
  for (const auto& [ratio, value] :
       {std::pair{.1, 10.}, {.5, 10.}, {.75, 15.}, {1., 20.}, {1.5, 35.}, {2., 50.}, {9., 50.}})
    CHECK(at(ratio) == approx(value));
  CHECK(seen.sums(0, 1)[0] == 0.);
}

TEST_CASE("multipoles in any size, air and direction sound as the sphere does") {
  struct Case {
    double size, shape_scale, air, sound, rate, polar, distance;
    bool band;
  };
  for (const Case& c :
       {Case{1, 1, kAir, kSound, 48000, 0, .3, false}, Case{1, 1, kAir, kSound, 48000, 0, .3, true},
        Case{2, .35, kAir, kSound, 48000, .6, .5, false},
        Case{2, .35, kAir, kSound, 48000, .6, .5, true},
        Case{.5, 2.8, .6, kSound, 96000, 2.5, .1, false},
        Case{.5, 2.8, .6, kSound, 96000, 2.5, .1, true},
        Case{1, 1, kAir, kSound, 44100, 1.2, 2, true}})
    for (const unsigned l : {0U, 1U, 2U, 4U}) {
      const double mode_hz = 2500 / c.size; // of the body as it is
      const ModalTable table = make_table(l, 2500, c.band);
      const RadiatingSurface::Scene scene{c.size,  c.shape_scale, c.air,
                                          c.sound, c.rate,        Arrivals::kMaxSpread};
      const Vec3 centre = c.size * table.multipoles.centre;
      const Vec3 listener = centre + c.distance * Vec3{std::sin(c.polar) * .6,
                                                       std::sin(c.polar) * .8, std::cos(c.polar)};
      const std::array<double, 1> omega{2 * kPi * mode_hz};
      const auto arrivals = multipole_arrivals(table, omega, listener, scene, {}, 1);
      const double a = c.size * kRadius;
      const TravelTime travel((c.distance - a) / c.sound, c.rate);
      CHECK(arrivals->delay_s == approx(travel.delay_s));
      const double legendre = std::legendre(l, std::cos(c.polar));
      double loudest = 0;
      for (const double hz : {200., 600., 1500., 4000., 9000., 16000.})
        loudest = std::max(loudest, abs(sphere(l, a, c.distance, 2 * kPi * hz, c.air, c.sound)));
      for (const double hz : {200., 600., 1500., mode_hz, 4000., 9000., 16000.}) {
        if (c.band && hz * c.size > 21000) // beyond the table's band
          continue;
        const double w = 2 * kPi * hz;
        const Complex exact = c.shape_scale * legendre *
                              sphere(l, a, c.distance, w, c.air, c.sound) *
                              (c.band ? lag(w * a / c.sound) : 1.) *
                              tactus::math::polar(1., -w * travel.fractional_samples / c.rate);
        CAPTURE(c.size);
        CAPTURE(c.band);
        CAPTURE(l);
        CAPTURE(hz);
        for (const Complex& found : spectrum(*arrivals, 0, hz, c.rate)) {
          CAPTURE(abs(found / exact));
          CHECK(abs(found - exact) <
                .02 * abs(exact) + 2e-4 * c.shape_scale * std::abs(legendre) * loudest);
        }
      }
    }
}

TEST_CASE("the lowest frequencies of a high degree are right although its highest are cut off") {
  constexpr unsigned kDegree = 3;
  const ModalTable table = make_table(kDegree, 2500, true);
  const std::array<double, 1> omega{2 * kPi * 2500};
  const RadiatingSurface::Scene scene{1, 1, kAir, kSound, kRate, Arrivals::kMaxSpread};
  const auto arrivals =
      multipole_arrivals(table, omega, table.multipoles.centre + Vec3{0, 0, .3}, scene, {}, 1);
  const TravelTime travel((.3 - kRadius) / kSound, kRate);
  for (const double hz : {10., 25., 50.}) { // without the correction .65 % off
    const double w = 2 * kPi * hz;
    const Complex exact = sphere(kDegree, kRadius, .3, w, kAir, kSound) *
                          lag(w * kRadius / kSound) *
                          tactus::math::polar(1., -w * travel.fractional_samples / kRate);
    CAPTURE(hz);
    const Complex found = spectrum(*arrivals, 0, hz, kRate)[0];
    CHECK(abs(found - exact) < .005 * abs(exact));
  }
}

TEST_CASE(
    "inside the reference sphere the field is that on the sphere, and no multipoles give silence") {
  const ModalTable table = make_table(0, 2500, false);
  const std::array<double, 1> omega{2 * kPi * 2500}, none{0};
  const RadiatingSurface::Scene scene;
  const Vec3 centre = table.multipoles.centre;
  const auto level = [&](const Vec3& from_centre, std::span<const double> rates) {
    const auto arrivals = multipole_arrivals(table, rates, centre + from_centre, scene, {}, 1);
    return abs(spectrum(*arrivals, 0, 1000, kRate)[0]);
  };
  const double on = level({0, 0, kRadius}, omega);
  CHECK(on > 0);
  CHECK(level({0, 0, .1 * kRadius}, omega) == approx(on).epsilon(1e-6));
  CHECK(level({}, omega) == approx(on).epsilon(1e-6));
  CHECK(level({0, 0, 1}, none) == 0);
}

TEST_CASE("at a mode's own frequency its multipoles sound with their own phase, near and far") {
  constexpr double kOmega = 2 * kPi * 2000;
  const Complex turned(.6, .8); // no sphere's phase
  ModalTable table = make_table(1, 2000);
  for (auto& c : table.multipoles.coefficients)
    c *= narrowed(turned);
  for (const double r : {.05, .2, 1.}) {
    CAPTURE(r);
    const std::array<double, 1> omega{kOmega};
    const auto arrivals =
        multipole_arrivals(table, omega, table.multipoles.centre + r * Vec3{0, .6, .8},
                           RadiatingSurface::Scene{}, {}, 1);
    const TravelTime travel((r - kRadius) / kSound, kRate);
    const Complex exact = turned * .8 * sphere(1, kRadius, r, kOmega, kAir, kSound) *
                          tactus::math::polar(1., -kOmega * travel.fractional_samples / kRate);
    for (const Complex& found : spectrum(*arrivals, 0, 2000, kRate))
      CHECK(abs(found / exact - 1.) < .01);
  }
}

TEST_CASE("recoil sounds along its dipole's axis as the cosine, and turning does not") {
  const ModalTable table = make_table(0, 2500, false);
  const std::array<double, 1> omega{2 * kPi * 2500};
  const double s = std::sqrt(.5);
  const std::array<RigidDipole, 3> dipoles{RigidDipole{{s, s, 0}, .02}, RigidDipole{{s, -s, 0}, 0},
                                           RigidDipole{{0, 0, 1}, 9}}; // wider than the table's
  const RadiatingSurface::Scene scene;
  for (const Vec3& unit_direction : {Vec3{1, 0, 0}, Vec3{.6, .8, 0}, Vec3{0, .6, .8}})
    for (const double r : {.06, 1.5}) {
      const auto arrivals = multipole_arrivals(
          table, omega, table.multipoles.centre + r * unit_direction, scene, dipoles, 4);
      for (std::size_t motion = 0; motion < 6; ++motion)
        for (const double hz : {300., 2000.}) {
          const double w = 2 * kPi * hz;
          Complex exact = 0;
          for (const RigidDipole& d : dipoles)
            if (motion < 3 && d.radius_m > 0)
              exact += d.axis[static_cast<int>(motion)] * dot(d.axis, unit_direction) / 2 *
                       sphere(1, std::min(d.radius_m, kRadius), r, w, kAir, kSound);
          const double found = abs(spectrum(*arrivals, 1 + motion, hz, kRate)[0]);
          CAPTURE(motion);
          CAPTURE(hz);
          CHECK(std::abs(found - abs(exact)) < .03 * abs(exact) + 1e-9);
        }
    }
}
