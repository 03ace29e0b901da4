#include "tests/devices/falcon/live/rig.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

using namespace tactus::devices::falcon;
using tactus::Vec3;
using tactus::haptic::State;

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
       std::vector<std::pair<std::vector<std::string>, int>>{{{"led", "blue"}, 5},
                                                             {{"led", "auto"}, 3},
                                                             {{"led", "off"}, 1},
                                                             {{"led", "green", "red"}, 11},
                                                             {{"led", "red", "green", "blue"}, 15},
                                                             {{"led", "red"}, 9}}) {
    REQUIRE(rig.set(words) == "");
    REQUIRE(rig.home());
    CHECK(rig.until([&, wanted = flags] { return rig.control.value("flags") == wanted; }));
  }
  REQUIRE(rig.set({"home"}) == ""); // red, whatever was asked for; the marks go, then count again
  for (const int flags : {8, 9})
    CHECK(rig.until([&] { return rig.control.value("flags") == flags; }));
  CHECK(rig.until([&] { return !rig.homed() && rig.says("pull the grip out"); }));
}

TEST_CASE("the order to home lasts a tenth of a second at least, without force") {
  Rig rig;
  rig.ready(true);
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

TEST_CASE(
    "encoders give the position, and a force the motors' orders, in proportion to their gain") {
  Rig rig;
  rig.ready(true);
  const Vec3 force{1, 0.5, -2};
  for (const char* gain : {"10000", "20000", "1000"}) {
    REQUIRE(rig.set({"gain", gain}) == "");
    CHECK(rig.until( // the double's hand comes to rest
        [&] {
          const auto count = [&](int i) {
            return static_cast<std::int16_t>(rig.control.value("count" + std::to_string(i)));
          };
          const Forward found = forward(motor_angles({count(0), count(1), count(2)}));
          const Counts expected = motor_counts(torques(found.position, force), std::stod(gain));
          bool right =
              found.found && norm(rig.state.position - (found.position - kCentre)) < 0.1e-3;
          for (int i = 0; i < 3; ++i)
            right = right && std::abs(rig.control.value("motor" + std::to_string(i)) -
                                      expected[static_cast<std::size_t>(i)]) <= 5;
          return right;
        },
        30000, force));
  }
  CHECK(rig.control.value("broken") == 0);
  CHECK(rig.falcon.caps().latency_ticks == 2); // frames of 1 ms and the chip's timer of 1 ms
  rig.control.ask("buttons 5");
  CHECK(rig.until([&] { return rig.state.buttons == 5; }));
  rig.control.ask("buttons 0");
  CHECK(rig.set({"gain", "100000"}) == "");
  for (const char* gain : {"999", "100001", "-10000", "inf", "1e4x", ""})
    CHECK(rig.set({"gain", gain}).find("expected 1000..100000 motor counts") != std::string::npos);
}

TEST_CASE("what is misspelt is named") {
  Rig rig;
  CHECK(rig.set({}).find("falcon: setting nothing: expected") == 0);
  CHECK(rig.set({"probe", "2"}).find("falcon: setting probe: expected") == 0);
  CHECK(rig.set({"reload", "now"}).find("falcon: setting reload: expected") == 0);
  CHECK(rig.set({"home", "now"}).find("falcon: setting home: expected") == 0);
  CHECK(rig.set({"device"}).find("falcon: setting device: expected") == 0);
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"led", "auto", "red"}, {"led"}, {"led", "pink"}, {"led", "off", "red"}})
    CHECK(rig.set(words).find("falcon: led: expected") == 0);
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
  CHECK(rig.open().find("Falcon 1: not found") != std::string::npos);
}

TEST_CASE("a velocity adds up to the way that the grip goes under a force") {
  Rig rig;
  rig.ready(true);
  Vec3 begin{}, last{}, sum{};
  double before_s = 0;
  bool agrees = false;
  for (int i = 0; i < 30000 && !agrees; ++i) {
    rig.step({0, 0, i / 300 % 2 ? -2.0 : 2.0});
    const double passed_s = rig.tick.time_s - before_s;
    if (i % 300 == 0 || passed_s > 10e-3) // the machine stalled: the way in between is not known
      begin = rig.state.position, sum = {};
    else
      sum += (rig.state.velocity + last) * (0.5 * passed_s);
    before_s = rig.tick.time_s;
    last = rig.state.velocity;
    const Vec3 displacement = rig.state.position - begin;
    agrees = norm(displacement) > 2e-3 && norm(sum - displacement) < 0.2 * norm(displacement);
  }
  CHECK(agrees);
}
