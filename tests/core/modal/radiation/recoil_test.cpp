// The direct sound of forces beside closed forms: the recoil of a free body, what forces before
// now have still to give, and sources of high degree at low frequencies.
#include "core/modal/radiation/direct_sound.hpp"
#include "core/modal/radiation/multipole.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;
using Complex = std::complex<double>;

namespace {

constexpr double kPi = std::numbers::pi, kRate = 48000;

/// Sounds of a force by given kernels; one listener, no glide.
std::vector<float> play(DirectSound& direct, std::size_t frames) {
  std::vector<float> sound(frames, 0);
  for (std::size_t n = 0; n < frames; n += 64)
    direct.finish(0, std::span(sound).subspan(n, 64), Glide());
  return sound;
}

/// A ball of radius a that breathes, by its multipoles.
ModalTable breathing_ball(double a) {
  ModalTable table;
  table.material = {"aluminium", 70.3e9, .33, 2700};
  constexpr std::int32_t kRinging = 16, kAround = 32; // a closed surface, 1 % smaller than the ball
  for (std::int32_t i = 0; i <= kRinging; ++i)
    for (std::int32_t k = 0; k < kAround; ++k) {
      const double polar = kPi * i / kRinging, around = 2 * kPi * k / kAround;
      table.vertex_m.push_back({a * std::sin(polar) * std::cos(around),
                                a * std::sin(polar) * std::sin(around), a * std::cos(polar)});
      if (i == kRinging)
        continue;
      const std::int32_t p = i * kAround + k, q = i * kAround + (k + 1) % kAround;
      if (i > 0)
        table.triangle.push_back({p, p + kAround, q});
      if (i + 1 < kRinging)
        table.triangle.push_back({q, p + kAround, q + kAround});
    }
  table.shape.assign(3 * table.vertices(), 0);
  table.frequency_hz = {500};
  table.loss_factor = {1e-3};
  table.free = true;
  table.mass_kg = 4. / 3 * kPi * a * a * a * 2700;
  const double inertia = .4 * table.mass_kg * a * a;
  table.inertia_kg_m2 = {Vec3{inertia, 0, 0}, Vec3{0, inertia, 0}, Vec3{0, 0, inertia}};
  MultipoleTable& m = table.multipoles;
  m.highest_degree = {0};
  m.offset = {0, 1};
  m.scales = {1};
  m.reference_radius_m = a;
  m.coefficients.assign(1, 1);
  return table;
}

} // namespace

TEST_CASE("a free body's recoil is heard through its suspension, Butterworth's filter at 4 Hz") {
  for (const double rate : {44100., 48000., 96000.}) {
    DirectSound direct;
    direct.prepare(rate);
    const ForceKernel kernel{{0}, {1}};
    direct.add_sample(0, ModeBank::kLatest, 0, kernel, 1, 1);
    const auto sound = play(direct, static_cast<std::size_t>(2 * rate) / 64 * 64);
    for (const double hz : {.5, 1., 2., 4., 8., 40., 1000., 15000.}) {
      Complex sum = 0;
      for (std::size_t n = 0; n < sound.size(); ++n)
        sum += static_cast<double>(sound[n]) *
               std::polar(1., -2 * kPi * hz * static_cast<double>(n) / rate);
      const double ratio =
          std::tan(kPi * DirectSound::kSuspensionHz / rate) / std::tan(kPi * hz / rate);
      CAPTURE(rate);
      CAPTURE(hz);
      CHECK(std::abs(sum) == approx(1 / std::sqrt(1 + std::pow(ratio, 4))).epsilon(1e-3));
    }
    CHECK(sound.back() == 0); // and it falls asleep
  }
}

TEST_CASE("a free body recoils as loudly in any size of the same density") {
  // The air's share grows with the volume as its mass does: rho_air/rho of the impulse, for a body
  // small against the wave.
  const auto recoil = [](double size, double density) {
    Rig rig(kRate, breathing_ball(.02));
    rig.settings.radiation = Radiation::kBody;
    rig.settings.size = size;
    rig.settings.density_kg_per_m3 = density;
    rig.settings.listener[0] = {0, 0, 2};
    rig.rebuild(false);
    auto model = std::make_unique<BodyModel>(rig.loaded, rig.settings);
    model->build_point_kernels(model->nearest({0, 0, size}), {0, 0, 1});
    const ForceKernel& kernel = model->sample_kernel[0][0];
    REQUIRE(!kernel.rigid.empty());
    // Its level at 300 Hz, where the ball is much smaller than the wave.
    Complex sum = 0;
    for (std::size_t n = 0; n < kernel.rigid.size(); ++n)
      sum += static_cast<double>(kernel.rigid[n]) *
             std::polar(1., -2 * kPi * 300 * static_cast<double>(n) / kRate);
    return std::abs(sum);
  };
  // Half the displaced air in added mass: 3/2 V rho_air/(4 pi r c) (1/m) jw (1 + c/(jw r)).
  const double c = 346.1, air = 1.184, r = 2, w = 2 * kPi * 300, volume = 4. / 3 * kPi * 8e-6;
  // The table's air is its own.
  const ModalTable table = breathing_ball(.02);
  const double scale = table.air_density_kg_per_m3 / air, speed = table.sound_speed_m_per_s / c;
  const double expected = 1.5 * volume * air * scale / (4 * kPi * r * c * speed) *
                          std::abs(Complex(c * speed / r, w)) / (volume * 2700);
  const double own = recoil(1, 0);
  CHECK(own == approx(expected).epsilon(.02));
  CHECK(recoil(2, 0) == approx(own).epsilon(.01));
  CHECK(recoil(.5, 0) == approx(own).epsilon(.01));
  CHECK(recoil(1, 5400) == approx(own / 2).epsilon(.01));
}

TEST_CASE("add_history() gives the output of a force that has been constant for long") {
  const std::size_t taps = 40;
  ForceKernel kernel{std::vector<float>(3 * taps), std::vector<float>(3 * taps)};
  for (std::size_t i = 0; i < 3 * taps; ++i) {
    kernel.elastic[i] = static_cast<float>(std::sin(1 + .7 * static_cast<double>(i)));
    kernel.rigid[i] = static_cast<float>(1e-3 * std::cos(.3 * static_cast<double>(i)));
  }
  const std::array<double, 3> force{2, -.5, .25};
  DirectSound acted, taken;
  for (DirectSound* direct : {&acted, &taken})
    direct->prepare(kRate);
  std::vector<float> sound(64);
  for (int chunk = 0; chunk < 3; ++chunk) {
    for (std::size_t n = 0; n < 64; ++n)
      acted.add_moments(1, ModeBank::kLatest, n, {kernel.elastic, {}}, taps, force);
    acted.finish(1, sound, Glide());
  }
  taken.add_history(1, {kernel.elastic, {}}, taps, force);
  std::vector<float> a(64), b(64);
  acted.finish(1, a, Glide());
  taken.finish(1, b, Glide());
  CHECK(std::abs(a[0]) > .01F);
  for (std::size_t n = 0; n < 64; ++n)
    CHECK(std::abs(a[n] - b[n]) < 2e-5F);
  CHECK(std::all_of(a.begin() + taps - 1, a.end(), [](float x) { return x == 0; }));
}

TEST_CASE("forces through a glide's three kernels sound in its blend, and merge in it") {
  Glide glide;
  static_cast<void>(glide.start());
  static_cast<void>(glide.advance(Glide::kSegment)); // old, middle; the fresh one waits
  static_cast<void>(glide.start());
  static_cast<void>(glide.advance(Glide::kSegment));
  Glide other;
  static_cast<void>(other.start());
  static_cast<void>(other.start()); // the next target waits
  static_cast<void>(other.advance(Glide::kSegment + 0));
  static_cast<void>(other.advance(200));
  REQUIRE(other.has_old());
  REQUIRE(other.has_latest());
  const float level[3] = {1, 10, 100};
  const auto make = [&](DirectSound& direct) {
    direct.prepare(kRate);
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest})
      for (std::size_t n = 0; n < 64; ++n)
        direct.add_sample(0, part, n, {{level[part]}, {}}, 1, 1);
  };
  DirectSound direct;
  make(direct);
  std::vector<float> sound(64);
  direct.finish(0, sound, other);
  for (std::size_t n = 0; n < 64; ++n) {
    // The B-spline's weights at the middle of the sample.
    const double u = (200 + static_cast<double>(n) + .5) / 512;
    const double expected = .5 * (1 - u) * (1 - u) * static_cast<double>(level[ModeBank::kOld]) +
                            (.5 + u * (1 - u)) * static_cast<double>(level[ModeBank::kMiddle]) +
                            .5 * u * u * static_cast<double>(level[ModeBank::kLatest]);
    CHECK(static_cast<double>(sound[n]) == approx(expected).epsilon(1e-5));
  }
  // Settled: all parts are the blend of now, whatever comes.
  DirectSound settled;
  make(settled);
  settled.merge_parts(other);
  std::vector<float> still(64), moving(64);
  DirectSound copy = settled;
  settled.finish(0, still, Glide());
  copy.finish(0, moving, other);
  for (std::size_t n = 0; n < 64; ++n) {
    CHECK(still[n] == approx(sound[0]).epsilon(1e-5));
    CHECK(moving[n] == approx(sound[0]).epsilon(1e-5));
  }
  // A listener that goes takes its own sound along, and no other's.
  DirectSound two;
  two.prepare(kRate);
  for (std::size_t l = 0; l < 2; ++l)
    two.add_sample(l, ModeBank::kLatest, 3, {{1, 1}, {1, 1}}, 2, 1);
  two.clear_from(1);
  std::vector<float> first(64), second(64);
  two.finish(0, first, Glide());
  two.finish(1, second, Glide());
  CHECK(first[3] == approx(2).epsilon(1e-3));
  CHECK(std::all_of(second.begin(), second.end(), [](float x) { return x == 0; }));
}

TEST_CASE("a source of high degree is heard at low frequencies as a sphere's, far below its own") {
  // p = -rho h_l(k r)/(k h_l'(k a)) for an acceleration P_l(cos theta) of the sphere.
  const double a = .05, c = 346.1, air = 1.184, mode_hz = 9000;
  const auto hankel = [](int degree, double x) { // h_l and h_l', second kind
    Complex before = Complex(0, 1) * std::polar(1., -x) / x, h = before;
    if (degree > 0)
      h = before * (1 / x) - std::polar(1., -x) / x;
    for (int l = 1; l < degree; ++l) {
      const Complex next = (2. * l + 1) / x * h - before;
      before = h;
      h = next;
    }
    return std::pair(h, before - (degree + 1.) / x * h);
  };
  for (const int degree : {2, 3, 4}) {
    const auto exact = [&](double hz, double r) { // its travel from the sphere on taken out
      const double k = 2 * kPi * hz / c;
      return -air * hankel(degree, k * r).first / (k * hankel(degree, k * a).second) *
             std::polar(1., k * (r - a));
    };
    ModalTable table;
    table.frequency_hz = {mode_hz};
    MultipoleTable& m = table.multipoles;
    const auto l = static_cast<std::size_t>(degree);
    m.highest_degree = {degree};
    m.offset = {0, static_cast<std::int32_t>((l + 1) * (l + 1))};
    m.scales = {1};
    m.reference_radius_m = a;
    m.coefficients.assign((l + 1) * (l + 1), 0);
    const double omega = 2 * kPi * mode_hz;
    m.coefficients[l * l + l] =
        Complex(Complex(0, omega) * exact(mode_hz, a) / std::sqrt((2. * degree + 1) / (4 * kPi)));
    const std::array<double, 1> rates{omega};
    for (const double r : {.15, .5}) {
      const auto arrivals =
          multipole_arrivals(table, rates, {0, 0, r}, RadiatingSurface::Scene{}, {}, 1);
      std::vector<double> pressure(arrivals->samples() * BandLimit::kNodes);
      arrivals->find(0, pressure);
      for (const double hz : {150., 400., 1000., 2500., 6000., 9000., 15000.}) {
        Complex sum = 0, sampled = 0; // all through the samples, and where they begin
        for (std::size_t n = 0; n < arrivals->samples(); ++n)
          sampled += pressure[n * BandLimit::kNodes] *
                     std::polar(1., -2 * kPi * hz / kRate *
                                        (static_cast<double>(n) - BandLimit::kLatency));
        for (std::size_t n = 0; n < arrivals->samples(); ++n)
          for (std::size_t k = 0; k < BandLimit::kGauss; ++k)
            sum += BandLimit::kGaussWeight[k] * pressure[n * BandLimit::kNodes + 1 + k] *
                   std::polar(1., -2 * kPi * hz / kRate *
                                      (static_cast<double>(n) + BandLimit::kNode[1 + k] -
                                       BandLimit::kLatency));
        CAPTURE(degree);
        CAPTURE(r);
        CAPTURE(hz);
        CAPTURE(std::abs(sum / exact(hz, r)));
        CHECK(std::abs(sum / exact(hz, r) - 1.) < .02);
        CHECK(std::abs(sampled / exact(hz, r) - 1.) < .02);
      }
    }
  }
}
