// What a listener receives of a surface's motion, beside closed forms of pistons in a baffle, of
// small elements and of a free body's recoil.
#include "core/modal/body/body_model.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

constexpr double kAir = 1.184, kSound = 346.1;

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

/// What arrives from the only mode of a table and, faster by three, from the third rigid motion.
std::unique_ptr<Arrivals> arrivals(const LoadedTable& loaded, const Vec3& listener, double size = 1,
                                   double shape_scale = 1) {
  RadiatingSurface::Scene scene;
  scene.size = size;
  scene.shape_scale = shape_scale;
  return loaded.radiating.arrivals(
      listener, scene,
      RadiatingSurface::RigidShapes(loaded.radiating.triangles(), {0, 0, 3, 0, 0, 0}));
}

} // namespace

TEST_CASE("the arrivals from a piston are those of the closed form, near and far, in any size") {
  // On the axis an acceleration impulse gives rho c from z/c to sqrt(z^2 + a^2)/c, in the spectrum
  // rho c (e^(-jkz) - e^(-jk sqrt(z^2 + a^2)))/(j omega).
  const double a = .05;
  for (const std::size_t rings : {40UL, 6UL, 1UL}) // these are divided by the wavelength
    for (const double size : {1., 2.})
      for (const double z : {.01, .08, 1.}) {
        CAPTURE(rings);
        CAPTURE(size);
        CAPTURE(z);
        const LoadedTable loaded(piston(a / size, rings, 60));
        const auto found = arrivals(loaded, {0, 0, z}, size, .5);
        REQUIRE(found->modes() == 1);
        const double far = std::sqrt(z * z + a * a);
        const TravelTime travel(z / kSound, kRate);
        CHECK(found->delay_s == approx(travel.delay_s).epsilon(1e-3));
        // Near, the middle and the rim nearly cancel.
        const double floor = z < .05 ? .01 * kAir * kSound : 0;
        for (const std::size_t motion : {0U, 3U}) // the mode, and the free body's third
          for (const double hz : {200., 1000., 3000., 9000., 16000.}) {
            const Complex s(0, 2 * kPi * hz);
            // From the shortest path on; what the delay line leaves of it is in the kernel.
            const Complex exact = kAir * kSound * (motion ? 3. : .5) *
                                  (1. - exp(-s * (far - z) / kSound)) / s *
                                  exp(-s * (travel.fractional_samples / kRate));
            CAPTURE(motion);
            CAPTURE(hz);
            for (const Complex& sum : spectrum(*found, motion, hz, kRate))
              CHECK(abs(sum - exact) < .02 * abs(exact) + (motion ? 3. : .5) * floor / abs(s));
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
  const auto level = [&](const Vec3& listener) {
    return abs(spectrum(*arrivals(loaded, listener), 0, f, kRate)[0]);
  };
  // int x exp(j k x sin) dS = j 2 pi a^3 J2(q)/q, q = k a sin(angle)
  const double q = 2 * kPi * f / kSound * a * std::sin(angle);
  const double exact = kAir / r * a * a * a * std::cyl_bessel_j(2, q) / q;
  CHECK(level({r * std::sin(angle), 0, r * std::cos(angle)}) == approx(exact).epsilon(.01));
  // On the axis the halves that swing against each other cancel.
  CHECK(level({0, 0, 0.1}) < 1e-6 * level({0.05, 0, 0.1}));
}

TEST_CASE("raw velocities of one small element give its retarded, differenced potential") {
  RawTable table;
  table.hits = 2; // the second of which sounds
  table.points = 1;
  table.samples = 2000;
  table.sample_rate_hz = 44100;
  table.position_m = {{0, 0, 0}};
  table.hit_m = {{0, 0, 0}, {0, 0, 0}};
  table.area_m2 = {1e-4};
  const double omega = 2 * kPi * 1000;
  table.velocity_m_per_s.assign(table.samples, 0);
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
    CHECK(listener.pressure(table, 1, t) == approx(exact).epsilon(0.01).scale(0.02));
  }
  CHECK(listener.pressure(table, 0, 0.0123) == 0);
  CHECK(listener.pressure(table, 1, 0.0002) == 0); // the sound is still on its way
}

namespace {

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
             tactus::math::polar(1., -2 * kPi * 300 * static_cast<double>(n) / kRate);
    return abs(sum);
  };
  // Half the displaced air in added mass: 3/2 V rho_air/(4 pi r c) (1/m) jw (1 + c/(jw r)).
  const double c = 346.1, air = 1.184, r = 2, w = 2 * kPi * 300, volume = 4. / 3 * kPi * 8e-6;
  // The table's air is its own.
  const ModalTable table = breathing_ball(.02);
  const double scale = table.air_density_kg_per_m3 / air, speed = table.sound_speed_m_per_s / c;
  const double expected = 1.5 * volume * air * scale / (4 * kPi * r * c * speed) *
                          abs(Complex(c * speed / r, w)) / (volume * 2700);
  const double own = recoil(1, 0);
  CHECK(own == approx(expected).epsilon(.02));
  CHECK(recoil(2, 0) == approx(own).epsilon(.01));
  CHECK(recoil(.5, 0) == approx(own).epsilon(.01));
  CHECK(recoil(1, 5400) == approx(own / 2).epsilon(.01));
}
