// Blows as pulses of closed form, against the coupled contact.
#include "core/modal/contact/pulse.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kPi = std::numbers::pi, kRate = 96000;

/// A free bar of Euler and Bernoulli: cos(b) cosh(b) = 1, f = (b/L)^2 sqrt(E I/(rho A))/(2 pi).
ModalTable bar(double length, double width, double height, double highest) {
  constexpr double kE = 70.3e9, kRho = 2700;
  ModalTable table;
  table.body_name = "bar";
  table.free = true;
  table.material = {"aluminium", kE, 0.33, kRho};
  const double mass = table.mass_kg = kRho * length * width * height;
  table.inertia_kg_m2 = {Vec3{mass / 12 * (width * width + height * height), 0, 0},
                         Vec3{0, mass / 12 * (length * length + height * height), 0},
                         Vec3{0, 0, mass / 12 * (length * length + width * width)}};
  constexpr std::size_t kColumns = 80;
  for (std::size_t i = 0; i <= kColumns; ++i)
    for (const double y : {-0.5, 0.5})
      table.vertex_m.push_back(
          {length * (static_cast<double>(i) / kColumns - 0.5), y * width, height / 2});
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(kColumns); ++i) {
    table.triangle.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    table.triangle.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  for (int n = 1;; ++n) {
    double b = (n + 0.5) * kPi;
    for (int i = 0; i < 5; ++i) // Newton's method
      b -= (std::cos(b) - 1 / std::cosh(b)) / (-std::sin(b) + std::tanh(b) / std::cosh(b));
    const double f =
        b * b / (length * length) * std::sqrt(kE * height * height / (12 * kRho)) / (2 * kPi);
    if (f > highest)
      return table;
    table.frequency_hz.push_back(f);
    table.loss_factor.push_back(1e-3);
    const double sigma = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
    for (const Vec3& v : table.vertex_m) {
      const double x = b * (v.x / length + 0.5);
      // cosh - sigma sinh without the difference of large numbers
      const double grown = 0.5 * std::exp(x) * (1 - sigma) + 0.5 * std::exp(-x) * (1 + sigma);
      table.shape.push_back(0);
      table.shape.push_back(0);
      table.shape.push_back(
          static_cast<float>((grown + std::cos(x) - sigma * std::sin(x)) / std::sqrt(mass)));
    }
  }
}

std::complex<double> amplitude(std::span<const float> sound, std::complex<double> s) {
  std::complex<double> sum = 0, tone = 1;
  double weight = 0;
  const auto pole = std::exp(s / kRate);
  const double step = 2 * kPi / static_cast<double>(sound.size());
  for (std::size_t n = 0; n < sound.size(); ++n) {
    const double window = 0.5 - 0.5 * std::cos(step * static_cast<double>(n)); // Hann's
    sum += static_cast<double>(sound[n]) * window * std::conj(tone);
    weight += std::norm(tone) * window;
    tone = {tone.real() * pole.real() - tone.imag() * pole.imag(),
            tone.real() * pole.imag() + tone.imag() * pole.real()};
  }
  return 2.0 * sum / weight;
}

struct Case {
  const char* name;
  ModalTable table;
  Striker striker;
  double speed;
  Vec3 point;
};

/// Strikers from felt to steel on plates and bars, heavy and light for a single pulse.
std::vector<Case> pulse_cases() {
  const Striker steel{0.0071, 0.006, 206e9, 0.29, 0, 1.5, 0, 1},
      light{0.0003, 0.002, 206e9, 0.29, 0, 1.5, 0, 1},
      dull{0.0071, 0.006, 206e9, 0.29, 0, 1.5, 0, 0.5}, rubber{0.02, 0.01, 2e6, 0.49, 0, 1.5, 0, 1},
      mallet{0.03, 0.012, 5e8, 0.4, 0, 1.5, 0, 1}, felt{0.005, 0.01, 1e6, 0.4, 0, 1.5, 0, 1};
  const Vec3 a{0.06, 0.04, 0};
  return {
      {"thick plate, steel", plate(0.4, 0.3, 0.02, 60000), steel, 1, a},
      {"thick plate, light", plate(0.4, 0.3, 0.02, 60000), light, 1, a},
      {"thick plate, rubber", plate(0.4, 0.3, 0.02, 60000), rubber, 1, a},
      {"thick plate, mallet", plate(0.4, 0.3, 0.02, 60000), mallet, 1, a},
      {"thick plate, dull", plate(0.4, 0.3, 0.02, 60000), dull, 1, a},
      {"plate, steel", plate(0.32, 0.2, 0.005, 40000), steel, 1, a},
      {"plate, light", plate(0.32, 0.2, 0.005, 40000), light, 1, a},
      {"plate, felt", plate(0.32, 0.2, 0.005, 40000), felt, 1, a},
      {"plate, rubber", plate(0.32, 0.2, 0.005, 40000), rubber, 1, a},
      {"bar, steel", bar(0.4, 0.03, 0.01, 60000), steel, 1, {0.06, 0, 0}},
      {"bar, light", bar(0.4, 0.03, 0.01, 60000), light, 1, {0.06, 0, 0}},
      {"bar, mallet", bar(0.4, 0.03, 0.01, 60000), mallet, 1, {0.06, 0, 0}},
      {"bar's end, light", bar(0.4, 0.03, 0.01, 60000), light, 1, {0.19, 0, 0}},
      {"thin plate, heavy",
       plate(0.32, 0.2, 0.0015, 30000),
       {0.03, 0.01, 206e9, 0.29, 0, 1.5, 0, 1},
       1,
       a},
      {"plate, heavy",
       plate(0.32, 0.2, 0.005, 40000),
       {0.1, 0.015, 206e9, 0.29, 0, 1.5, 0, 1},
       1,
       a},
      {"bar, heavy",
       bar(0.4, 0.03, 0.01, 60000),
       {0.1, 0.015, 206e9, 0.29, 0, 1.5, 0, 1},
       1,
       {0.06, 0, 0}},
      {"bar, felt", bar(0.4, 0.03, 0.01, 60000), felt, 1, {0.06, 0, 0}},
  };
}

} // namespace

TEST_CASE("a pulse sounds within 1 dB of the coupled strike below half its inverse duration" *
          doctest::skip(kSanitized)) {
  for (const Case& each : pulse_cases()) {
    const auto play = [&](bool coupled) {
      Rig rig(kRate, each.table);
      rig.settings.listener[0] = {0.033, 0.021, 0.1};
      rig.rebuild(false);
      rig.options.coupled = coupled;
      rig.body.set_striker(each.striker);
      rig.hit(each.point, each.speed);
      return std::pair(rig.run(48000), rig.body.model()->rate);
    };
    const auto [coupled, rates] = play(true);
    const auto pulse = play(false).first;
    const auto lasts = [](const Output& output) {
      std::size_t end = 0;
      for (std::size_t n = 0; n < 24000; ++n)
        if (output.contact[n] > 0)
          end = n + 1;
      return static_cast<double>(end) / kRate;
    };
    const double duration = lasts(pulse), end = lasts(coupled);
    double worst = 0, at = 0;
    const auto from = static_cast<std::size_t>(kRate * (std::max(end, duration))) + 10;
    for (const auto& s : rates) {
      const double f = s.imag() / (2 * kPi);
      const double x = std::abs(amplitude(std::span(coupled.left).subspan(from, 40000), s));
      const double y = std::abs(amplitude(std::span(pulse.left).subspan(from, 40000), s));
      if (f > 0.5 / duration || x < 1e-6)
        continue;
      const double db = 20 * std::log10(y / x);
      if (std::abs(db) > std::abs(worst)) {
        worst = db;
        at = f;
      }
    }
    const double impulses = 20 * std::log10(impulse(pulse, kRate) / impulse(coupled, kRate));
    CAPTURE(std::string(each.name));
    CAPTURE(at);
    CHECK(std::abs(impulses) < 0.5);
    CHECK(std::abs(worst) < 1);
  }
}

TEST_CASE("a pulse is Hertz' own on a rigid wall, and follows momentum on a free mass") {
  const tactus::contact::ImpactLaw law{6.032e9, 1.5, 0};
  const double m = 7.103e-3, v = 1.4007;
  const Pulse wall = find_pulse(law, m, v, 1, {});
  CHECK(std::abs((wall.impulse_n_s) / (19.90e-3) - 1) < 1e-3); // the disk's reference strike
  CHECK(std::abs((wall.duration_s) / (50.9e-6) - 1) < 2e-3);
  CHECK(std::abs((find_pulse(law, m, v, 0.5, {}).impulse_n_s) / (0.75 * 19.90e-3) - 1) < 1e-3);
  const Pulse free = find_pulse(law, m, v, 1, {{}, {}, 1 / 0.2544, 0});
  CHECK(std::abs((free.impulse_n_s) / (2 * v / (1 / m + 1 / 0.2544)) - 1) < 1e-9);
  CHECK(free.mass_ratio == approx(m / 0.2544));
  // A slow mode is a mass, a fast one a spring behind the contact.
  const std::complex<double> slow{0, 1}, fast{0, 1e7};
  const double b = 1;
  CHECK(std::abs((find_pulse(law, m, v, 1, {{&b, 1}, {&slow, 1}, 0, 0}).impulse_n_s) /
                     (2 * v / (1 / m + 1)) -
                 1) < 1e-6);
  CHECK(std::abs((find_pulse(law, m, v, 1, {{&b, 1}, {&fast, 1}, 0, 0}).impulse_n_s) /
                     (wall.impulse_n_s) -
                 1) < 1e-4);
  // Nearly all of the way is a spring of 1e5 N/m: half its period.
  CHECK(std::abs((find_pulse(law, m, v, 1, {{}, {}, 0, 1e-5}).duration_s) /
                     (kPi * std::sqrt(m * 1e-5)) -
                 1) < 0.01);
}
