// What a listener receives of multipoles, beside the exact field of a vibrating sphere: known at
// one frequency or in a band, from any side, in any size, air and sample rate.
#include "core/modal/radiation/multipole.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using tactus::test::approx;
using Complex = std::complex<double>;

namespace {

constexpr double kPi = std::numbers::pi, kRadius = .04, kAir = 1.184, kSound = 346.1;

/// Pressure at r for an acceleration P_l(cos theta) of a sphere of radius a, per P_l, its travel
/// from the sphere taken out: -rho h_l(k r)/(k h_l'(k a)) e^(j k (r - a)), outgoing waves.
Complex sphere(unsigned l, double a, double r, double omega, double air, double sound) {
  const double k = omega / sound;
  const auto hankel = [](unsigned degree, double x) {
    return Complex(std::sph_bessel(degree, x), -std::sph_neumann(degree, x));
  };
  const double x = k * a;
  const Complex slope = l == 0 ? -hankel(1, x) : hankel(l - 1, x) - (l + 1.) / x * hankel(l, x);
  return -air * hankel(l, k * r) / (k * slope) * std::polar(1., k * (r - a));
}

/// The sphere's velocity over that of its mode: it lags, causally, the more the faster.
Complex lag(double x) { return 1. / Complex(1, .4 * x); }

/// One mode of degree l, known at its own frequency or in a band; P_l about the z axis.
ModalTable make_table(unsigned l, double mode_hz, bool band) {
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
    return std::complex<float>(Complex(0, omega) *
                               sphere(l, kRadius, kRadius, omega, kAir, kSound) / harmonic *
                               (band ? lag(omega * kRadius / kSound) : 1.));
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

/// Spectrum of what arrives, per second: all through the samples, and where they begin.
std::array<Complex, 2> spectrum(const Arrivals& arrivals, std::size_t motion, double hz,
                                double rate) {
  std::vector<double> pressure(arrivals.samples() * BandLimit::kNodes);
  arrivals.find(motion, pressure);
  std::array<Complex, 2> sum{};
  for (std::size_t n = 0; n < arrivals.samples(); ++n)
    for (std::size_t m = 0; m < BandLimit::kNodes; ++m)
      sum[m == 0] += (m == 0 ? 1 : BandLimit::kGaussWeight[m - 1]) *
                     pressure[n * BandLimit::kNodes + m] *
                     std::polar(1., -2 * kPi * hz / rate *
                                        (static_cast<double>(n) + BandLimit::kNode[m] -
                                         static_cast<double>(BandLimit::kLatency)));
  return sum;
}

} // namespace

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
    for (const unsigned l : {0U, 1U, 3U}) {
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
        loudest =
            std::max(loudest, std::abs(sphere(l, a, c.distance, 2 * kPi * hz, c.air, c.sound)));
      for (const double hz : {200., 600., 1500., mode_hz, 4000., 9000., 16000.}) {
        if (c.band && hz * c.size > 21000) // beyond the table's band
          continue;
        const double w = 2 * kPi * hz;
        const Complex exact = c.shape_scale * legendre *
                              sphere(l, a, c.distance, w, c.air, c.sound) *
                              (c.band ? lag(w * a / c.sound) : 1.) *
                              std::polar(1., -w * travel.fractional_samples / c.rate);
        CAPTURE(c.size);
        CAPTURE(c.band);
        CAPTURE(l);
        CAPTURE(hz);
        for (const Complex& found : spectrum(*arrivals, 0, hz, c.rate)) {
          CAPTURE(std::abs(found / exact));
          CHECK(std::abs(found - exact) <
                .02 * std::abs(exact) + 2e-4 * c.shape_scale * std::abs(legendre) * loudest);
        }
      }
    }
}

TEST_CASE("the lowest frequencies of a high degree are right although its highest are cut off") {
  constexpr unsigned kDegree = 3;
  const ModalTable table = make_table(kDegree, 2500, true);
  const std::array<double, 1> omega{2 * kPi * 2500};
  const RadiatingSurface::Scene scene{1, 1, kAir, kSound, 48000, Arrivals::kMaxSpread};
  const auto arrivals =
      multipole_arrivals(table, omega, table.multipoles.centre + Vec3{0, 0, .3}, scene, {}, 1);
  const TravelTime travel((.3 - kRadius) / kSound, 48000);
  for (const double hz : {10., 25., 50.}) { // without the correction .65 % off
    const double w = 2 * kPi * hz;
    const Complex exact = sphere(kDegree, kRadius, .3, w, kAir, kSound) *
                          lag(w * kRadius / kSound) *
                          std::polar(1., -w * travel.fractional_samples / 48000);
    CAPTURE(hz);
    const Complex found = spectrum(*arrivals, 0, hz, 48000)[0];
    CHECK(std::abs(found - exact) < .005 * std::abs(exact));
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
    return std::abs(spectrum(*arrivals, 0, 1000, 48000)[0]);
  };
  const double on = level({0, 0, kRadius}, omega);
  CHECK(on > 0);
  CHECK(level({0, 0, .1 * kRadius}, omega) == approx(on).epsilon(1e-6));
  CHECK(level({}, omega) == approx(on).epsilon(1e-6));
  CHECK(level({0, 0, 1}, none) == 0);
}

TEST_CASE("recoil sounds along its dipole's axis as the cosine, and turning does not") {
  const ModalTable table = make_table(0, 2500, false);
  const std::array<double, 1> omega{2 * kPi * 2500};
  const double s = std::sqrt(.5);
  const std::array<RigidDipole, 3> dipoles{RigidDipole{{s, s, 0}, .02}, RigidDipole{{s, -s, 0}, 0},
                                           RigidDipole{{0, 0, 1}, 9}}; // wider than the table's
  const RadiatingSurface::Scene scene;
  for (const Vec3& unit_direction : {Vec3{1, 0, 0}, Vec3{.6, .8, 0}, Vec3{0, .6, .8}}) {
    const auto arrivals = multipole_arrivals(
        table, omega, table.multipoles.centre + 1.5 * unit_direction, scene, dipoles, 4);
    for (std::size_t motion = 0; motion < 6; ++motion)
      for (const double hz : {300., 2000.}) {
        const double w = 2 * kPi * hz;
        Complex exact = 0;
        for (const RigidDipole& d : dipoles)
          if (motion < 3 && d.radius_m > 0)
            exact += d.axis[static_cast<int>(motion)] * dot(d.axis, unit_direction) / 2 *
                     sphere(1, std::min(d.radius_m, kRadius), 1.5, w, kAir, kSound);
        const double found = std::abs(spectrum(*arrivals, 1 + motion, hz, 48000)[0]);
        CAPTURE(motion);
        CAPTURE(hz);
        CHECK(std::abs(found - std::abs(exact)) < .03 * std::abs(exact) + 1e-9);
      }
  }
}
