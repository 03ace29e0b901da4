// Boundary elements and outgoing waves against the closed forms of spheres.
#include "fem/radiation/spherical_waves.hpp"

#include <chrono>
#include <doctest/doctest.h>
#include <numbers>

using namespace tactus::fem;

namespace {

constexpr double kAir = 1.184, kSpeed = 346.1, kRadius = .05;

/// An icosahedron, every triangle split in four `times` times, on the sphere.
AcousticSkin ball(int times) {
  const double t = (1 + std::sqrt(5.0)) / 2;
  AcousticSkin s{{{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0}, {0, -1, t}, {0, 1, t},
                  {0, -1, -t}, {0, 1, -t}, {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}},
                 {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}}};
  const auto round = [&] {
    for (Vector3& v : s.vertex)
      v = (kRadius / length(v)) * v;
  };
  round();
  for (int k = 0; k < times; ++k) {
    s = with_triangles(s, 4 * s.triangle.size());
    round();
  }
  return s;
}

/// P_l of the polar angle's cosine as velocity along the normal.
double legendre(int l, double x) {
  return l == 0 ? 1 : l == 2 ? (3 * x * x - 1) / 2 : (5 * x * x * x - 3 * x) / 2;
}

std::vector<double> flow_of(const AcousticSkin& fine, const AcousticSkin& coarse, int l) {
  std::vector<Vector3> v;
  for (const Vector3& x : fine.vertex)
    v.push_back(legendre(l, x.z / length(x)) / length(x) * x);
  return FlowTransfer(fine, coarse)(v);
}

/// p(r) = -j rho c h_l(kr)/h_l'(ka) P_l for v_n = P_l.
Complex exact(int l, double k, const Vector3& x) {
  const auto degree = static_cast<std::size_t>(l);
  const auto at = spherical_hankel(degree + 1, k * kRadius);
  const Complex slope = static_cast<double>(l) / (k * kRadius) * at[degree] - at[degree + 1];
  return Complex(0, -kAir * kSpeed) * spherical_hankel(degree, k * length(x))[degree] / slope *
         legendre(l, x.z / length(x));
}

double decibels(Complex a, Complex b) { return 20 * std::log10(std::abs(a) / std::abs(b)); }

} // namespace

TEST_CASE("spheres that pulsate and flex radiate as their closed form, at resonances inside too") {
  const AcousticSkin skin = ball(3);
  const ExteriorField field(skin);
  const double inner_resonance = kSpeed / (2 * kRadius); // k a = pi: sin(ka) = 0
  for (const auto& [f, l] : {std::pair(300.0, 0), {1000.0, 0}, {6000.0, 2}, {inner_resonance, 0},
                             {2 * inner_resonance, 0}, {12000.0, 3}}) {
    const double k = 2 * std::numbers::pi * f / kSpeed;
    const auto begin = std::chrono::steady_clock::now();
    const auto mu = field.solve(k, flow_of(skin, skin, l), 1, kAir, kSpeed);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    double worst = 0;
    for (const Vector3& x : {Vector3{0, 0, .5}, {.2, .1, .4}, {.01, .02, .08}})
      worst = std::max(worst, std::abs(decibels(field.pressure(k, mu, x), exact(l, k, x))));
    MESSAGE("l = " << l << ", " << f << " Hz: " << worst << " dB, " << seconds << " s");
    CHECK(worst < .3);
  }
}
