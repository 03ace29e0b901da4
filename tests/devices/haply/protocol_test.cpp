#include "devices/haply/protocol.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <utility>

using namespace tactus;

TEST_CASE("the service's axes, right forward up, become right up back, and return") {
  CHECK(devices::haply::to_project({1, 2, 3}) == Vec3{1, 3, -2});
  CHECK(devices::haply::to_service(devices::haply::to_project({1, 2, 3})) == Vec3{1, 2, 3});
}

TEST_CASE("a state is read as far as it goes, and tells who it is of") {
  const auto message = devices::haply::parse(
      R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":1,"y":-0.5,"z":0.25}}},
          {"device_id":"04BA","status":{"calibrated":false},"config":{"type":"minverse",
           "extended_firmware_version":"7.4.1"},"state":{"cursor_velocity":{"x":1,"y":2,"z":3}}}]})");
  REQUIRE(message);
  REQUIRE(message->devices.size() == 2);
  const auto& [first, second] = std::pair{message->devices[0], message->devices[1]};
  CHECK(first.id == "049D");
  CHECK(*first.position == Vec3{1, 0.25, 0.5});
  CHECK_FALSE((first.velocity || first.calibrated || first.workspace || first.mount));
  CHECK(second.id == "04BA");
  CHECK(second.type == "minverse");
  CHECK(second.firmware == "7.4.1");
  CHECK(*second.velocity == Vec3{1, 3, -2});
  CHECK(*second.calibrated == false);
  CHECK_FALSE(second.position);
  CHECK_FALSE(message->buttons);
}

TEST_CASE("what is no state is none, and a member of a wrong kind is left out") {
  using devices::haply::parse;
  CHECK_FALSE(parse(""));
  CHECK_FALSE(parse("hello"));
  CHECK_FALSE(parse("[1,2]"));
  CHECK_FALSE(parse(R"({"inverse3":)"));
  CHECK(parse("{}")->devices.empty());
  CHECK(parse(R"({"inverse3":"none"})")->devices.empty());
  const auto odd = parse(
      R"({"inverse3":[7,{"device_id":9,"state":{"cursor_position":{"x":"1","y":2,"z":3},
          "cursor_velocity":{"x":1e999,"y":0,"z":0}},"status":{"calibrated":"yes"}}]})");
  if (odd) { // a parser may also refuse the number that no double holds
    REQUIRE(odd->devices.size() == 2);
    CHECK(odd->devices[1].id == "");
    CHECK_FALSE(odd->devices[1].position);
    CHECK_FALSE(odd->devices[1].velocity);
    CHECK_FALSE(odd->devices[1].calibrated);
  }
}

TEST_CASE(
    "a grip's turn is whole or none, the shorter way round, and its buttons have a bit each") {
  using devices::haply::parse;
  const auto grip = [](const std::string& state) {
    return parse(R"({"wireless_verse_grip":[{"state":{)" + state + "}}]}").value();
  };
  CHECK_FALSE(grip(R"("orientation":{"x":0,"y":0,"z":1})").rotation);
  CHECK_FALSE(grip(R"("orientation":{"w":1})").rotation);
  CHECK_FALSE(grip(R"("orientation":{"w":1,"x":0,"y":"0","z":0})").rotation);
  CHECK(*grip(R"("orientation":{"w":1,"x":0,"y":0,"z":0})").rotation == Vec3{});
  // -q is q: a turn of 0.2 rad about the service's y, forward, our -z; never more than half a turn.
  const double s = std::sin(0.1), c = std::cos(0.1);
  for (const double sign : {1.0, -1.0}) {
    const auto turned = grip(R"("orientation":{"w":)" + std::to_string(sign * c) +
                             R"(,"x":0,"y":)" + std::to_string(sign * s) + R"(,"z":0})");
    CHECK(norm(*turned.rotation - Vec3{0, 0, -0.2}) < 1e-5);
  }
  CHECK(*grip(R"("buttons":{"a":true})").buttons == 1u);
  CHECK(*grip(R"("buttons":{"b":true,"c":false})").buttons == 2u);
  CHECK(*grip(R"("buttons":{"a":true,"b":1,"c":true})").buttons == 5u);
  CHECK(*grip(R"("buttons":{})").buttons == 0u);
  CHECK(*grip(R"("button":false)").buttons == 0u);
  CHECK_FALSE(grip(R"("buttons":[true])").buttons);
  CHECK_FALSE(grip(R"("button":"pressed")").buttons);
  CHECK_FALSE(parse(R"({"verse_grip":[{"id":1}]})")->buttons);
  CHECK_FALSE(parse(R"({"verse_grip":[]})")->rotation);
  // Of two kinds the wireless one is taken, of two of a kind the first.
  const std::string one = R"({"state":{"button":true,"orientation":{"w":0,"x":1,"y":0,"z":0}}})",
                    two = R"({"state":{"button":false,"orientation":{"w":0,"x":0,"y":1,"z":0}}})";
  const auto both =
      parse(R"({"verse_grip":[)" + two + R"(],"wireless_verse_grip":[)" + one + "," + two + "]}");
  CHECK(*both->buttons == 1u);
  CHECK(norm(*both->rotation - Vec3{std::acos(-1.0), 0, 0}) < 1e-12);
  CHECK(*parse(R"({"wireless_verse_grip":[],"verse_grip":[)" + two + "]}")->buttons == 0u);
}

TEST_CASE("a placement can be undone from scale 1/1000 to 1000 and with a turn of unit length") {
  using devices::haply::Transform;
  for (const double scale : {1.01e-3, 990.0, -1.0})
    for (int axis = 0; axis < 3; ++axis) {
      Transform placed;
      placed.pose.position = {1, 2, 3};
      placed.scale[axis] = scale;
      CHECK(placed.valid());
      CHECK(norm(placed.point(Vec3{1, 2, 3}) - Vec3{}) < 1e-12);
      Vec3 far{1, 2, 3}, own{};
      far[axis] += scale;
      own[axis] = 1;
      CHECK(norm(placed.point(far) - own) < 1e-9);
      CHECK(norm(placed.motion(far - Vec3{1, 2, 3}) - own) < 1e-9);
    }
  for (const double scale : {0.0, 0.99e-3, 1010.0, -1010.0, double(NAN)}) {
    Transform placed;
    placed.scale.z = scale;
    CHECK_FALSE(placed.valid());
  }
  for (const auto& [w, valid] :
       {std::pair{1.0049, true}, {1.0051, false}, {0.9951, true}, {0.9949, false}}) {
    Transform placed;
    placed.pose.rotation.w = w; // the square within a hundredth of 1
    CHECK(placed.valid() == valid);
    placed.pose.rotation = {0, 0.6 * w, 0, 0.8 * w};
    CHECK(placed.valid() == valid);
  }
  Transform nowhere;
  nowhere.pose.position.y = NAN;
  CHECK_FALSE(nowhere.valid());
}

TEST_CASE(
    "a force is said in the service's axes; the first message names us and asks for a preset") {
  CHECK(devices::haply::force_message("049D", {1, 2, 3}) ==
        R"({"inverse3":[{"commands":{"set_cursor_force":{"vector":)"
        R"({"x":1.0,"y":-3.0,"z":2.0}}},"device_id":"049D"}]})");
  CHECK(devices::haply::force_message("049D", {1, 2, 3}, devices::haply::ForceKey::kBoth) ==
        R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":1.0,"y":-3.0,"z":2.0},)"
        R"("vector":{"x":1.0,"y":-3.0,"z":2.0}}},"device_id":"049D"}]})");
  CHECK(devices::haply::first_message("049D") ==
        R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":0.0,"y":-0.0,"z":0.0},)"
        R"("vector":{"x":0.0,"y":-0.0,"z":0.0}}},)"
        R"("configure":{"preset":{"preset":"arm_front_centered"}},"device_id":"049D"}],)"
        R"("session":{"configure":{"basis":{"permutation":"XYZ"},"profile":{"name":"tactus"}}}})");
  CHECK(devices::haply::status_request("049D", false).find(R"("force_render_full_state":{})") !=
        std::string::npos);
}

TEST_CASE("a placement is undone: turned back, then scaled back, in the project's axes") {
  const auto message = devices::haply::parse(
      R"({"inverse3":[{"device_id":"049D","config":{"preset":"arm_front_centered",
          "basis":{"permutation":"XYZ"},"mount":{"scale":{"x":2,"y":3,"z":4}}},
          "state":{"transform":{"position":{"x":1,"y":2,"z":3},
          "rotation":{"w":0.7071067811865476,"x":0,"y":0,"z":0.7071067811865476}}}}]})");
  REQUIRE(message);
  const devices::haply::DeviceState& device_state = message->devices.at(0);
  CHECK(device_state.preset == "arm_front_centered");
  CHECK(device_state.basis == "XYZ");
  REQUIRE(device_state.workspace);
  REQUIRE(device_state.mount);
  CHECK(device_state.mount->scale == Vec3{2, 4, 3});
  CHECK(device_state.workspace->scale == Vec3{1, 1, 1});
  // The service's (1, 0, 0), turned a quarter about its z, is (0, 1, 0), forward: our -z.
  const Vec3 seen = devices::haply::to_project({1, 3, 3});
  CHECK(norm(device_state.workspace->point(seen) - devices::haply::to_project({1, 0, 0})) < 1e-12);
  CHECK(norm(device_state.workspace->rotated({1, 0, 0}) - Vec3{0, 0, -1}) < 1e-12);
  CHECK(device_state.workspace->valid());
  for (const char* wrong :
       {R"("scale":{"x":0,"y":1,"z":1})", R"("rotation":{"w":9,"x":0,"y":0,"z":0})",
        R"("scale":{"x":1e9,"y":1,"z":1})"}) {
    const auto bad = devices::haply::parse(
        std::string(R"({"inverse3":[{"device_id":"049D","state":{"transform":{)") + wrong +
        "}}}]}");
    REQUIRE(bad);
    CHECK_FALSE(bad->devices.at(0).workspace->valid());
  }
}
