#include "core/dsp/complex.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/radiation.hpp"
#include "core/reed/bore/wall_loss.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/playability/linear_stability.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Transfer to the open end, gain included, without the delay.
Complex incident(const RoundTrip& trip, double frequency, double rate) {
  const Complex back = tactus::math::polar(1.0, -kTwoPi * frequency / rate);
  Complex h = 1;
  for (std::size_t k = 0; k < trip.loss_pole.size(); ++k)
    h += trip.loss_residue[k] * back / (1.0 - trip.loss_pole[k] * back);
  return trip.incident_gain * h;
}
/// And back.
Complex reflected(const RoundTrip& trip, double frequency, double rate) {
  return incident(trip, frequency, rate) *
         trip.end.at(tactus::math::polar(1.0, -kTwoPi * frequency / rate));
}

/// Both ways and the open end by their equations, without the delay.
Complex exact_reflection(const Parameters& p, double length, double sound_speed, Complex s) {
  return exp(-wall_loss(p, length, sound_speed) * sqrt(s)) *
         OpenEnd::reflection(s * p.end_radius / sound_speed);
}

} // namespace

TEST_CASE("the wall-loss filter follows exp(-G sqrt(s)) at every sample rate") {
  struct Range {
    double length, highest_hz, tolerance_db; // what eight sections reach
  };
  for (const Range& range :
       {Range{0.48, 1000, 0.02}, Range{2.0, 1000, 0.11}, Range{1.0, 10e3, 0.15}})
    for (const double rate : {44100.0, 48000.0, 64000.0, 96000.0, 192000.0, 768000.0}) {
      Parameters p;
      BoreDesign design;
      design.set(p, rate);
      const RoundTrip trip = design.round_trip(range.length);
      const double g = wall_loss(p, range.length, design.air().sound_speed);
      for (double f = 50; f <= range.highest_hz; f *= 1.1) {
        const double expected = std::exp(-g * std::sqrt(kTwoPi * f / 2));
        CHECK(std::abs(20 * std::log10(abs(incident(trip, f, rate)) / expected)) <
              range.tolerance_db);
      }
    }
}

TEST_CASE("an open end reflects long waves whole, a little behind itself, and short waves less") {
  for (const double ka : {0.01, 0.03, 0.1}) {
    const Complex r = OpenEnd::reflection({0, ka});
    CHECK(std::abs(abs(r) - (1 - ka * ka / 2)) < 0.5 * ka * ka * ka);
    // R = -exp(-2 i k 0.613 r): the length correction of an unflanged pipe.
    CHECK(std::abs(arg(-r) / (-2 * ka) - OpenEnd::kLengthCorrection) < 0.003);
  }
  for (double ka = 0; ka < 20; ka += 0.1)
    CHECK(abs(OpenEnd::reflection({0, ka})) <= 1);
  // The factors of the denominator are the denominator.
  CHECK(1 / (OpenEnd::kFirstPole * OpenEnd::kSecondPole) == doctest::Approx(OpenEnd::kSecond));
  CHECK(1 / OpenEnd::kFirstPole + 1 / OpenEnd::kSecondPole == doctest::Approx(OpenEnd::kFirst));
  // Its filter does so below 5 kHz, and never reflects more than all.
  const double c = air_at(20).sound_speed;
  for (const double rate : {8000.0, 44100.0, 192000.0, 768000.0})
    for (const double radius : {1e-3, 3e-3, 7.5e-3, 25e-3, 60e-3, 0.3}) {
      const auto end = DigitalOpenEnd::of(radius / c * rate, 1 / rate);
      CHECK(abs(end.at(1.0) + 1.0) < 1e-9);
      for (int i = 1; i <= 300; ++i)
        CHECK(abs(end.at(tactus::math::polar(1.0, -std::numbers::pi * i / 300))) <= 1 + 1e-12);
      for (double f = 100; f < 5000 && rate > 40e3; f *= 1.3)
        CHECK(abs(end.at(tactus::math::polar(1.0, -kTwoPi * f / rate)) -
                  OpenEnd::reflection({0, kTwoPi * f * radius / c})) < 0.02);
    }
}

TEST_CASE("no filter of the bore amplifies at any frequency") {
  for (const Preset& preset : presets())
    for (const double length : {0.005, 0.05, 0.5, 2.0, 15.0})
      for (const double rate : {8000.0, 48000.0, 192000.0}) {
        BoreDesign design;
        Parameters p = preset.parameters;
        p.wall_loss = length > 1 ? 20 : 1;
        design.set(p, rate);
        const RoundTrip trip = design.round_trip(length);
        double previous = 1 + 1e-10;
        for (double f = 0; f < 0.5 * rate; f += rate / 256) {
          const double at_end = abs(incident(trip, f, rate));
          CHECK(at_end <= 1 + 1e-10);
          CHECK(at_end <= previous); // and losses rise with frequency
          CHECK(abs(reflected(trip, f, rate)) <= at_end + 1e-10);
          previous = at_end + 1e-9;
        }
      }
}

TEST_CASE("modes 1 to 6 of a plain tube lie within a cent of the poles of the exact admittance") {
  // A mode lies where the round trip's phase is a multiple of 2 pi; a phase too small by e moves
  // it by e over the phase's slope. The poles come from LinearStability, the phase from what the
  // bore computes: the delay line's interpolation, the loss sections and the open end.
  for (const double rate : {44100.0, 48000.0, 96000.0, 192000.0})
    for (const double length : {0.3, 0.5, 1.0, 2.4, 5.0}) {
      Parameters p;
      p.length = length;
      BoreDesign design;
      design.set(p, rate);
      const RoundTrip trip = design.round_trip(length);
      const LinearStability theory(p, length);
      const int nearest = static_cast<int>(trip.delay) - 2;
      const auto weights = BoreLine<double, 64>::weights(trip.delay - nearest);
      const auto phase = [&](double f) {
        Complex line = 0;
        for (std::size_t k = 0; k < weights.size(); ++k)
          line += weights[k] *
                  tactus::math::polar(1.0, -kTwoPi * f / rate * (nearest + static_cast<double>(k)));
        return arg(reflected(trip, f, rate) * line);
      };
      for (int mode = 1; mode <= 6; ++mode) {
        const Mode exact =
            theory.bore_resonance_near((2 * mode - 1) * design.ideal_frequency(length));
        REQUIRE(exact.found);
        // The real part of the pole moves the phase's argument off the axis: to first order the
        // exact round trip has a phase there, too, which is taken off.
        const double f = exact.frequency_hz, c = design.air().sound_speed;
        const Complex s(0, kTwoPi * f);
        const double theirs = arg(exp(-s * (2 * length / c)) * exact_reflection(p, length, c, s));
        const double slope = (phase(f + 0.01) - phase(f - 0.01)) / 0.02;
        INFO("mode ", mode, " of ", length, " m at ", rate, " Hz");
        CHECK(std::abs(1200 * std::log2(1 - (phase(f) - theirs) / slope / f)) < 1);
      }
    }
}

TEST_CASE("length and ideal frequency are each other's inverse, within what the line can hold") {
  for (const Preset& preset : presets()) {
    BoreDesign design;
    design.set(preset.parameters, 48000);
    for (const double f : {50.0, 110.0, 220.0})
      CHECK(design.ideal_frequency(design.length_for(f)) == doctest::Approx(f));
  }
  BoreDesign clarinet;
  clarinet.set(Parameters{}, 48000);
  CHECK(clarinet.length_for(1e9) == doctest::Approx(5e-3)); // the shortest
  CHECK(max_delay(48000) > 2 * clarinet.max_length() / clarinet.air().sound_speed * 48000);
}

} // namespace tactus::reed
