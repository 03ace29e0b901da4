#include "core/dsp/complex.hpp"
#include "core/reed/bore/radiation_path.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

// The numbers of the way out of the bore, against the equations in radiation_path.hpp.

namespace tactus::reed {
namespace {

constexpr double kPi = std::numbers::pi;
const double kSpeed = 331.45 * std::sqrt(1 + 20 / 273.15);

/// dB of the path's response over an expected one.
double error_db(const RadiationConstants& c, double turns_a_sample, Complex expected) {
  const Complex back = tactus::math::polar(1.0, -2 * kPi * turns_a_sample);
  const Complex found = (c.b0 + back * (c.b1 + back * c.b2)) / (1.0 + back * (c.a1 + back * c.a2));
  return std::abs(20 * std::log10(abs(found / expected)));
}

RadiationConstants constants_of(const Parameters& p, double rate) {
  BoreDesign bore;
  bore.set(p, rate);
  return RadiationConstants::from(p, bore, rate);
}

} // namespace

TEST_CASE("a plain open end is a point source of the flow that leaves it, at 1 m") {
  // p = rho/(4 pi) d/dt (w S/(rho c)) = S/(4 pi c) dw/dt
  Parameters p;
  p.input_radius = 0.006;
  for (const double rate : {44100.0, 48000.0, 192000.0}) {
    const RadiationConstants c = constants_of(p, rate);
    CHECK(c.plain);
    for (double hz = 100; hz <= 10e3; hz *= 1.2)
      CHECK(error_db(c, hz / rate, kPi * 36e-6 / (4 * kPi * kSpeed) * 2 * kPi * hz) <
            (hz < 300 ? 1e-3 : 0.06));
  }
}

TEST_CASE("a bell is as loud as its equation says, at any rate") {
  for (const double rate : {44100.0, 48000.0, 192000.0})
    for (const double quality : {0.6, 1.0, 2.5})
      for (const bool cone : {false, true}) {
        Parameters p;
        p.shape = cone ? BoreShape::kCone : BoreShape::kCylinder;
        p.length = 0.5;
        p.apex_distance = 0.25;
        p.input_radius = 0.006;
        p.bell = 1300;
        p.bell_quality = quality;
        const RadiationConstants c = constants_of(p, rate);
        CHECK_FALSE(c.plain);
        // Where the bore opens its radius is r (r_0 + L)/r_0.
        const double opening = 0.006 * (cone ? 3.0 : 1.0), cutoff = 2 * kPi * 1300;
        for (const double hz : {50.0, 700.0, 1300.0, 2600.0, 5000.0, 8000.0, 10000.0}) {
          const Complex s(0, 2 * kPi * hz);
          CAPTURE(hz);
          CHECK(error_db(c, hz / rate,
                         0.5 * 0.006 * s * (s + cutoff * cutoff * opening / kSpeed) /
                             (s * s + s * cutoff / quality + cutoff * cutoff)) < 0.03);
        }
      }
}

TEST_CASE("a loud wave runs ahead by (gamma + 1)/(2 gamma P_0 c) of its pressure and way") {
  // In a simple wave a piece of pressure p travels at c + (gamma + 1)/2 v, v = p/(rho c), and
  // rho c^2 = gamma P_0: over L it arrives earlier by L/c^2 (gamma + 1)/2 p/(rho c).
  Parameters p;
  p.bell = 1000;
  p.brassiness = 3;
  const double gamma = 1.402;
  const double early_s = (gamma + 1) / 2 / (gamma * 101325) / kSpeed; // for each Pa and m
  CHECK(constants_of(p, 96000).lead == doctest::Approx(3 * early_s * 96000).epsilon(1e-9).scale(0));
  p.brassiness = 0;
  CHECK(constants_of(p, 96000).lead == 0);
  // In time: a crest of 600 Pa and a trough of -600 Pa on 1.5 m, 1200 samples apart.
  p.brassiness = 4;
  const double rate = 192000, shift = 4 * early_s * rate * 1.5 * 600;
  REQUIRE(shift > 5);
  REQUIRE(shift < 20);
  p.bell = 1; // above it the path is flat: r/2
  RadiationPath path;
  path.prepare(192000);
  path.set(constants_of(p, rate));
  double crest = 0, trough = 0, crest_at = 0, trough_at = 0;
  for (int i = 0; i < 3200; i += 32) {
    double sound[32];
    for (int k = 0; k < 32; ++k) // smooth, so that nothing overtakes
      sound[k] = 600 * (std::exp(-0.5 * std::pow((i + k - 1000) / 150.0, 2)) -
                        std::exp(-0.5 * std::pow((i + k - 2200) / 150.0, 2)));
    path.run(sound, 32, 1.5);
    for (int k = 0; k < 32; ++k) {
      if (sound[k] > crest)
        crest = sound[k], crest_at = i + k;
      if (sound[k] < trough)
        trough = sound[k], trough_at = i + k;
    }
  }
  // The one came earlier by the shift, the other later; the path's own delay is the same for both.
  CHECK(trough_at - crest_at == doctest::Approx(1200 + 2 * shift).epsilon(0.002).scale(0));
  CHECK(crest == doctest::Approx(600 * p.input_radius / 2).epsilon(0.05).scale(0));
}

} // namespace tactus::reed
