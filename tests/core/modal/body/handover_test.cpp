// One body gives way to another: what waits for its sample, where points and rubs come to lie, and
// what still rings.
#include "core/modal/radiation/direct_sound.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

Vec3 turned(const Vec3& v, double angle) { // about x
  return {v.x, std::cos(angle) * v.y - std::sin(angle) * v.z,
          std::sin(angle) * v.y + std::cos(angle) * v.z};
}

/// The plate, inclined by an angle about x.
std::shared_ptr<const LoadedTable> inclined(double angle) {
  ModalTable table = plate(.32, .2, .005, 3000, 8, 6);
  for (Vec3& v : table.vertex_m)
    v = turned(v, angle);
  for (std::size_t i = 0; i < table.shape.size(); i += 3) {
    const Vec3 t =
        turned({static_cast<double>(table.shape[i]), static_cast<double>(table.shape[i + 1]),
                static_cast<double>(table.shape[i + 2])},
               angle);
    table.shape[i] = static_cast<float>(t.x);
    table.shape[i + 1] = static_cast<float>(t.y);
    table.shape[i + 2] = static_cast<float>(t.z);
  }
  return std::make_shared<const LoadedTable>(std::move(table));
}

const Vec3 kPoint{.06, .03, 0};

double apart(const std::vector<float>& a, const std::vector<float>& b) {
  float maximum = 0, difference = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    maximum = std::max(maximum, std::abs(a[n]));
    difference = std::max(difference, std::abs(a[n] - b[n]));
  }
  CHECK(maximum > 0);
  return static_cast<double>(difference / maximum);
}

} // namespace

TEST_CASE(
    "a scheduled strike hits the new body at its position, along the normal if it was along it") {
  constexpr double kAngle = .7;
  for (const bool oblique : {false, true}) {
    CAPTURE(oblique);
    const Vec3 given = Vec3{0, .6, .8};
    Rig scheduled;
    const SurfacePoint before = scheduled.body.model()->nearest(kPoint);
    scheduled.body.schedule_hit({before, oblique ? given : before.normal, 1}, 100);
    scheduled.loaded = inclined(kAngle);
    scheduled.rebuild(false);
    Rig direct;
    direct.loaded = inclined(kAngle);
    direct.rebuild(false);
    const SurfacePoint now = direct.body.model()->nearest(before.position);
    CHECK(norm(now.normal - before.normal) > .5);
    direct.body.schedule_hit({now, oblique ? given : now.normal, 1}, 100);
    const auto a = scheduled.run(2000), b = direct.run(2000);
    CHECK(apart(b.left, a.left) < 1e-6);
    CHECK(impulse(a, kRate) == approx(impulse(b, kRate)).epsilon(1e-6));
  }
}

TEST_CASE("points are kept in metres when the new body has another size") {
  Rig rig;
  rig.settings.size = 2;
  rig.rebuild(false);
  const SurfacePoint before = rig.body.model()->nearest({.1, .05, 0});
  rig.body.set_point(before, before.normal);
  rig.body.schedule_hit({before, before.normal, 1}, 100);
  rig.body.schedule_point(rig.body.model()->nearest({-.06, .02, 0}), before.normal, 300);
  rig.settings.size = 1;
  rig.loaded = inclined(0);
  rig.rebuild(false);
  // What waits, in the table's own lengths: 2 x its position.
  CHECK(norm(rig.body.point().position - Vec3{-.06, .02, .0025}) < 1e-6);
  Rig alone; // one point is all that waits
  alone.body.schedule_point(alone.body.model()->nearest({-.06, .02, 0}), {0, 0, 1}, 300);
  alone.rebuild();
  CHECK(norm(alone.body.point().position - Vec3{-.06, .02, .0025}) < 1e-6);
  Rig direct;
  direct.loaded = inclined(0);
  direct.rebuild(false);
  const SurfacePoint now = direct.body.model()->nearest({.1, .05, 0});
  direct.body.schedule_hit({now, now.normal, 1}, 100);
  // The bank is exact to -60 dB, and its leaps begin anew where the point moves.
  CHECK(apart(direct.run(1000).left, rig.run(1000).left) < 1e-3);
}

TEST_CASE("a force point that was never set lies nearest to the user, and a set one stays put") {
  Rig rig;
  const Surface& surface = rig.loaded->surface;
  const Vec3 middle = .5 * (surface.lowest() + surface.highest());
  CHECK(norm(rig.body.point().position - middle) < .02);
  rig.loaded = inclined(1.2); // upright: its upper edge and its middle are as near
  rig.rebuild(false);
  CHECK(rig.body.point().position ==
        rig.loaded->surface
            .nearest(.5 * (rig.loaded->surface.lowest() + rig.loaded->surface.highest()) +
                     Vec3{0, 0, rig.loaded->surface.diagonal()})
            .position);
  const SurfacePoint set = rig.body.model()->nearest({.1, 0, 0});
  rig.body.set_point(set, set.normal);
  CHECK(rig.body.point().position == set.position);
  rig.rebuild(); // the same body again
  CHECK(rig.body.point().position == set.position);
  rig.loaded = inclined(.2);
  rig.rebuild(false);
  CHECK(norm(rig.body.point().position - rig.body.model()->nearest(set.position).position) < 1e-12);
}

TEST_CASE("of two bodies that are handed over one after the other the second counts") {
  Rig rig;
  auto first = std::make_unique<BodyModel>(rig.loaded, rig.settings);
  auto second = std::make_unique<BodyModel>(rig.loaded, rig.settings);
  const BodyModel* const expected = second.get();
  rig.body.publish(std::move(first), false);
  rig.body.publish(std::move(second), false);
  CHECK(rig.body.model() != expected);
  rig.body.adopt();
  CHECK(rig.body.model() == expected);
  rig.body.adopt();
  CHECK(rig.body.model() == expected);
}

TEST_CASE("a body that is exchanged rings out as one that is silenced") {
  const auto play = [](bool exchanged, Radiation radiation) {
    Rig rig;
    rig.settings.radiation = radiation;
    rig.settings.listener[0] = {.4, .1, 1.5}; // on its way when the body goes
    rig.rebuild(false);
    rig.hit(kPoint, 1);
    static_cast<void>(rig.run(1024));
    CHECK(rig.body.contacts() == 0);
    if (exchanged) {
      rig.loaded = inclined(0);
      rig.rebuild(false);
    } else {
      rig.body.reset();
    }
    return rig.run(ModeBank::kRelease + 1024).left;
  };
  for (const Radiation radiation : {Radiation::kNone, Radiation::kModal}) {
    const auto exchanged = play(true, radiation), silenced = play(false, radiation);
    CHECK(apart(silenced, exchanged) < 1e-4);
    CHECK(std::abs(silenced.back()) < 1e-7F);
    CHECK(std::abs(exchanged.back()) < 1e-7F);
  }
}

TEST_CASE("a silent body is exchanged without any sound") {
  Rig rig;
  static_cast<void>(rig.run(128));
  rig.loaded = inclined(.3);
  rig.rebuild(false);
  for (const float x : rig.run(256).left)
    CHECK(x == 0);
}

TEST_CASE("bodies exchanged while others still ring: the sum of what each would ring out") {
  const auto strike = [](Rig& rig) {
    rig.hit(kPoint, 1);
    static_cast<void>(rig.run(64));
  };
  Rig rig;
  for (int i = 0; i < 3; ++i) {
    strike(rig);
    rig.loaded = inclined(.1 * i);
    rig.rebuild(false);
  }
  const auto all = rig.run(1024).left;
  // The same bodies, each alone, for as long as it is heard.
  std::vector<float> sum(1024, 0);
  for (int i = 0; i < 3; ++i) {
    Rig one;
    if (i > 0) {
      one.loaded = inclined(.1 * (i - 1));
      one.rebuild(false);
    }
    strike(one);
    one.loaded = inclined(.1 * i);
    one.rebuild(false);
    static_cast<void>(one.run(static_cast<std::size_t>(64 * (2 - i))));
    const auto output = one.run(1024).left;
    for (std::size_t n = 0; n < sum.size(); ++n)
      sum[n] += output[n];
  }
  CHECK(apart(sum, all) < 1e-5);
}

TEST_CASE("kernels of the maximum length fit wherever in a segment they begin") {
  constexpr std::size_t kTaps = DirectKernels::kMaxTaps, kLast = DirectSound::kChunk - 1;
  DirectSound direct;
  direct.prepare(kRate);
  const ForceKernel kernel{std::vector<float>(kTaps, 1), std::vector<float>(kTaps, 0)};
  ForceKernel other = kernel;
  std::fill(other.elastic.begin(), other.elastic.end(), 3.F);
  for (std::size_t l = 0; l < DirectSound::kListeners; ++l)
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest})
      direct.add_sample(l, part, kLast, part == ModeBank::kLatest ? kernel : other, kTaps, 1);
  std::vector<float> sound(64);
  for (std::size_t n = 0; n < kTaps + 128; n += 64)
    for (std::size_t l = 0; l < DirectSound::kListeners; ++l) {
      std::fill(sound.begin(), sound.end(), 0.F);
      direct.finish(l, sound, Glide());
      for (std::size_t i = 0; i < 64; ++i)
        CHECK(sound[i] == (n + i >= kLast && n + i < kLast + kTaps ? 1 : 0));
    }
}
