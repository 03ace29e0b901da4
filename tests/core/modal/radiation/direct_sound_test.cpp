#include "core/modal/radiation/direct_sound.hpp"
#include "core/modal/radiation/multipole.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

using namespace tactus::modal;
using namespace tactus::test;
using Complex = std::complex<double>;

namespace {

constexpr double kPi = std::numbers::pi;

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
Complex mode_response(Complex s, Complex mode) {
  return s * s / ((s - mode) * (s - std::conj(mode)));
}

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
    const Complex z = std::polar(1.0, -2 * kPi * frequency / sample_rate);
    Complex sum = 0, power = 1;
    for (const float tap : samples) {
      sum += static_cast<double>(tap) * power;
      power *= z;
    }
    const Complex p = std::exp(mode / sample_rate), w = weight() / sample_rate;
    return sum + (w / (1.0 - p * z) - std::conj(w) / (1.0 - std::conj(p) * z)) / Complex(0, 2);
  }
  double sample_rate;
  Complex mode;
  DirectKernels kernels;
  std::vector<float> samples, moments;
};

} // namespace

TEST_CASE("a pushed mode sounds as its acceleration, slow or fast, at the listener's delay") {
  // 0.05 dB, and what the band limit lets alias.
  for (const double rate : {44100.0, 48000.0, 96000.0})
    for (const double frequency : {150.0, 3000.0, 18500.0})
      for (const double decay : {1.0, 300.0, 6000.0})
        for (const double delay : {0.0, 13.37, 90.5}) {
          if (decay > 3 * frequency)
            continue;
          const OneMode one(frequency, decay, rate, delay);
          const double floor = rate < 47000 ? 3e-4 : 6e-5;
          for (double f = 20; f < 20000; f *= 1.1) {
            const Complex s(0, 2 * kPi * f);
            const Complex true_level =
                mode_response(s, one.mode) * std::exp(-s * (delay + BandLimit::kLatency) / rate);
            const Complex computed = one.sampled(f);
            CAPTURE(rate);
            CAPTURE(frequency);
            CAPTURE(decay);
            CAPTURE(delay);
            CAPTURE(f);
            CHECK(std::abs(computed - true_level) < 0.006 * std::abs(true_level) + floor);
          }
          CHECK(std::abs(one.sampled(0)) < 3e-6);
        }
}

TEST_CASE(
    "a mode that decays within the arrivals is in the kernel alone, and all weights are bounded") {
  for (const double decay : {10.0, 100.0, 1000.0, 3000.0, 10000.0, 30000.0}) {
    const OneMode one(6000, decay, 48000, 60);
    const double spread = 60 + 1 + BandLimit::kLength;
    const bool short_lived = decay / 48000 * spread > DirectKernels::kMaxDecay;
    CHECK((one.weight() == 0.0) == short_lived);
    // The acceleration's own size, and what decays within the arrivals.
    CHECK(std::abs(one.weight()) < 2 * kPi * 6000 * 1.1 * std::exp(DirectKernels::kMaxDecay));
    CHECK(one.kernels.taps() <= DirectKernels::kMaxTaps);
  }
}

TEST_CASE("a mode too high for the bank follows the force below it") {
  const OneMode one(50000, 30, 48000, 5, DirectKernels::Mode::Part::kTooHigh);
  for (double f = 100; f < 20000; f *= 1.2) {
    const Complex s(0, 2 * kPi * f);
    CAPTURE(f);
    const Complex late = std::exp(-s * (5.0 + BandLimit::kLatency) / 48000.0);
    const Complex true_level = mode_response(s, one.mode) * late;
    CHECK(std::abs(std::abs(one.sampled(f)) - std::abs(true_level)) <
          0.012 * std::abs(true_level) + 3e-5);
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
      z *= std::exp(rate);
      for (std::size_t i = 0; i < (n < 3 ? kFine : 0); ++i) {
        const double v = 1 - (static_cast<double>(i) + 0.5) / kFine, x = 2 * v - 1;
        const double part = force(static_cast<double>(n) + 1 - v) / kFine;
        f[0] += part;
        f[1] += part * x;
        f[2] += part * (1.5 * x * x - 0.5);
        z += part * std::exp(rate * v);
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
        computed += output[n] * std::exp(-s * (static_cast<double>(n) + 1) / 48000.0);
      for (std::size_t i = 0; i < 10000; ++i) {
        const double t = (static_cast<double>(i) + 0.5) * kLast / 10000;
        transform += force(t) * std::exp(-s * t / 48000.0) * kLast / 10000.0;
      }
      const Complex true_level = mode_response(s, one.mode) * transform *
                                 std::exp(-s * (7.3 + BandLimit::kLatency) / 48000.0);
      CAPTURE(hz);
      CHECK(std::abs(computed - true_level) <
            0.012 * std::abs(true_level) + 5e-4 * std::abs(transform));
    }
  }
}

TEST_CASE("multipoles known at one frequency sound at every other as a sphere does") {
  const double a = 0.05, c = 346.1, air = 1.184, f = 2000;
  ModalTable table;
  table.frequency_hz = {f, f, f};
  MultipoleTable& m = table.multipoles;
  m.highest_degree = {0, 1, 0};
  m.offset = {0, 1, 5, 6};
  m.scales = {1};
  m.reference_radius_m = a;
  m.coefficients.assign(6, 0);
  // Pressure on the sphere for unit normal velocity 1 and cos(theta): rho c x j h/h', h outgoing.
  const auto breathing = [&](double w, double r) { // per acceleration, delay from the sphere out
    return air * a * a / r / Complex(1, w * a / c);
  };
  const auto swinging = [&](double w, double r) {
    const double x = w * a / c, y = w * r / c;
    return air * a * a * a / (r * r) * Complex(1, y) / Complex(2 - x * x, 2 * x);
  };
  const double omega = 2 * kPi * f;
  const Complex j(0, 1);
  m.coefficients[0] = Complex(j * omega * breathing(omega, a) / std::sqrt(1 / (4 * kPi)));
  m.coefficients[3] = Complex(j * omega * swinging(omega, a) / std::sqrt(3 / (4 * kPi)));
  // No sphere: its velocity is not in phase. Known at its own frequency alone.
  const Complex turned(0.6, 0.8);
  m.coefficients[5] = m.coefficients[0] * std::complex<float>(turned);
  const std::array<double, 3> rates{omega, omega, omega};
  RadiatingSurface::Scene scene;
  for (const double r : {0.06, 0.2, 1.0}) {
    const std::array<RigidDipole, 3> ball{RigidDipole{{1, 0, 0}, a}, RigidDipole{{0, 1, 0}, a},
                                          RigidDipole{{0, 0, 1}, a}};
    const auto arrivals = multipole_arrivals(table, rates, {0, 0, r}, scene, ball, 4.0);
    CHECK(arrivals->delay_s == approx(std::max((r - a) / c - BandLimit::kLatency / 48000.0, 0.0)));
    std::vector<double> pressure(arrivals->samples() * BandLimit::kNodes);
    for (const std::size_t motion : {0U, 1U, 2U, 5U}) { // the last one: recoil along z
      arrivals->find(motion, pressure);
      for (const double hz : {30.0, 300.0, 1000.0, 2000.0, 6000.0, 18000.0}) {
        Complex sum = 0;
        for (std::size_t n = 0; n < arrivals->samples(); ++n)
          for (std::size_t k = 0; k < BandLimit::kGauss; ++k)
            sum += BandLimit::kGaussWeight[k] * pressure[n * BandLimit::kNodes + 1 + k] *
                   std::polar(1.0, -2 * kPi * hz / 48000 *
                                       (static_cast<double>(n) + BandLimit::kNode[1 + k] -
                                        BandLimit::kLatency));
        const double w = 2 * kPi * hz;
        if (motion == 2 && hz != 2000)
          continue;
        const Complex exact = motion == 0   ? breathing(w, r)
                              : motion == 2 ? turned * breathing(w, r)
                              : motion == 1 ? swinging(w, r)
                                            : swinging(w, r) / 2.0; // 1/sqrt(4 kg)
        CHECK(std::abs(sum / exact - 1.0) < 0.01);
      }
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

TEST_CASE("the sound of forces is the same to the bit however it is cut into blocks") {
  const auto play = [](std::size_t block) {
    Rig rig;
    rig.settings.radiation = Radiation::kModal;
    rig.loaded = [] {
      ModalTable free = plate(0.2, 0.15, 0.005, 30000);
      free.free = true;
      free.inertia_kg_m2 = {Vec3{1e-3, 0, 0}, Vec3{0, 1e-3, 0}, Vec3{0, 0, 2e-3}};
      return std::make_shared<const LoadedTable>(std::move(free));
    }();
    rig.rebuild(false);
    static_cast<void>(rig.run(64, block));
    rig.hit({0.03, 0.02, 0}, 1);
    std::vector<float> force(4096);
    for (std::size_t n = 700; n < 2000; ++n)
      force[n] = static_cast<float>(std::sin(0.01 * static_cast<double>(n)));
    return rig.run(4096, block, force).left;
  };
  const auto whole = play(4096);
  CHECK(*std::max_element(whole.begin(), whole.end()) > 0);
  CHECK(whole == play(64));
  CHECK(whole == play(17));
}

TEST_CASE("a body under a constant force stays silent while its listener and its size change") {
  Rig rig;
  rig.settings.radiation = Radiation::kModal;
  rig.settings.damping = Damping::kLoss;
  rig.settings.loss_factor = 0.05;
  rig.rebuild(false);
  rig.hit({0.03, 0.02, 0}, 1);
  const auto strike = rig.run(48000).left;
  const double loud = static_cast<double>(*std::max_element(strike.begin(), strike.end()));
  const std::vector<float> press(24000, 10.0F);
  static_cast<void>(rig.run(24000, 64, press));
  static_cast<void>(rig.run(24000, 64, press));
  for (const Vec3 position : {Vec3{0.1, 0.1, 0.3}, Vec3{-0.1, 0, 0.06}, Vec3{0.02, 0.02, 0.05}}) {
    rig.settings.listener[0] = position;
    rig.rebuild();
    for (const float x : rig.run(8192, 64, press).left)
      CHECK(std::abs(static_cast<double>(x)) < 1e-3 * loud);
  }
}

TEST_CASE("a pressed body stays silent everywhere while one listener moves, or voices are added" *
          doctest::skip(kSanitized)) {
  const auto largest = [](const Output& output) {
    double maximum = 0;
    for (const std::vector<float>* const side : {&output.left, &output.right})
      for (const float x : *side)
        maximum = std::max(maximum, std::abs(static_cast<double>(x)));
    return maximum;
  };
  Rig rig;
  rig.settings.radiation = Radiation::kModal;
  rig.settings.damping = Damping::kLoss;
  rig.settings.loss_factor = 0.05;
  rig.rebuild(false);
  rig.hit({0.03, 0.02, 0}, 1);
  const double loud = largest(rig.run(48000));
  const std::vector<float> press(24000, 10.0F);
  static_cast<void>(rig.run(24000, 64, press));
  static_cast<void>(rig.run(24000, 64, press));
  double sideways = 0;
  for (const std::size_t moved : {1UL, 0UL, 1UL}) {
    CAPTURE(moved);
    for (int step = 0; step < 40; ++step) { // every 1.3 ms
      rig.settings.listener[moved] = {0.1, sideways += 0.002, 0.3};
      rig.rebuild();
      CHECK(largest(rig.run(64, 64, press)) < 1e-5 * loud);
    }
    CHECK(largest(rig.run(8192, 64, press)) < 1e-5 * loud);
    ++rig.settings.voices;
    rig.rebuild();
    CHECK(largest(rig.run(8192, 64, press)) < 1e-5 * loud);
  }
}

TEST_CASE("a diverging force does not silence later strikes") {
  const auto free_plate = [] {
    ModalTable free = plate(0.2, 0.15, 0.005, 10000);
    free.free = true;
    free.inertia_kg_m2 = {Vec3{1e-3, 0, 0}, Vec3{0, 1e-3, 0}, Vec3{0, 0, 2e-3}};
    return free;
  };
  const auto loudest = [](Rig& rig) {
    rig.body.set_striker({});
    rig.hit({0.03, 0.02, 0}, 1);
    const auto output = rig.run(2048).left;
    return static_cast<double>(*std::max_element(output.begin(), output.end()));
  };
  Rig rig(48000, free_plate());
  rig.settings.radiation = Radiation::kModal;
  rig.rebuild(false);
  const double before = loudest(rig);
  for (const double speed : {1e15, 1e30, 1e200}) {
    CAPTURE(speed);
    rig.body.reset();
    static_cast<void>(rig.run(4096));
    rig.body.set_striker({0.007, 0.006, 206e9, 0.29, 1e12, 6, 0, 1});
    rig.hit({0.03, 0.02, 0}, speed);
    static_cast<void>(rig.run(4096));
    CHECK(loudest(rig) == approx(before).epsilon(0.1));
  }
}

TEST_CASE("a listener that is added or taken away leaves the direct sound of the others alone") {
  // The first listener hears the same strike to -60 dB of its peak whatever becomes of the rest.
  const auto play = [](std::size_t before, std::size_t after) {
    ModalTable free = plate(0.2, 0.15, 0.005, 30000);
    free.free = true;
    free.inertia_kg_m2 = {Vec3{1e-3, 0, 0}, Vec3{0, 1e-3, 0}, Vec3{0, 0, 2e-3}};
    Rig rig(48000, std::move(free));
    rig.settings.radiation = Radiation::kModal;
    rig.settings.listeners = before;
    rig.rebuild(false);
    static_cast<void>(rig.run(64));
    rig.hit({0.03, 0.02, 0}, 1);
    auto output = rig.run(12, 12).left; // the strike is on its way
    rig.settings.listeners = after;
    rig.rebuild();
    const auto rest = rig.run(2048).left;
    output.insert(output.end(), rest.begin(), rest.end());
    return output;
  };
  const auto alone = play(2, 2);
  float loudest = 0;
  for (const float x : alone)
    loudest = std::max(loudest, std::abs(x));
  CHECK(loudest > 0);
  for (const auto& change : {std::pair<std::size_t, std::size_t>{2, 1}, {1, 2}, {2, 4}}) {
    const std::size_t before = change.first, after = change.second; // captured: no bindings
    CAPTURE(before);
    CAPTURE(after);
    const auto changed = play(before, after);
    float difference = 0;
    for (std::size_t n = 0; n < alone.size(); ++n)
      difference = std::max(difference, std::abs(changed[n] - alone[n]));
    CHECK(difference < 1e-3F * loudest);
  }
}
