#include "core/dsp/random.hpp"
#include "core/haptic/device/path.hpp"

#include "tests/core/haptic/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

using namespace tactus::haptic;

TEST_CASE("rows are joined by straight lines and held outside") {
  const auto parsed = parse_path("# a stroke\n0 0 0 0\n100, 10 0 -5 1\n\n200\t10 20 -5 # end\r\n");
  REQUIRE(parsed.error.empty());
  const RowPath path(parsed.rows);
  CHECK(path.size() == 3);
  CHECK(path.at(-1).position == Vec3{});
  const PathPoint middle = path.at(0.05);
  CHECK(middle.position.x == test::approx(0.005));
  CHECK(middle.position.z == test::approx(-0.0025));
  CHECK(middle.velocity.x == doctest::Approx(0.1));
  CHECK(middle.buttons == 0);
  CHECK(path.at(0.15).buttons == 1);
  CHECK(path.at(0.15).velocity.y == doctest::Approx(0.2));
  CHECK(path.at(9).position.y == doctest::Approx(0.02));
  CHECK(path.at(9).velocity == Vec3{});
}

TEST_CASE("two rows of one time are a jump") {
  const auto parsed = parse_path("0 0 0 0\n10 1 0 0\n10 5 0 0\n20 5 0 0");
  REQUIRE(parsed.error.empty());
  const RowPath path(parsed.rows);
  CHECK(path.at(0.0099).position.x < 1e-3);
  CHECK(path.at(0.01).position.x == test::approx(5e-3));
}

TEST_CASE("a file that is wrong is refused with the line") {
  CHECK(parse_path("").error == "no row of the form ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0").error == "line 1: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0\n1 2 3 four").error == "line 2: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0\n1 2 3 nan").error == "line 2: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0 1 7").error == "line 1: expected ms x y z [buttonmask]");
  CHECK(parse_path("5 0 0 0\n\n1 0 0 0").error == "line 3: time goes backwards");
  CHECK(parse_path("0 0 1e9 0").error == "line 1: a position is beyond 100000 mm");
  CHECK(parse_path("0 0 0 0 1.5").error ==
        "line 1: the button mask is not a whole number from 0 to 4294967295");
}

TEST_CASE("random bytes never crash the reader") {
  tactus::Random random(6);
  const std::string alphabet = "0123456789+-.eE \t\n,#naif\r\x80";
  for (int round = 0; round < 5000; ++round) {
    std::string text;
    for (auto left = random.next() % 60; left > 0; --left)
      text += alphabet[random.next() % alphabet.size()];
    const auto parsed = parse_path(text);
    CHECK(parsed.rows.empty() != parsed.error.empty());
    if (!parsed.rows.empty())
      CHECK(is_finite(RowPath(parsed.rows).at(0.5).position));
  }
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
  CHECK(norm(figure.at(0).position - Vec3{0.001, 0.002, 0.003}) < 1e-15);
  CHECK(norm(figure.at(1).position - Vec3{0.001, 0.002, 0.033}) < 1e-12); // 1, 1/2, 1/4 turn
  CHECK(norm(figure.at(0.5).position - Vec3{0.001, 0.022, 0.003 + 0.03 * std::sqrt(0.5)}) < 1e-12);
}
