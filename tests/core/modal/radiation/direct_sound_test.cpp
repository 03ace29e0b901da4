// The direct sound of forces: its kernels beside closed forms, and what listeners, other bodies and
// constant forces do to it.
#include "core/modal/radiation/direct_sound.hpp"
#include "core/modal/radiation/multipole.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// Everything arrives at once, after `delay` samples: p = rho q''.
class OneArrival final : public Arrivals {
public:
  OneArrival(double delay, double rate) : delay_(delay), band_(BandLimit::at_rate(rate)) {}
  std::size_t modes() const noexcept override { return 1; }
  std::size_t samples() const noexcept override {
    return static_cast<std::size_t>(delay_) + 1 + BandLimit::kLength;
  }
  void find(std::size_t, std::span<double> pressure) const override {
    for (std::size_t n = 0; n < samples(); ++n)
      for (std::size_t m = 0; m < BandLimit::kNodes; ++m)
        pressure[n * BandLimit::kNodes + m] =
            band_.kernel(static_cast<double>(n) + BandLimit::kNode[m] - delay_ -
                         static_cast<double>(BandLimit::kLatency));
  }

private:
  double delay_;
  const BandLimit& band_;
};

/// q'' for a force exp(s t) at the mode of rate `mode`.
Complex mode_response(Complex s, Complex mode) { return s * s / ((s - mode) * (s - conj(mode))); }

struct OneMode {
  OneMode(double frequency, double decay, double rate, double delay,
          DirectKernels::Mode::Part part = DirectKernels::Mode::Part::kRinging)
      : sample_rate(rate),
        mode(-decay, std::sqrt(std::pow(2 * kPi * frequency, 2) - decay * decay)) {
    const DirectKernels::Mode only{mode, 0, part};
    kernels.build(OneArrival(delay, rate), {&only, 1}, false, rate);
    samples.resize(kernels.taps());
    moments.resize(kernels.moments() * kernels.taps());
    const double gain = 1;
    kernels.assemble_samples({&gain, 1}, samples);
    kernels.assemble_moments({&gain, 1}, moments);
  }
  Complex weight() const { return kernels.weight().empty() ? 0 : kernels.weight()[0]; }
  /// Of impulses at the samples: the kernel and what the bank rings, at a frequency.
  Complex sampled(double frequency) const {
    const Complex z = tactus::math::polar(1.0, -2 * kPi * frequency / sample_rate);
    Complex sum = 0, power = 1;
    for (const float tap : samples) {
      sum += static_cast<double>(tap) * power;
      power *= z;
    }
    const Complex p = exp(mode / sample_rate), w = weight() / sample_rate;
    return sum + (w / (1.0 - p * z) - conj(w) / (1.0 - conj(p) * z)) / Complex(0, 2);
  }
  double sample_rate;
  Complex mode;
  DirectKernels kernels;
  std::vector<float> samples, moments;
};

/// Sounds of forces by given kernels; one listener, no glide.
std::vector<float> play(DirectSound& direct, std::size_t frames, std::size_t listener = 0,
                        const Glide& glide = Glide()) {
  std::vector<float> sound(frames, 0);
  for (std::size_t n = 0; n < frames; n += 64)
    direct.finish(listener, std::span(sound).subspan(n, 64), glide);
  return sound;
}

} // namespace

TEST_CASE("a pushed mode sounds as its acceleration, slow or fast, at the listener's delay") {
  // 0.05 dB, and what the band limit lets alias.
  for (const double rate : {44100.0, 48000.0, 96000.0})
    for (const double frequency : {150.0, 3000.0, 18500.0})
      for (const double decay : {1.0, 300.0, 6000.0})
        for (const double delay : {0.0, 13.37, 90.5}) {
          if (decay > 3 * frequency)
            continue;
          CAPTURE(rate);
          CAPTURE(frequency);
          CAPTURE(decay);
          CAPTURE(delay);
          const OneMode one(frequency, decay, rate, delay);
          const double floor = rate < 47000 ? 3e-4 : 6e-5;
          for (double f = 20; f < 20000; f *= 1.1) {
            CAPTURE(f);
            const Complex s(0, 2 * kPi * f);
            const Complex true_level =
                mode_response(s, one.mode) * exp(-s * (delay + BandLimit::kLatency) / rate);
            const Complex computed = one.sampled(f);
            CHECK(abs(computed - true_level) < 0.006 * abs(true_level) + floor);
          }
          CHECK(abs(one.sampled(0)) < 3e-6);
        }
}

TEST_CASE("a mode too high for the bank follows the force below it") {
  const OneMode one(50000, 30, 48000, 5, DirectKernels::Mode::Part::kTooHigh);
  for (double f = 100; f < 20000; f *= 1.2) {
    const Complex s(0, 2 * kPi * f);
    CAPTURE(f);
    const Complex late = exp(-s * (5.0 + BandLimit::kLatency) / 48000.0);
    const Complex true_level = mode_response(s, one.mode) * late;
    CHECK(std::abs(abs(one.sampled(f)) - abs(true_level)) < 0.012 * abs(true_level) + 3e-5);
  }
}

TEST_CASE("a force that acts throughout the samples sounds as its spectrum says") {
  // A half sine of 2.4 samples, as a steel ball's; the modal part is exact, by its integral.
  for (const double frequency : {2000.0, 15000.0}) {
    const OneMode one(frequency, 40, 48000, 7.3);
    constexpr double kLast = 2.4;
    constexpr std::size_t kFine = 512, kSamples = 9000;
    const auto force = [&](double t) { return t < kLast ? std::sin(kPi * t / kLast) : 0; };
    const std::size_t taps = one.kernels.taps();
    std::vector<double> output(kSamples, 0);
    const Complex rate = one.mode / 48000.0;
    Complex z = 0;
    for (std::size_t n = 0; n < kSamples; ++n) {
      ForceMoments f{};
      z *= exp(rate);
      for (std::size_t i = 0; i < (n < 3 ? kFine : 0); ++i) {
        const double v = 1 - (static_cast<double>(i) + 0.5) / kFine, x = 2 * v - 1;
        const double part = force(static_cast<double>(n) + 1 - v) / kFine;
        f[0] += part;
        f[1] += part * x;
        f[2] += part * (1.5 * x * x - 0.5);
        z += part * exp(rate * v);
      }
      output[n] += (one.weight() / 48000.0 * z).imag();
      for (std::size_t j = 0; j < f.size(); ++j)
        for (std::size_t i = 0; i < taps && n < 3; ++i)
          output[n + i] += f[j] * static_cast<double>(one.moments[j * taps + i]);
    }
    for (double hz = 30; hz < 20000; hz *= 1.15) {
      const Complex s(10, 2 * kPi * hz); // under a window exp(-10 t)
      Complex computed = 0, transform = 0;
      for (std::size_t n = 0; n < kSamples; ++n)
        computed += output[n] * exp(-s * (static_cast<double>(n) + 1) / 48000.0);
      for (std::size_t i = 0; i < 10000; ++i) {
        const double t = (static_cast<double>(i) + 0.5) * kLast / 10000;
        transform += force(t) * exp(-s * t / 48000.0) * kLast / 10000.0;
      }
      const Complex true_level =
          mode_response(s, one.mode) * transform * exp(-s * (7.3 + BandLimit::kLatency) / 48000.0);
      CAPTURE(hz);
      CHECK(abs(computed - true_level) < 0.012 * abs(true_level) + 5e-4 * abs(transform));
    }
  }
}

TEST_CASE("a rigid body's dipole is the ellipsoid's: ball, thin disk, any axes") {
  const double a = 0.04, mass = 0.5, ball = 0.4 * mass * a * a;
  const std::array<Vec3, 3> inertia{Vec3{ball, 0, 0}, Vec3{0, ball, 0}, Vec3{0, 0, ball}};
  for (const RigidDipole& dipole : rigid_dipoles(mass, inertia, 4.0 / 3 * kPi * a * a * a))
    CHECK(dipole.radius_m == approx(a).epsilon(1e-4));
  // A thin oblate ellipsoid: added mass 8/3 rho a^3 along its axis (Lamb, section 108); turned by
  // 30 degrees about x, its axis is (0, -1/2, sqrt(3)/2).
  const double c = 1e-3 * a, flat = mass / 5 * (a * a + c * c), round = mass / 5 * 2 * a * a;
  const double cosine = std::sqrt(0.75), sine = 0.5;
  const std::array<Vec3, 3> disk{
      Vec3{flat, 0, 0},
      Vec3{0, cosine * cosine * flat + sine * sine * round, sine * cosine * (flat - round)},
      Vec3{0, sine * cosine * (flat - round), sine * sine * flat + cosine * cosine * round}};
  const auto dipoles = rigid_dipoles(mass, disk, 4.0 / 3 * kPi * a * a * c);
  const auto strongest =
      std::max_element(dipoles.begin(), dipoles.end(),
                       [](const auto& x, const auto& y) { return x.radius_m < y.radius_m; });
  CHECK(2 * kPi * std::pow(strongest->radius_m, 3) == approx(8.0 / 3 * a * a * a).epsilon(0.01));
  CHECK(std::abs(dot(strongest->axis, Vec3{0, -sine, cosine})) == approx(1).epsilon(1e-6));
}

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
               tactus::math::polar(1., -2 * kPi * hz * static_cast<double>(n) / rate);
      const double ratio =
          std::tan(kPi * DirectSound::kSuspensionHz / rate) / std::tan(kPi * hz / rate);
      CAPTURE(rate);
      CAPTURE(hz);
      CHECK(abs(sum) == approx(1 / std::sqrt(1 + std::pow(ratio, 4))).epsilon(1e-3));
    }
    CHECK(sound.back() == 0); // and it falls asleep
  }
}

TEST_CASE("add_history() gives the output of a force that has been constant for long") {
  const std::size_t taps = 40;
  ForceKernel kernel;
  for (std::size_t i = 0; i < 3 * taps; ++i)
    kernel.elastic.push_back(static_cast<float>(std::sin(1 + .7 * static_cast<double>(i))));
  const std::array<double, 3> force{2, -.5, .25};
  DirectSound acted, taken;
  for (DirectSound* direct : {&acted, &taken})
    direct->prepare(kRate);
  for (int chunk = 0; chunk < 3; ++chunk) {
    for (std::size_t n = 0; n < 64; ++n)
      acted.add_moments(1, ModeBank::kLatest, n, kernel, taps, force);
    static_cast<void>(play(acted, 64, 1));
  }
  taken.add_history(1, kernel, taps, force);
  const auto a = play(acted, 64, 1), b = play(taken, 64, 1);
  CHECK(std::abs(a[0]) > .01F);
  for (std::size_t n = 0; n < 64; ++n)
    CHECK(std::abs(a[n] - b[n]) < 2e-5F);
  CHECK(loudest(std::span(a).subspan(taps - 1)) == 0);
}

TEST_CASE("forces through a glide's three kernels sound in its blend, and merge in it") {
  Glide glide;
  for (int i = 0; i < 2; ++i) // the next target waits
    static_cast<void>(glide.start());
  static_cast<void>(glide.advance(Glide::kSegment));
  static_cast<void>(glide.advance(200));
  REQUIRE(glide.has_old());
  REQUIRE(glide.has_latest());
  const std::array<double, 3> level{1, 10, 100};
  DirectSound direct;
  direct.prepare(kRate);
  for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest})
    for (std::size_t n = 0; n < 64; ++n)
      direct.add_sample(0, part, n, {{static_cast<float>(level[part])}, {}}, 1, 1);
  DirectSound settled = direct;
  const auto sound = play(direct, 64, 0, glide);
  for (std::size_t n = 0; n < 64; ++n) {
    // The B-spline's weights at the middle of the sample.
    const double u = (200 + static_cast<double>(n) + .5) / 512;
    CHECK(sound[n] == approx(.5 * (1 - u) * (1 - u) * level[ModeBank::kOld] +
                             (.5 + u * (1 - u)) * level[ModeBank::kMiddle] +
                             .5 * u * u * level[ModeBank::kLatest])
                          .epsilon(1e-5));
  }
  // Settled: all parts are the blend of now, whatever comes.
  settled.merge_parts(glide);
  DirectSound copy = settled;
  const auto still = play(settled, 64), moving = play(copy, 64, 0, glide);
  for (std::size_t n = 0; n < 64; ++n) {
    CHECK(still[n] == approx(sound[0]).epsilon(1e-5));
    CHECK(moving[n] == approx(sound[0]).epsilon(1e-5));
  }
}

TEST_CASE("a listener that goes takes its own sound along, and no other's") {
  DirectSound two;
  two.prepare(kRate);
  for (std::size_t l = 0; l < 2; ++l)
    two.add_sample(l, ModeBank::kLatest, 3, {{1, 1}, {1, 1}}, 2, 1);
  two.clear_from(1);
  CHECK(play(two, 64, 0)[3] == approx(2).epsilon(1e-3));
  CHECK(loudest(play(two, 64, 1)) == 0);
}

TEST_CASE("kernels of the maximum length fit wherever in a segment they begin") {
  constexpr std::size_t kTaps = DirectKernels::kMaxTaps, kLast = DirectSound::kChunk - 1;
  DirectSound direct;
  direct.prepare(kRate);
  const ForceKernel kernel{std::vector<float>(kTaps, 1), std::vector<float>(kTaps, 0)};
  ForceKernel other = kernel;
  std::fill(other.elastic.begin(), other.elastic.end(), 3.F);
  for (std::size_t l = 0; l < DirectSound::kListeners; ++l)
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest})
      direct.add_sample(l, part, kLast, part == ModeBank::kLatest ? kernel : other, kTaps, 1);
  for (std::size_t n = 0; n < kTaps + 128; n += 64)
    for (std::size_t l = 0; l < DirectSound::kListeners; ++l) {
      const auto sound = play(direct, 64, l);
      for (std::size_t i = 0; i < 64; ++i)
        CHECK(sound[i] == (n + i >= kLast && n + i < kLast + kTaps ? 1 : 0));
    }
}

TEST_CASE("a pulse sounds as its samples at the force inlet do, at its point") {
  const auto make_rig = [] {
    auto rig = std::make_unique<Rig>(kRate, free_plate(.32, .2, .005, 1500, 16, 10),
                                     Radiation::kModal); // recoil as well
    rig->options.coupled = false;
    rig->rebuild(false);
    return rig;
  };
  auto struck = make_rig(), pushed = make_rig();
  struck->body.set_striker({.004, .01, 1e6, .3, 3e4, 1, 0, 1}); // milliseconds
  struck->hit({.06, .03, 0}, 1);
  CHECK(!struck->body.model()->solver.touching());
  const Output pulse = struck->run(4096);
  pushed->set_point({.06, .03, 0});
  const Output force = pushed->run(4096, 64, pulse.contact);
  CHECK(pulse.contact[20] > 0); // of 1.1 ms
  CHECK(loudest(std::span(force.left).first(60)) > .05 * loudest(force.left));
  CHECK(apart(force.left, pulse.left) < 4e-3); // what means over samples take of 1500 Hz
}

TEST_CASE("a pressed body stays silent while a listener moves or leaps, or voices are added") {
  const auto both = [](const Output& output) {
    return std::max(loudest(output.left), loudest(output.right));
  };
  Rig rig(kRate, plate(.32, .2, .005, 8000, 16, 10), Radiation::kModal);
  rig.settings.damping = Damping::kLoss;
  rig.settings.loss_factor = 0.05;
  rig.rebuild(false);
  rig.hit({0.03, 0.02, 0}, 1);
  const double loud = both(rig.run(48000));
  const std::vector<float> press(24000, 10.0F);
  for (int i = 0; i < 2; ++i)
    static_cast<void>(rig.run(24000, 64, press));
  double sideways = 0;
  for (const std::size_t moved : {1UL, 0UL, 1UL}) {
    CAPTURE(moved);
    for (int step = 0; step < 12; ++step) { // every 1.3 ms
      rig.settings.listener[moved] = {0.1, sideways += 0.006, 0.3};
      rig.rebuild();
      CHECK(both(rig.run(64, 64, press)) < 1e-5 * loud);
    }
    CHECK(both(rig.run(2048, 64, press)) < 1e-5 * loud);
    ++rig.settings.voices;
    rig.rebuild();
    CHECK(both(rig.run(2048, 64, press)) < 1e-5 * loud);
  }
  for (const Vec3 position : {Vec3{-0.1, 0, 0.06}, Vec3{0.02, 0.02, 0.05}}) { // by leaps
    rig.settings.listener[0] = position;
    rig.rebuild();
    CHECK(both(rig.run(4096, 64, press)) < 1e-3 * loud);
  }
}

TEST_CASE("a diverging force does not silence later strikes") {
  const auto struck = [](Rig& rig) {
    rig.body.set_striker({});
    rig.hit({0.03, 0.02, 0}, 1);
    return loudest(rig.run(2048).left);
  };
  Rig rig(kRate, free_plate(.2, .15, .005, 10000), Radiation::kModal);
  const double before = struck(rig);
  for (const double speed : {1e15, 1e30, 1e200}) {
    CAPTURE(speed);
    rig.body.apply(Reset{});
    static_cast<void>(rig.run(4096));
    rig.body.set_striker({0.007, 0.006, 206e9, 0.29, 1e12, 6, 0, 1});
    rig.hit({0.03, 0.02, 0}, speed);
    static_cast<void>(rig.run(4096));
    CHECK(struck(rig) == approx(before).epsilon(0.1));
  }
}

TEST_CASE("a listener that is added or taken away leaves the direct sound of the others alone") {
  // The first listener hears the same strike to -60 dB of its peak whatever becomes of the rest.
  const auto play = [](std::size_t before, std::size_t after) {
    Rig rig(kRate, free_plate(), Radiation::kModal);
    rig.settings.listeners = before;
    rig.rebuild(false);
    static_cast<void>(rig.run(64));
    rig.hit({0.03, 0.02, 0}, 1);
    auto output = rig.run(12, 12).left; // the strike is on its way
    rig.settings.listeners = after;
    rig.rebuild();
    append(output, rig.run(2048).left);
    return output;
  };
  const auto alone = play(2, 2);
  for (const auto& change : {std::pair<std::size_t, std::size_t>{2, 1}, {1, 2}, {2, 4}}) {
    const std::size_t before = change.first, after = change.second; // captured: no bindings
    CAPTURE(before);
    CAPTURE(after);
    CHECK(apart(alone, play(before, after)) < 1e-3);
  }
}
