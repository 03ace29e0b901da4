#include "tests/approx.hpp"
#include "tests/core/haptic/network/network_rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace tactus::haptic;
using tactus::Vec3;
using tactus::test::approx;

namespace {

/// Integrates the equations of docs/theory/network.md by the classical Runge-Kutta method of fourth
/// order, independently of the model.
class Reference {
public:
  explicit Reference(const Network& network) : network_(network) {
    for (const NetworkMass& mass : network.masses)
      x_.push_back(mass.position);
    v_.resize(x_.size());
  }
  void advance(double seconds, int steps) {
    const double h = seconds / steps;
    for (int n = 0; n < steps; ++n) {
      const auto x = x_, v = v_;
      const auto a1 = acceleration(x, v);
      const auto x2 = plus(x, v, h / 2), v2 = plus(v, a1, h / 2);
      const auto a2 = acceleration(x2, v2);
      const auto x3 = plus(x, v2, h / 2), v3 = plus(v, a2, h / 2);
      const auto a3 = acceleration(x3, v3);
      const auto x4 = plus(x, v3, h), v4 = plus(v, a3, h);
      const auto a4 = acceleration(x4, v4);
      for (std::size_t i = 0; i < x.size(); ++i) {
        x_[i] += (v[i] + v2[i] * 2 + v3[i] * 2 + v4[i]) * (h / 6);
        v_[i] += (a1[i] + a2[i] * 2 + a3[i] * 2 + a4[i]) * (h / 6);
      }
    }
  }
  [[nodiscard]] const Vec3& position(std::size_t mass) const { return x_[mass]; }

private:
  using Vectors = std::vector<Vec3>;
  static Vectors plus(const Vectors& a, const Vectors& b, double share) {
    Vectors sum = a;
    for (std::size_t i = 0; i < a.size(); ++i)
      sum[i] += b[i] * share;
    return sum;
  }
  Vectors acceleration(const Vectors& x, const Vectors& v) const {
    Vectors a(x.size(), network_.gravity);
    for (std::size_t i = 0; i < x.size(); ++i)
      a[i] -= v[i] * network_.drag_per_s;
    for (const NetworkLink& link : network_.links) {
      const Vec3 d = x[link.b] - x[link.a], w = v[link.b] - v[link.a];
      const double length = norm(d), stretch = length - link.rest_length_m;
      using Kind = NetworkLink::Kind;
      if ((link.kind == Kind::kPull && stretch < 0) || (link.kind == Kind::kPush && stretch > 0))
        continue;
      const Vec3 n = d * (1 / length);
      const double stretching = dot(w, n); // m/s
      const Vec3 force =
          n * (link.stiffness_n_per_m * stretch + link.damping_n_s_per_m * stretching) +
          (w - n * stretching) * link.transverse_damping_n_s_per_m;
      a[link.a] += force * (1 / network_.masses[link.a].mass_kg);
      a[link.b] -= force * (1 / network_.masses[link.b].mass_kg);
    }
    for (std::size_t i = 0; i < a.size(); ++i)
      if (network_.masses[i].fixed)
        a[i] = {};
    return a;
  }

  const Network& network_;
  Vectors x_, v_;
};

/// A crumpled lattice far from rest: large rotations, springs with a rest length, a cable, gravity.
void build(test::NetworkRig& rig, double damping) {
  rig.network.gravity = {0, -9.81, 2};
  rig.network.drag_per_s = damping > 0 ? 3 : 0;
  for (int i = 0; i < 8; ++i)
    rig.mass(0.002 + 0.001 * i,
             {0.02 * (i % 4), 0.015 * (i / 4) + 0.003 * (i % 3), 0.004 * (i % 5)});
  rig.network.masses[0].fixed = rig.network.masses[3].fixed = true;
  constexpr std::size_t kLinks[][2] = {{0, 1}, {1, 2}, {2, 3}, {4, 5}, {5, 6}, {6, 7},
                                       {0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 5}, {2, 7}};
  for (const auto& [a, b] : kLinks) {
    rig.link(a, b, 150 + 20 * static_cast<double>(a + b), 0.015, damping);
    rig.network.links.back().transverse_damping_n_s_per_m = 0.5 * damping;
  }
  rig.network.links.back().kind = NetworkLink::Kind::kPull;
}

/// Largest distance of a mass from the reference after 40 ms of steps at rate_hz, m.
double error_at(double rate_hz, double damping) {
  test::NetworkRig rig;
  build(rig, damping);
  rig.network.rate_hz = rate_hz;
  rig.publish();
  rig.tick_for(0.04);
  Reference reference(rig.network);
  // The model is at rest half a step before its first position.
  reference.advance(0.04 + 0.5 / rate_hz, 8000);
  double largest = 0;
  for (std::size_t i = 0; i < rig.network.masses.size(); ++i)
    largest = std::max(largest, norm(rig.model.position(i) - reference.position(i)));
  return largest;
}

} // namespace

TEST_CASE("a lattice far from rest converges to the reference with the second order of the step, "
          "with dampers and drag with the first") {
  const double coarse = error_at(12000, 0), middle = error_at(24000, 0), fine = error_at(48000, 0);
  CHECK(fine < 1e-6);
  CHECK(coarse / middle == approx(4).epsilon(0.15));
  CHECK(middle / fine == approx(4).epsilon(0.15));
  const double damped = error_at(48000, 0.1);
  CHECK(damped < 2e-5);
  CHECK(error_at(24000, 0.1) / damped == approx(2).epsilon(0.2));
}
