// The kernels of forces on large bodies, whose sums over the modes are taken beforehand at the
// surface's vertices, beside those of the same body with fewer modes, summed where a force acts.
#include "core/modal/body/body_model.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// The plate's lowest modes, and so many more that move nothing.
BodyModel make_body(std::size_t silent, VectorSet set = tactus::simd::kWidest) {
  ModalTable table = free_plate(.32, .2, .005, 2500, 6, 4);
  table.frequency_hz.back() = 30000;                        // too high to ring
  for (std::size_t i = 0; i < table.shape.size(); i += 3) { // not along z alone
    table.shape[i] = .3F * table.shape[i + 2];
    table.shape[i + 1] = -.5F * table.shape[i + 2];
  }
  for (std::size_t k = 0; k < silent; ++k) {
    table.frequency_hz.push_back(2500 + .01 * static_cast<double>(k));
    table.loss_factor.push_back(1e-3);
    table.shape.insert(table.shape.end(), 3 * table.vertices(), 0.F);
  }
  BodySettings settings;
  settings.size = 1.5;
  settings.listeners = 3;
  settings.voices = 2;
  settings.vector_set = set;
  settings.listener = {Vec3{.1, .2, .4}, Vec3{-.2, 0, .3}, Vec3{.3, .1, .5}, Vec3{}};
  return BodyModel(std::make_shared<const LoadedTable>(std::move(table)), settings);
}

void compare(const std::vector<float>& one, const std::vector<float>& two, std::size_t moments) {
  REQUIRE(!one.empty());
  REQUIRE(!two.empty());
  const std::size_t a = one.size() / moments, b = two.size() / moments;
  float maximum = 0, apart = 0;
  for (std::size_t j = 0; j < moments; ++j)
    for (std::size_t n = 0; n < std::max(a, b); ++n) {
      const float x = n < a ? one[j * a + n] : 0, y = n < b ? two[j * b + n] : 0;
      maximum = std::max(maximum, std::abs(x));
      apart = std::max(apart, std::abs(x - y));
    }
  CHECK(maximum > 0);
  CHECK(apart < 2e-4F * maximum);
}

} // namespace

TEST_CASE("kernels summed beforehand at the vertices are those summed over the modes") {
  for (const VectorSet set : {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512}) {
    if (!tactus::simd::runs(set))
      continue;
    CAPTURE(static_cast<int>(set));
    BodyModel few = make_body(0), many = make_body(1500, set);
    REQUIRE(!few.direct[0].on_surface());
    REQUIRE(many.direct[0].on_surface());
    REQUIRE(few.direct[0].moments() == many.direct[0].moments());
    const std::size_t moments = few.direct[0].moments();
    const Vec3 direction{.48, -.6, .64};
    for (const std::array<double, 2>& at : {std::array{0., 0.}, {1., 0.}, {0., 1.}, {.3, .5}}) {
      CAPTURE(at[0]);
      CAPTURE(at[1]);
      const SurfacePoint point = few.loaded->surface.on(16, at[0], at[1]);
      for (BodyModel* const model : {&few, &many}) {
        model->build_point_kernels(point, direction);
        model->build_pulse_kernels(1, point, direction);
        model->build_contact_kernels(2, point, direction);
      }
      for (std::size_t l = 0; l < 3; ++l) {
        CAPTURE(l);
        compare(few.sample_kernel[0][l].elastic, many.sample_kernel[0][l].elastic, 1);
        compare(few.sample_kernel[2][l].elastic, many.sample_kernel[2][l].elastic, 1);
        compare(few.contact_kernel[2][l].elastic, many.contact_kernel[2][l].elastic, moments);
        compare(few.sample_kernel[0][l].rigid, many.sample_kernel[0][l].rigid, 1);
        compare(few.contact_kernel[2][l].rigid, many.contact_kernel[2][l].rigid, moments);
        // Where nothing strikes nothing is: other slots keep what they had.
        const auto& idle = many.sample_kernel[1][l].elastic;
        CHECK(std::all_of(idle.begin(), idle.end(), [](float x) { return x == 0; }));
      }
    }
  }
}

TEST_CASE("a pulse's kernel takes the gains that are given: some modes may be left out of it") {
  BodyModel model = make_body(0);
  const SurfacePoint point = model.loaded->surface.on(16, .3, .5);
  const Vec3 direction{0, 0, 1};
  std::vector<double> gain(model.mode.size());
  model.gains(point, direction, gain);
  for (std::size_t k = 0; k < gain.size(); ++k)
    gain[k] *= model.pulse_gain[k];
  model.build_pulse_kernels(0, point, direction, gain);
  model.build_pulse_kernels(1, point, direction); // of all modes
  compare(model.sample_kernel[1][0].elastic, model.sample_kernel[2][0].elastic, 1);
  // Twice the gains, twice the kernel; the rigid part is the whole body's.
  for (double& b : gain)
    b *= 2;
  const auto once = model.sample_kernel[1][0];
  model.build_pulse_kernels(0, point, direction, gain);
  for (std::size_t n = 0; n < once.elastic.size(); ++n)
    CHECK(model.sample_kernel[1][0].elastic[n] == approx(2 * once.elastic[n]).epsilon(1e-5));
  CHECK(model.sample_kernel[1][0].rigid == once.rigid);
  // And those of a contact.
  model.gains(point, direction, gain);
  model.build_contact_kernels(0, point, direction, gain);
  model.build_contact_kernels(3, point, direction);
  CHECK(model.contact_kernel[0][1].elastic == model.contact_kernel[3][1].elastic);
}
