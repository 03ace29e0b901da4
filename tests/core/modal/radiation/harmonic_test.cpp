// Spherical harmonics and waves beside the standard library's special functions.
#include "core/modal/radiation/multipole.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>

using namespace tactus::modal;
using tactus::test::approx;
using Complex = std::complex<double>;

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
                                   std::polar(1., order * azimuth);
          const auto sums = seen.sums(0, 1), band = seen.band_sums(0, 2);
          CAPTURE(l);
          CAPTURE(order);
          for (std::int32_t other = 0; other <= kHighest; ++other) {
            const Complex expected = other == l ? harmonic : 0.;
            const auto i = static_cast<std::size_t>(other);
            CHECK(std::abs(sums[i] - Complex(2, 1) * expected) < 1e-10);
            CHECK(std::abs(band[i] - Complex(0, -1) * expected) < 1e-10);
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
  const double whole = std::sqrt(4 * std::numbers::pi);
  const auto at = [&](double ratio) { return (seen.sums(1, ratio)[0] * whole).real(); };
  CHECK(at(.1) == approx(10));
  CHECK(at(.5) == approx(10));
  CHECK(at(.75) == approx(15));
  CHECK(at(1) == approx(20));
  CHECK(at(1.5) == approx(35));
  CHECK(at(2) == approx(50));
  CHECK(at(9) == approx(50));
  CHECK(seen.sums(0, 1)[0] == 0.);
}

TEST_CASE("spherical waves are Bessel's and Neumann's functions, outgoing") {
  for (const double x : {.05, .3, 1., 4., 30.}) {
    const auto h = spherical_hankel(8, x);
    REQUIRE(h.size() == 9);
    for (unsigned l = 0; l <= 8; ++l) {
      const Complex expected(std::sph_bessel(l, x), -std::sph_neumann(l, x));
      CAPTURE(x);
      CAPTURE(l);
      CHECK(std::abs(h[l] - expected) < 1e-9 * std::abs(expected));
    }
  }
  CHECK(spherical_hankel(0, 1).size() == 1);
}
