// The direct sound of pulses is that of their force; a rub goes on through a retuning.
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

TEST_CASE("a pulse sounds as its samples at the force inlet do, at its point") {
  const auto make_rig = [] {
    ModalTable table = plate(.32, .2, .005, 1500, 16, 10);
    table.free = true; // recoil as well
    table.inertia_kg_m2 = {Vec3{3e-3, 0, 0}, Vec3{0, 7e-3, 0}, Vec3{0, 0, 1e-2}};
    auto rig = std::make_unique<Rig>(48000, std::move(table));
    rig->settings.radiation = Radiation::kModal;
    rig->options.coupled = false;
    rig->rebuild(false);
    return rig;
  };
  auto struck = make_rig();
  struck->body.set_striker({.004, .01, 1e6, .3, 3e4, 1, 0, 1}); // milliseconds
  struck->hit({.06, .03, 0}, 1);
  CHECK(!struck->body.model()->solver.touching());
  const Output pulse = struck->run(4096);
  CHECK(*std::max_element(pulse.contact.begin(), pulse.contact.end()) > 0);
  auto pushed = make_rig();
  const SurfacePoint point = pushed->body.model()->nearest({.06, .03, 0});
  pushed->body.set_point(point, point.normal);
  const Output force = pushed->run(4096, 64, pulse.contact);
  float loudest = 0, apart = 0, early = 0;
  for (std::size_t n = 0; n < 4096; ++n) {
    loudest = std::max(loudest, std::abs(force.left[n]));
    apart = std::max(apart, std::abs(pulse.left[n] - force.left[n]));
    if (n < 400 && pulse.contact[n] > 0)
      early = std::max(early, std::abs(force.left[n]));
  }
  CHECK(early > .05F * loudest);
  CHECK(apart < 4e-3F * loudest); // what means over samples take of 1500 Hz
}

TEST_CASE("friction continues through a retuning as if there had been none") {
  const auto play = [](bool replaced) {
    Rig rig(48000, plate(.32, .2, .005, 5000, 16, 10));
    Rub rub;
    rub.placed = true;
    rub.point = rig.body.model()->nearest({.05, .03, 0});
    rub.direction = {1, 0, 0};
    rub.law.stiffness_n_per_m = 1e4;
    rig.body.set_rub(rub);
    std::array<std::vector<float>, 6> s;
    for (auto& x : s)
      x.assign(64, 0);
    std::fill(s[2].begin(), s[2].end(), 2.F);  // N
    std::fill(s[3].begin(), s[3].end(), .05F); // m/s
    std::vector<float> friction;
    for (int block = 0; block < 40; ++block) {
      if (replaced && block == 20) {
        rig.rebuild();
        CHECK(rig.body.contacts() == 1);
      }
      const std::array<std::span<float>, 2> out{s[0], s[1]};
      std::vector<float> zero(64, 0), contact(64, 0);
      rig.body.process<float>(zero, zero, out, contact,
                              {std::span<const float>(s[2]), std::span<const float>(s[3]), s[4]});
      friction.insert(friction.end(), s[4].begin(), s[4].end());
    }
    return friction;
  };
  const auto plain = play(false), replaced = play(true);
  float maximum = 0, apart = 0;
  for (std::size_t n = 0; n < plain.size(); ++n) {
    maximum = std::max(maximum, std::abs(plain[n]));
    apart = std::max(apart, std::abs(plain[n] - replaced[n]));
  }
  CHECK(maximum > .2F);
  CHECK(apart < 2e-3F * maximum);
}
