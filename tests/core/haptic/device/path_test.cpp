#include "core/haptic/device/path.hpp"

#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace tactus::haptic;
using tactus::Vec3;

TEST_CASE("rows are joined by straight lines and held outside; two of one time are a jump") {
  const RowPath path({{0, {}, 0},
                      {0.1, {0.01, 0, -0.005}, 1},
                      {0.2, {0.01, 0.02, -0.005}, 0},
                      {0.2, {0.05, 0.02, 0}, 0}});
  CHECK(path.size() == 4);
  CHECK(path.at(-1).position == Vec3{});
  const PathPoint middle = path.at(0.05);
  CHECK(norm(middle.position - Vec3{0.005, 0, -0.0025}) < 1e-15);
  CHECK(norm(middle.velocity - Vec3{0.1, 0, -0.05}) < 1e-15);
  CHECK(middle.buttons == 0);
  CHECK(path.at(0.15).buttons == 1);
  CHECK(path.at(0.15).velocity.y == doctest::Approx(0.2));
  CHECK(path.at(0.1999).position.x == tactus::test::approx(0.01));
  CHECK(path.at(0.2).position == Vec3{0.05, 0.02, 0});
  CHECK(path.at(9).position == Vec3{0.05, 0.02, 0});
  CHECK(path.at(9).velocity == Vec3{});
}

TEST_CASE("the velocities of the built-in paths are the slopes of their positions") {
  const Path paths[] = {LinePath{{-0.02, 0, 0.01}, {0.03, 0.01, 0}, 0.7},
                        CirclePath{{0, 0.01, 0}, 0.02, 0.4, 1, 2},
                        LissajousPath{{0, 0, 0.01}, {0.02, 0.01, 0.03}, {1, 2.5, 0.3}}};
  for (const Path& path : paths)
    for (double t = 0; t < 2; t += 0.0371) {
      const double h = 1e-5;
      const Vec3 slope =
          (point_at(path, t + h).position - point_at(path, t - h).position) * (0.5 / h);
      CHECK(norm(slope - point_at(path, t).velocity) < 1e-6);
    }
  CHECK(point_at(paths[0], 0).position == Vec3{-0.02, 0, 0.01});
  CHECK(norm(point_at(paths[0], 0.35).position - Vec3{0.03, 0.01, 0}) < 1e-15);
}

TEST_CASE("a circle and a Lissajous figure follow their formulas, also after hours") {
  const CirclePath circle{{0.01, 0.02, 0.03}, 0.02, 0.4, 2, 0};
  for (const double hours : {0.0, 5.0}) {
    const double t = hours * 3600; // a whole number of periods
    CHECK(norm(circle.at(t).position - Vec3{0.01, 0.02, 0.05}) < 1e-12);
    CHECK(norm(circle.at(t + 0.1).position - Vec3{0.03, 0.02, 0.03}) < 1e-12);
    CHECK(norm(circle.at(t + 0.2).position - Vec3{0.01, 0.02, 0.01}) < 1e-12);
  }
  const LissajousPath figure{{0.001, 0.002, 0.003}, {0.01, 0.02, 0.03}, {1, 0.5, 0.25}};
  CHECK(norm(figure.at(1).position - Vec3{0.001, 0.002, 0.033}) < 1e-12); // 1, 1/2, 1/4 turn
  CHECK(norm(figure.at(0.5).position - Vec3{0.001, 0.022, 0.003 + 0.03 * std::sqrt(0.5)}) < 1e-12);
}
