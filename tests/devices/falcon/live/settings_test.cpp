#include "tests/devices/falcon/live/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

using namespace tactus::devices::falcon;
using tactus::haptic::State;
using tactus::haptic::Vec3;

TEST_CASE("a Falcon has the limits that CHAI3D gives it, and the step of its encoders") {
  Rig rig;
  const tactus::haptic::Caps caps = rig.falcon.caps();
  CHECK(caps.peak_force_n == 8);
  CHECK(caps.stiffness_limit_n_per_m == 3000);
  CHECK(caps.damping_limit_n_s_per_m == 20);
  CHECK(caps.workspace_min == Vec3{-0.04, -0.04, -0.04});
  CHECK(caps.workspace_max == Vec3{0.04, 0.04, 0.04});
  CHECK(caps.position_noise_m == position_error_m());
  CHECK(caps.has_velocity);
  CHECK(caps.has_buttons);
  CHECK(caps.needs_home);
  CHECK_FALSE(rig.step()); // nothing is open
  CHECK_FALSE(rig.falcon.write({}));
  CHECK(rig.falcon.trouble().empty());
}

TEST_CASE("the light is red until it is homed, then green, or what was asked for") {
  Rig rig;
  REQUIRE(rig.open() == "");
  rig.control.ask("unhome");
  REQUIRE(rig.until([&] { return !rig.homed(); }));
  for (const auto& [words, flags] :
       std::vector<std::pair<std::vector<std::string>, int>>{{{"led", "blue"}, 4},
                                                             {{"led", "auto"}, 2},
                                                             {{"led", "off"}, 0},
                                                             {{"led", "green", "red"}, 10},
                                                             {{"led", "red", "green", "blue"}, 14},
                                                             {{"led", "red"}, 8}}) {
    REQUIRE(rig.set(words) == "");
    REQUIRE(rig.home());
    CHECK(rig.until([&, wanted = flags] { return rig.control.value("flags") == wanted; }));
  }
  REQUIRE(rig.set({"home"}) == ""); // red, whatever was asked for, and the order to home
  CHECK(rig.until([&] { return rig.control.value("flags") == 9; }));
}

TEST_CASE("the order to home lasts a tenth of a second at least, without force") {
  Rig rig;
  rig.control.ask("still");
  REQUIRE(rig.open() == "");
  REQUIRE(rig.home());
  REQUIRE(rig.set({"calibrate"}) == "");
  const double asked_s = Rig::now_s();
  rig.step({0, 0, 2});
  CHECK_FALSE(rig.homed());
  double sum_s = 0;
  for (int i = 0; i < 30000 && !rig.homed(); ++i) {
    const double before_s = rig.tick.time_s;
    rig.step({0, 0, 2});
    sum_s += std::min(rig.tick.time_s - before_s, 0.1);
  }
  CHECK(rig.homed());
  CHECK(sum_s >= 0.098);
  CHECK(Rig::now_s() - asked_s >= 0.098);
}

TEST_CASE("the motors' gain is what was said, and their order in proportion to it") {
  Rig rig;
  rig.control.ask("still");
  REQUIRE(rig.open() == "");
  REQUIRE(rig.home());
  const Vec3 force{0, 0, 1};
  const auto motors_at = [&](const std::string& gain) {
    REQUIRE(rig.set({"gain", gain}) == "");
    CHECK(rig.until(
        [&] {
          const Forward found =
              forward(motor_angles({static_cast<std::int16_t>(rig.control.value("count0")),
                                    static_cast<std::int16_t>(rig.control.value("count1")),
                                    static_cast<std::int16_t>(rig.control.value("count2"))}));
          const Counts expected = motor_counts(torques(found.position, force), std::stod(gain));
          bool right = found.found;
          for (int i = 0; i < 3; ++i)
            right = right && std::abs(rig.control.value("motor" + std::to_string(i)) -
                                      expected[static_cast<std::size_t>(i)]) <= 5;
          return right;
        },
        30000, force));
  };
  motors_at("10000");
  motors_at("20000");
  motors_at("1000");
  for (const char* gain : {"1000", "100000"})
    CHECK(rig.set({"gain", gain}) == "");
  for (const char* gain : {"999", "100001", "-10000", "inf", ""})
    CHECK(rig.set({"gain", gain}).find("expected 1000 to 100000 motor counts") !=
          std::string::npos);
}

TEST_CASE("firmware of one to 65536 bytes is a file's, and what is misspelt is named") {
  Rig rig;
  rig.control.ask("forget");
  CHECK(rig.open(65537).find("has 65537 bytes; expected 1 to 65536") != std::string::npos);
  CHECK(rig.open(1) == "");
  CHECK(rig.control.value("firmware") == 1);
  rig.falcon.close();
  CHECK(rig.set({}).find("falcon: a setting is not understood") == 0);
  CHECK(rig.set({"reload", "now"}).find("falcon: reload is not understood") == 0);
  CHECK(rig.set({"home", "now"}).find("falcon: home is not understood") == 0);
  CHECK(rig.set({"device"}).find("falcon: device is not understood") == 0);
  CHECK(rig.set({"led", "auto", "red"}).find("falcon: led takes") == 0);
}

TEST_CASE("a Falcon is chosen by its number, serial number or port") {
  Rig rig;
  REQUIRE(rig.open() == "");
  const std::string serial = rig.falcon.identity().serial;
  CHECK(serial == "DOUBLE01");
  CHECK(rig.falcon.identity().vendor == "Novint");
  for (const std::string& which : {std::string("0"), serial, std::string("1-1")}) {
    REQUIRE(rig.set({"device", which}) == "");
    CHECK(rig.open() == "");
  }
  REQUIRE(rig.set({"device", "1"}) == "");
  CHECK(rig.open().find("no Falcon is called 1") != std::string::npos);
}

TEST_CASE("a velocity adds up to the way that the grip goes under a force") {
  bool agrees = false; // stalls of the machine ask for another attempt
  for (int attempt = 0; attempt < 8 && !agrees; ++attempt) {
    Rig rig;
    rig.control.ask("still");
    REQUIRE(rig.open() == "");
    REQUIRE(rig.home());
    REQUIRE(rig.settle());
    const Vec3 begin = rig.state.position;
    Vec3 last = rig.state.velocity, sum{}, at = begin;
    double before_s = rig.tick.time_s;
    int held = 0;
    REQUIRE(rig.until(
        [&] {
          const double passed_s = rig.tick.time_s - before_s;
          before_s = rig.tick.time_s;
          sum += (rig.state.velocity + last) * (0.5 * passed_s);
          last = rig.state.velocity;
          held = norm(rig.state.position - at) < 1e-4 ? held + 1 : 0;
          at = held ? at : rig.state.position;
          return held > 200 && norm(rig.state.position - begin) > 2e-3;
        },
        30000, {0, 0, 2}));
    const Vec3 displacement = rig.state.position - begin;
    CHECK(displacement.z > 2e-3);
    agrees = norm(sum - displacement) < 0.2 * norm(displacement);
  }
  CHECK(agrees);
}
