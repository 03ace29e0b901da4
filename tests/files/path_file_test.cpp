// Paths of a simulated hand as rows of text.
#include "core/dsp/random.hpp"
#include "files/path_file.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace tactus::haptic;
using tactus::Vec3;
using tactus::files::parse_path;

TEST_CASE("rows are times in ms and positions in mm, with buttons or without") {
  const auto parsed = parse_path("# a stroke\n0 0 0 0\n100, 10 0 -5 1\n\n200\t+10 20 -5 # end\r\n");
  REQUIRE(parsed.error.empty());
  REQUIRE(parsed.rows.size() == 3);
  CHECK(parsed.rows[0].time_s == 0);
  CHECK(parsed.rows[1].time_s == doctest::Approx(0.1));
  CHECK(norm(parsed.rows[1].position - Vec3{0.01, 0, -0.005}) < 1e-15);
  CHECK(parsed.rows[1].buttons == 1);
  CHECK(norm(parsed.rows[2].position - Vec3{0.01, 0.02, -0.005}) < 1e-15);
  CHECK(parsed.rows[2].buttons == 0);
  CHECK(parse_path("0 0 0 0\n10 1 0 0\n10 5 0 0 4294967295").rows.size() == 3); // a jump
}

TEST_CASE("a file that is wrong is refused with the line") {
  CHECK(parse_path("").error == "no row of the form ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0").error == "line 1: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0\n1 2 3 four").error == "line 2: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0\n1 2 3 nan").error == "line 2: expected ms x y z [buttonmask]");
  CHECK(parse_path("0 0 0 0 1 7").error == "line 1: expected ms x y z [buttonmask]");
  CHECK(parse_path("5 0 0 0\n\n1 0 0 0").error == "line 3: time goes backwards");
  CHECK(parse_path("0 0 1e9 0").error == "line 1: a position is outside -100000..100000 mm");
  CHECK(parse_path("0 0 0 0 1.5").error ==
        "line 1: the button mask is not an integer in 0..4294967295");
}

TEST_CASE("random bytes never break the reader") {
  tactus::Random random(6);
  const std::string alphabet = "0123456789+-.eE \t\n,#naif\r\x80";
  for (int round = 0; round < 5000; ++round) {
    std::string text;
    for (auto left = random.next() % 60; left > 0; --left)
      text += alphabet[static_cast<std::size_t>(random.next() % alphabet.size())];
    const auto parsed = parse_path(text);
    CHECK(parsed.rows.empty() != parsed.error.empty());
    if (!parsed.rows.empty())
      CHECK(is_finite(RowPath(parsed.rows).at(0.5).position));
  }
}
