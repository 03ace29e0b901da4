// Blows as pulses of closed form, against the coupled contact.
#include "core/modal/contact/pulse.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kFast = 96000;
constexpr Striker kSteel{0.0071, 0.006, 206e9, 0.29, 0, 1.5, 0, 1},
    kLight{0.0003, 0.002, 206e9, 0.29, 0, 1.5, 0, 1},
    kDull{0.0071, 0.006, 206e9, 0.29, 0, 1.5, 0, 0.5}, kRubber{0.02, 0.01, 2e6, 0.49, 0, 1.5, 0, 1},
    kMallet{0.03, 0.012, 5e8, 0.4, 0, 1.5, 0, 1}, kFelt{0.005, 0.01, 1e6, 0.4, 0, 1.5, 0, 1},
    kHeavy{0.1, 0.015, 206e9, 0.29, 0, 1.5, 0, 1};

/// The sound of a pulse is within 1 dB of the coupled strike's below half its inverse duration, its
/// impulse within half a dB.
void check_pulse(const std::string& body, const Striker& striker, double x = 0.06) {
  CAPTURE(body);
  CAPTURE(striker.mass_kg);
  CAPTURE(striker.youngs_modulus_pa);
  const ModalTable table = body == "bar"           ? free_bar(0.4, 0.03, 0.01, 60000)
                           : body == "thick plate" ? plate(0.4, 0.3, 0.02, 60000)
                           : body == "plate"       ? plate(0.32, 0.2, 0.005, 40000)
                                                   : plate(0.32, 0.2, 0.0015, 30000);
  const auto play = [&](bool coupled) {
    Rig rig(kFast, table);
    rig.settings.listener[0] = {0.033, 0.021, 0.1};
    rig.rebuild(false);
    rig.options.coupled = coupled;
    rig.body.set_striker(striker);
    rig.hit({x, body == "bar" ? 0 : 0.04, 0}, 1);
    return std::pair(rig.run(48000), rig.body.model()->rate);
  };
  const auto [coupled, rates] = play(true);
  const auto pulse = play(false).first;
  const auto lasts = [](const Output& output) { // samples
    const auto last = std::find_if(output.contact.rbegin() + 24000, output.contact.rend(),
                                   [](float force) { return force > 0; });
    return static_cast<std::size_t>(output.contact.rend() - last);
  };
  const double highest = 0.5 * kFast / static_cast<double>(lasts(pulse));
  const std::size_t from = std::max(lasts(coupled), lasts(pulse)) + 10;
  CHECK(std::abs(20 * std::log10(impulse(pulse) / impulse(coupled))) < 0.5);
  for (const Complex& s : rates) {
    const double hz = s.imag() / (2 * kPi);
    if (hz > highest)
      continue;
    const auto level = [&](const Output& output) {
      return abs(amplitude(std::span(output.left).subspan(from, 40000), s, kFast));
    };
    CAPTURE(hz);
    if (level(coupled) > 1e-6)
      CHECK(std::abs(20 * std::log10(level(pulse) / level(coupled))) < 1);
  }
}

} // namespace

TEST_CASE("a pulse sounds as the coupled strike, light or soft, on a plate and a bar's end") {
  check_pulse("plate", kFelt);
  check_pulse("bar", kLight, 0.19);
}

TEST_CASE("a pulse sounds as the coupled strike, from felt to steel, on plates and bars" *
          doctest::test_suite("slow")) {
  for (const Striker& striker : {kSteel, kLight, kRubber, kMallet, kDull})
    check_pulse("thick plate", striker);
  for (const Striker& striker : {kSteel, kLight, kFelt, kRubber, kHeavy})
    check_pulse("plate", striker);
  for (const Striker& striker : {kSteel, kLight, kMallet, kHeavy, kFelt})
    check_pulse("bar", striker);
  check_pulse("thin plate", {0.03, 0.01, 206e9, 0.29, 0, 1.5, 0, 1});
}

TEST_CASE("a pulse is Hertz' own on a rigid wall, and follows momentum on a free mass") {
  const tactus::contact::ImpactLaw law{6.032e9, 1.5, 0};
  const double m = 7.103e-3, v = 1.4007;
  const Pulse wall = find_pulse(law, m, v, 1, {});
  CHECK(wall.impulse_n_s == approx(19.90e-3).epsilon(1e-3)); // the disk's reference strike
  CHECK(wall.duration_s == approx(50.9e-6).epsilon(2e-3));
  CHECK(find_pulse(law, m, v, 0.5, {}).impulse_n_s == approx(0.75 * 19.90e-3).epsilon(1e-3));
  const Pulse free = find_pulse(law, m, v, 1, {{}, {}, 1 / 0.2544, 0});
  CHECK(free.impulse_n_s == approx(2 * v / (1 / m + 1 / 0.2544)).epsilon(1e-9));
  CHECK(free.mass_ratio == approx(m / 0.2544));
  // A slow mode is a mass, a fast one a spring behind the contact.
  const Complex slow{0, 1}, fast{0, 1e7};
  const double b = 1;
  CHECK(find_pulse(law, m, v, 1, {{&b, 1}, {&slow, 1}, 0, 0}).impulse_n_s ==
        approx(2 * v / (1 / m + 1)).epsilon(1e-6));
  CHECK(find_pulse(law, m, v, 1, {{&b, 1}, {&fast, 1}, 0, 0}).impulse_n_s ==
        approx(wall.impulse_n_s).epsilon(1e-4));
  // Nearly all of the way is a spring of 1e5 N/m: half its period.
  CHECK(find_pulse(law, m, v, 1, {{}, {}, 0, 1e-5}).duration_s ==
        approx(kPi * std::sqrt(m * 1e-5)).epsilon(0.01));
}
