#include "tests/core/haptic/approx.hpp"
#include "tests/core/haptic/network/network_rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::haptic;
using test::approx;
using test::NetworkRig;
using Order = NetworkModel::Action;

TEST_CASE("a spring at its force limit stores the work of the hand that stretched it") {
  // k up to F = 40 N, then F: k x^2/2, and F x - F^2/(2k) beyond. The mass is
  // too heavy to move: by 40 N t^2/2M = 2e-8 m in a second.
  constexpr double k = 2000, kMax_n = NetworkModel::kMaxHandle_n;
  for (const bool pressed : {false, true}) {
    NetworkRig rig;
    rig.mass(1e9, {});
    (pressed ? rig.network.touch.stiffness_n_per_m : rig.network.grab.stiffness_n_per_m) = k;
    rig.network.touch.radius_m = 0.1;
    rig.publish();
    const double start = pressed ? 0.11 : 0.0; // the sphere begins beside the mass
    rig.tick({0, 0, start});
    if (!pressed)
      rig.model.queue_action({Order::Kind::kGrab, rig.key(0), {}, 0});
    rig.tick_for(2 * NetworkModel::kContactRamp_s, {0, 0, start});
    double work_j = 0, z = start;
    for (int n = 1; n <= 600; ++n) {
      const double extent = 1e-4 * n, next = pressed ? 0.1 - extent : extent;
      const double felt = rig.tick({0, 0, next}).z;
      work_j -= felt * (next - z);
      z = next;
      const double theory =
          k * extent <= kMax_n ? 0.5 * k * extent * extent : kMax_n * (extent - 0.5 * kMax_n / k);
      CAPTURE(pressed);
      CAPTURE(extent);
      // The energy is that of half a step before, 1/96 ms: 1e-6 m of 0.1 m/s.
      CHECK(rig.model.energy_j() == approx(theory).epsilon(1e-9).scale(kMax_n * 3e-6 / 1e-9));
      CHECK(work_j == approx(theory).epsilon(1e-9).scale(kMax_n * 1.2e-4 / 1e-9));
    }
  }
}
