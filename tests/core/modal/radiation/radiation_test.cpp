#include "core/modal/body/body_model.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/tables.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>

using namespace tactus::modal;
using namespace tactus::test;
using Complex = std::complex<double>;

namespace {

constexpr double kPi = std::numbers::pi, kAir = 1.184, kSound = 346.1;

/// A flat disk of triangles, facing +z, that moves as a whole.
ModalTable piston(double radius, std::size_t rings, std::size_t sectors) {
  ModalTable table;
  table.free = false;
  table.material = {"", 7e10, 0.3, 2700};
  table.frequency_hz = {3000};
  table.loss_factor = {2e-3};
  table.vertex_m.push_back({0, 0, 0});
  for (std::size_t r = 1; r <= rings; ++r)
    for (std::size_t s = 0; s < sectors; ++s) {
      const double a = 2 * kPi * static_cast<double>(s) / static_cast<double>(sectors);
      const double d = radius * static_cast<double>(r) / static_cast<double>(rings);
      table.vertex_m.push_back({d * std::cos(a), d * std::sin(a), 0});
    }
  const auto at = [&](std::size_t r, std::size_t s) {
    return static_cast<std::int32_t>(r == 0 ? 0 : 1 + (r - 1) * sectors + s % sectors);
  };
  for (std::size_t r = 0; r < rings; ++r)
    for (std::size_t s = 0; s < sectors; ++s) {
      if (r > 0)
        table.triangle.push_back({at(r, s), at(r + 1, s), at(r, s + 1)});
      table.triangle.push_back({at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)});
    }
  for (std::size_t v = 0; v < table.vertex_m.size(); ++v)
    table.shape.insert(table.shape.end(), {0, 0, 1});
  return table;
}

} // namespace

TEST_CASE("a piston in a baffle sounds on its axis as the closed form says") {
  // p = rho c v (e^(-jkz) - e^(-jk sqrt(z^2 + a^2))), Rayleigh; here at the mode's complex rate,
  // the delay z/c taken out.
  const double a = 0.05, z = 0.08;
  const LoadedTable loaded(piston(a, 60, 90));
  const Complex s(-20, 2 * kPi * 3000);
  const std::size_t mode = 0;
  const auto output = loaded.radiating.modal({&s, 1}, {&mode, 1}, {0, 0, z}, {1, 1, kAir, kSound});
  const double far = std::sqrt(z * z + a * a);
  const Complex exact = kAir * kSound * (1.0 - std::exp(-s * (far - z) / kSound));
  CHECK(output.delay_s == approx(z / kSound).epsilon(1e-3));
  CHECK(std::abs(20 * std::log10(std::abs(output.pressure[0] / exact))) < 0.05);
}

TEST_CASE("a piston of few triangles sounds on its axis as the closed form says, near and far") {
  // Triangles of up to 10 mm: at 16 kHz half a wavelength. The many-sided rim encloses 0.03 % less.
  const double a = 0.05;
  const LoadedTable loaded(piston(a, 6, 144));
  const std::size_t mode = 0;
  for (const double f : {100.0, 1000.0, 3000.0, 8000.0, 12000.0, 16000.0})
    for (const double z : {0.003, 0.01, 0.08, 0.3, 1.0, 3.0}) {
      CAPTURE(f);
      CAPTURE(z);
      const Complex s(0, 2 * kPi * f);
      const auto output =
          loaded.radiating.modal({&s, 1}, {&mode, 1}, {0, 0, z}, {1, 1, kAir, kSound});
      const double far = std::sqrt(z * z + a * a);
      const double exact = 2 * kAir * kSound * std::abs(std::sin(kPi * f / kSound * (far - z)));
      if (exact < 0.05 * kAir * kSound)
        continue; // where the middle and the rim nearly cancel
      CHECK(std::abs(20 * std::log10(std::abs(output.pressure[0]) / exact)) < 0.05);
    }
  // Beside the axis: a finer surface's own sum.
  const LoadedTable fine(piston(a, 60, 144));
  const Complex s(0, 2 * kPi * 9000);
  for (const Vec3 position : {Vec3{0.031, 0.007, 0.0008}, Vec3{0.03, 0.01, 0.004},
                              Vec3{0.049, 0, 0.02}, Vec3{0.2, 0.1, 0.1}}) {
    const auto x = loaded.radiating.modal({&s, 1}, {&mode, 1}, position, {1, 1, kAir, kSound});
    const auto y = fine.radiating.modal({&s, 1}, {&mode, 1}, position, {1, 1, kAir, kSound});
    CHECK(std::abs(20 * std::log10(std::abs(x.pressure[0] / y.pressure[0]))) < 0.05);
  }
}

TEST_CASE("the arrivals from a piston are those of the closed form, throughout a sample") {
  // On the axis an acceleration impulse gives rho c from z/c to sqrt(z^2 + a^2)/c, in the spectrum
  // rho c (e^(-jkz) - e^(-jk sqrt(z^2 + a^2)))/(j omega).
  const double a = .05;
  for (const std::size_t rings : {40UL, 1UL}) // these are divided by the wavelength
    for (const double size : {1., 2.})
      for (const double z : {.08, 1.}) {
        const LoadedTable loaded(piston(a / size, rings, 60));
        RadiatingSurface::Scene scene;
        scene.size = size;
        scene.shape_scale = .5;
        RadiatingSurface::RigidShapes rigid(loaded.radiating.triangles(), {0, 0, 3, 0, 0, 0});
        const auto arrivals = loaded.radiating.arrivals({0, 0, z}, scene, rigid);
        REQUIRE(arrivals->modes() == 1);
        std::vector<double> pressure(arrivals->samples() * BandLimit::kNodes);
        for (const std::size_t motion : {0U, 3U}) { // the mode, and the free body's third
          arrivals->find(motion, pressure);
          const double far = std::sqrt(z * z + a * a);
          const TravelTime travel(z / kSound, 48000);
          CHECK(arrivals->delay_s == approx(travel.delay_s).epsilon(1e-3));
          for (const double hz : {200., 1000., 3000., 9000., 18000.}) {
            const Complex j(0, 1), w = 2 * kPi * hz, k = w / kSound;
            // From the shortest path on; what the delay line leaves of it is in the kernel.
            const Complex exact = kAir * kSound * (motion ? 3. : .5) *
                                  (1. - std::exp(-j * k * (far - z))) / (j * w) *
                                  std::exp(-j * w * travel.fractional_samples / 48000.);
            Complex gauss = 0, sampled = 0;
            for (std::size_t n = 0; n < arrivals->samples(); ++n)
              for (std::size_t m = 0; m < BandLimit::kNodes; ++m) {
                const Complex part = pressure[n * BandLimit::kNodes + m] *
                                     std::exp(-j * (w / 48000. *
                                                    (static_cast<double>(n) + BandLimit::kNode[m] -
                                                     static_cast<double>(BandLimit::kLatency))));
                if (m == 0)
                  sampled += part;
                else
                  gauss += BandLimit::kGaussWeight[m - 1] * part;
              }
            CAPTURE(rings);
            CAPTURE(size);
            CAPTURE(z);
            CAPTURE(motion);
            CAPTURE(hz);
            CAPTURE(std::abs(gauss / exact));
            CHECK(std::abs(gauss / exact - 1.) < .02);
            CHECK(std::abs(sampled / exact - 1.) < .02);
          }
        }
      }
}

TEST_CASE("a shape that changes over a triangle is integrated with its slope") {
  // u = x on a piston, far away at an angle: the dipole's share, J2 of the aperture.
  const double a = 0.05, f = 6000, r = 20, angle = 0.6;
  ModalTable table = piston(a, 6, 144);
  for (std::size_t v = 0; v < table.vertex_m.size(); ++v)
    table.shape[3 * v + 2] = static_cast<float>(table.vertex_m[v].x);
  const LoadedTable loaded(std::move(table));
  const Complex s(0, 2 * kPi * f);
  const std::size_t mode = 0;
  const auto output = loaded.radiating.modal(
      {&s, 1}, {&mode, 1}, {r * std::sin(angle), 0, r * std::cos(angle)}, {1, 1, kAir, kSound});
  // int x exp(j k x sin) dS = j 2 pi a^3 J2(q)/q, q = k a sin(angle)
  const double q = 2 * kPi * f / kSound * a * std::sin(angle);
  const double exact = kAir * 2 * kPi * f / (2 * kPi * r) * 2 * kPi * a * a * a *
                       std::abs(std::cyl_bessel_j(2, q)) / q;
  CHECK(std::abs(20 * std::log10(std::abs(output.pressure[0]) / exact)) < 0.05);
}

TEST_CASE("smooth vertices are one node, vertices on an edge one for each side") {
  // Two squares that meet at a right angle, and one that goes on straight.
  const std::vector<Vec3> vertex{{0, 0, 0},  {1, 0, 0},  {1, 1, 0}, {0, 1, 0},
                                 {0, 0, -1}, {1, 0, -1}, {2, 0, 0}, {2, 1, 0}};
  const std::vector<std::array<std::int32_t, 3>> triangle{{0, 1, 2}, {0, 2, 3}, {0, 4, 5},
                                                          {0, 5, 1}, {1, 6, 7}, {1, 7, 2}};
  Surface surface;
  surface.build(vertex, triangle);
  const SurfaceNodes nodes = surface_nodes(surface, triangle, vertex.size());
  CHECK(nodes.vertex.size() == 10); // 0 and 1 are on the edge
  CHECK(nodes.triangle_nodes[0][0] == nodes.triangle_nodes[1][0]);
  CHECK(nodes.triangle_nodes[0][0] != nodes.triangle_nodes[2][0]);
  CHECK(nodes.triangle_nodes[0][1] == nodes.triangle_nodes[4][0]);
  CHECK(nodes.normal[nodes.triangle_nodes[0][0]].z == approx(1));
  CHECK(nodes.normal[nodes.triangle_nodes[2][0]].y == approx(-1));
}

TEST_CASE("modes that swing against each other cancel on the axis") {
  ModalTable table = piston(0.05, 20, 48);
  for (std::size_t v = 0; v < table.vertex_m.size(); ++v)
    table.shape[3 * v + 2] = static_cast<float>(table.vertex_m[v].x);
  const LoadedTable loaded(std::move(table));
  const Complex s(-20, 2 * kPi * 3000);
  const std::size_t mode = 0;
  const auto on = loaded.radiating.modal({&s, 1}, {&mode, 1}, {0, 0, 0.1}, {1, 1, kAir, kSound});
  const auto off =
      loaded.radiating.modal({&s, 1}, {&mode, 1}, {0.05, 0, 0.1}, {1, 1, kAir, kSound});
  CHECK(std::abs(on.pressure[0]) < 1e-9 * std::abs(off.pressure[0]));
}

TEST_CASE("multipoles of degree 0 and 1 are the breathing and the swinging sphere") {
  const double a = 0.05, f = 2000, k = 2 * kPi * f / kSound;
  ModalTable table = piston(a, 2, 8);
  table.frequency_hz = {f, f};
  table.loss_factor = {0, 0};
  MultipoleTable& m = table.multipoles;
  m.highest_degree = {0, 1};
  m.offset = {0, 1, 5};
  m.scales = {1};
  m.reference_radius_m = a;
  // Unit velocity: p = -j rho c v h_l(kr)/h_l'(ka); the table holds its value on the sphere over Y.
  const double x = k * a;
  const auto h0 = [](double y) { return Complex(0, 1) * std::polar(1.0, -y) / y; };
  const auto h1 = [](double y) {
    return std::polar(1.0, -y) * (Complex(0, 1) / (y * y) - 1.0 / y);
  };
  const Complex h0_slope = -h1(x), h1_slope = h0(x) - 2.0 / x * h1(x);
  const Complex j(0, 1);
  const double y0 = std::sqrt(1 / (4 * kPi)), y1 = std::sqrt(3 / (4 * kPi)); // times cos(theta)
  m.coefficients.assign(5, 0);
  m.coefficients[0] = Complex(-j * kAir * kSound * h0(x) / h0_slope / y0);
  m.coefficients[1 + 2] = Complex(-j * kAir * kSound * h1(x) / h1_slope / y1);
  const Complex rates[] = {{0, 2 * kPi * f}, {0, 2 * kPi * f}};
  const std::size_t modes[] = {0, 1};
  for (const double r : {0.06, 0.2, 1.0}) {
    const Vec3 position{0, r * 0.6, r * 0.8};
    const auto output = multipole_transfer(table, rates, modes, position, {1, 1, kAir, kSound});
    const Complex delayed = std::polar(1.0, k * (r - a)); // as the delay line holds it
    const Complex p0 = -j * kAir * kSound * h0(k * r) / h0_slope * delayed;
    const Complex p1 = -j * kAir * kSound * h1(k * r) / h1_slope * 0.8 * delayed;
    CHECK(std::abs(output.pressure[0] - p0) < 1e-5 * std::abs(p0));
    CHECK(std::abs(output.pressure[1] - p1) < 1e-5 * std::abs(p1));
    CHECK(output.delay_s == approx((r - a) / kSound));
  }
}

TEST_CASE("raw velocities of one small element give its retarded, differenced potential") {
  RawTable table;
  table.hits = table.points = 1;
  table.samples = 2000;
  table.sample_rate_hz = 44100;
  table.position_m = {{0, 0, 0}};
  table.hit_m = {{0, 0, 0}};
  table.area_m2 = {1e-4};
  const double omega = 2 * kPi * 1000;
  for (std::size_t n = 0; n < table.samples; ++n)
    table.velocity_m_per_s.push_back(
        static_cast<float>(std::sin(omega * static_cast<double>(n) / 44100)));
  RawListener listener;
  const double d = 0.1;
  listener.set(table, {0, 0, d}, kAir, kSound);
  for (const double t : {0.005, 0.0123, 0.03}) {
    const auto potential = [&](double u) {
      return std::sin(omega * (u - d / kSound)) * 1e-4 / (2 * kPi * d);
    };
    const double exact = kAir * (potential(t) - potential(t - 1 / 44100.0)) * 44100;
    // Straight lines between samples of a 1 kHz tone err by (omega T)^2/8 = 0.25 %.
    CHECK(listener.pressure(table, 0, t) == approx(exact).epsilon(0.01).scale(0.02));
  }
  CHECK(listener.pressure(table, 0, 0.0002) == 0); // the sound is still on its way
}
