#include "tests/net/rig.hpp"

/// A force never outlives its sender and never exceeds the server's limit.
using namespace tactus;
using namespace tactus::net;

namespace {

const char* const kPush = "hap force 2 0 0";

/// A client in control whose force of 2 N has come up.
struct ActiveServer {
  Rig rig{usual()};
  TestClient client{rig};
  ActiveServer() {
    client.hello();
    client.send_text("hap start force");
    client.repeat(kPush, 0.8);
    REQUIRE(rig.force_n.x == doctest::Approx(2));
    client.send_text(kPush);
    client.received();
  }
};

} // namespace

TEST_CASE("500 ms of silence end the force; pings alone keep it, bad packets do not") {
  ActiveServer p;
  for (int i = 0; i < 20; ++i) {
    p.rig.run(kPingInterval_s);
    p.client.send_text("hap ping 1");
    CHECK(p.rig.force_n.x == doctest::Approx(2));
  }
  p.rig.run(0.44);
  CHECK(p.rig.force_n.x == doctest::Approx(2));
  p.client.send_text("hap force x 0 0");
  p.rig.run(0.06);
  CHECK(p.rig.force_n == Vec3{});
  CHECK(!p.client.closing());
}

TEST_CASE(
    "neither pings nor a burst after a silence bring a force back; messages that keep coming do") {
  ActiveServer p;
  p.rig.run(0.7);
  p.rig.max_force_n = 0;
  p.client.repeat("hap ping 1", 0.8);
  p.rig.run(0.7);
  for (int i = 0; i < 200; ++i)
    p.client.send_text(kPush);
  p.rig.run(0.4);
  CHECK(p.rig.max_force_n == 0);
  p.client.repeat(kPush, 0.8);
  CHECK(p.rig.force_n.x == doctest::Approx(2));
}

TEST_CASE("messages that a slow line delivers late keep no force up") {
  ActiveServer p;
  const auto server_ms = [&] { // as pong says it
    p.client.received();
    p.client.send_text("hap ping 1");
    for (const std::string& line : p.client.received())
      if (line.starts_with("pong "))
        return std::stoi(line.substr(line.rfind(' ')));
    return -1;
  };
  int seen_ms = server_ms();
  REQUIRE(seen_ms >= 0);
  for (int i = 0; i < 30; ++i) { // a way of 0.6 s there and back
    p.client.send_text("hap ping 2 " + std::to_string(std::max(0, seen_ms - 600)));
    p.client.send_text(kPush);
    p.rig.run(0.1);
    seen_ms = server_ms();
  }
  CHECK(p.rig.force_n.x == doctest::Approx(2));
  for (int i = 0; i < 16; ++i) { // no newer time is seen: all that comes is from before
    p.client.send_text("hap ping 3 " + std::to_string(seen_ms - 600));
    p.client.send_text(kPush);
    p.rig.run(0.1);
  }
  CHECK(p.rig.force_n == Vec3{});
  p.client.received();
  p.client.send_text("hap ping 4 " + std::to_string(seen_ms + 100000));
  CHECK(p.client.has_received("error 'range'"));
  for (int i = 0; i < 10; ++i) {
    seen_ms = server_ms();
    p.client.send_text("hap ping 5 " + std::to_string(seen_ms));
    p.client.send_text(kPush);
    p.rig.run(0.1);
  }
  CHECK(p.rig.force_n.x == doctest::Approx(2));
}

TEST_CASE("a client silent for 5 s is disconnected, not one that pings") {
  Rig rig(usual());
  TestClient silent(rig), pinging(rig);
  silent.hello();
  pinging.hello("observe");
  for (int i = 0; i < 49; ++i) {
    rig.run(0.1);
    pinging.send_text("hap ping 1");
    pinging.received();
  }
  CHECK(!silent.closing());
  rig.run(0.11);
  CHECK(silent.closing());
  CHECK(silent.has_received("bye 'timeout'"));
  CHECK(!pinging.closing());
}

TEST_CASE("a controlling client that was disconnected controls no more") {
  ActiveServer p;
  p.rig.run(5.2);
  CHECK(p.client.closing());
  CHECK(!p.rig.server.servo_command().running);
  TestClient next(p.rig);
  next.hello();
  next.send_text("hap start force");
  CHECK(p.rig.server.servo_command().running);
}

TEST_CASE("stop and a lost connection end the force within milliseconds") {
  ActiveServer stopped;
  stopped.client.send_text("hap stop");
  stopped.rig.run(0.005);
  CHECK(stopped.rig.force_n == Vec3{});
  ActiveServer lost;
  lost.client.disconnect();
  lost.rig.run(0.005);
  CHECK(lost.rig.force_n == Vec3{});
}

TEST_CASE("the motors are off until start, and rise over half a second") {
  Rig rig(usual());
  CHECK(rig.servo.exchange().motors.request().paused);
  rig.run(0.1);
  CHECK(rig.servo.exchange().motors.request().paused);
  ActiveServer p;
  p.client.send_text("hap stop");
  p.rig.run(0.1);
  p.rig.max_force_n = 0;
  p.client.repeat(kPush, 1);
  CHECK(p.rig.max_force_n == 0);
  p.client.send_text("hap start force");
  p.client.send_text(kPush);
  p.rig.run(0.25);
  CHECK(p.rig.force_n.x == doctest::Approx(1).epsilon(0.1));
}

TEST_CASE("a client can lower the force limit and never raise it") {
  ActiveServer p;
  p.rig.max_force_n = 0;
  p.client.send_text("hap forcemax 100");
  CHECK(p.client.has_received("status 'forcemax' 3.0"));
  for (int i = 0; i < 10; ++i) {
    p.client.send_text("hap force 1e30 -1e30 1e30");
    p.rig.run(0.02);
  }
  CHECK(norm(p.rig.force_n) == doctest::Approx(3));
  CHECK(p.rig.max_force_n <= 3 * (1 + 1e-12));
  p.client.send_text("hap forcemax 0.5");
  p.rig.run(0.05);
  CHECK(norm(p.rig.force_n) <= 0.5 * (1 + 1e-12));
  p.client.send_text("hap forcemax -1");
  CHECK(p.client.has_received("error 'range'"));
  p.client.send_text("hap stop"); // the limit was this client's own
  TestClient other(p.rig);
  other.hello();
  other.send_text("hap start force");
  other.repeat(kPush, 0.8);
  CHECK(p.rig.force_n.x == doctest::Approx(2));
}

TEST_CASE("an emergency stop at the server ends control, and no client releases it") {
  ActiveServer p;
  p.rig.servo.exchange().motors.emergency_stop();
  p.rig.run(0.002);
  CHECK(p.rig.force_n == Vec3{});
  CHECK(p.client.has_received("status 'stopped' 'estop'"));
  p.client.send_text("hap start force");
  CHECK(p.client.has_received("error 'estop'"));
  p.rig.max_force_n = 0;
  p.client.repeat(kPush, 1);
  p.rig.servo.exchange().motors.enable(); // somebody at the device
  p.client.repeat(kPush, 1);              // start is still missing
  CHECK(p.rig.max_force_n == 0);
  p.client.send_text("hap start force");
  p.client.send_text(kPush);
  p.rig.run(0.4);
  CHECK(p.rig.force_n.x > 1);
}

namespace {

/// A device that says once that it has failed.
struct Failing final : haptic::Backend {
  haptic::SimulatedDevice simulated;
  bool fail = false;
  std::string open() override { return {}; }
  void close() noexcept override {}
  haptic::Caps caps() const noexcept override { return simulated.caps(); }
  bool read(const haptic::Tick& tick, haptic::State& state) noexcept override {
    const bool answered = simulated.read(tick, state);
    if (fail)
      state.flags |= haptic::State::kFault;
    return answered;
  }
  bool write(const Vec3& force_n) noexcept override { return simulated.write(force_n); }
};

} // namespace

TEST_CASE("a fault of the device ends control; a new start tries again") {
  Rig rig(usual());
  Failing device;
  rig.servo.attach(device, &rig.model);
  TestClient client(rig);
  client.hello();
  client.send_text("hap start force");
  const auto push = [&] {
    client.repeat(kPush, 0.8);
    return rig.force_n.x;
  };
  CHECK(push() == doctest::Approx(2).epsilon(0.3));
  device.fail = true;
  rig.run(0.003);
  device.fail = false;
  CHECK(rig.force_n == Vec3{});
  CHECK(client.has_received("status 'stopped' 'fault'"));
  CHECK(push() == 0);
  client.send_text("hap start force");
  CHECK(push() > 1);
}

TEST_CASE("a servo without its server ends the force by itself") {
  ActiveServer p;
  for (int i = 1; i <= 600; ++i) { // the thread of the network hangs
    p.rig.servo.step({p.rig.ticks + static_cast<std::uint64_t>(i),
                      p.rig.now_s + static_cast<double>(i) * 1e-3, 1e-3});
    if (i >= 500)
      CHECK(p.rig.servo.chain().written == Vec3{});
  }
}

TEST_CASE("feedback becomes a spring at the anchor") {
  auto [rig, client] = Served();
  rig.hold({0.013, 0, 0});
  client.send_text("hap gains 0 400 0 4");
  client.send_text("hap anchor 10 0 0");
  client.send_text("hap start spring");
  for (int i = 0; i < 10; ++i) {
    client.send_text("hap feedback " + std::to_string(i) + " 0.5");
    rig.run(0.1);
  }
  CHECK(rig.force_n.x == doctest::Approx(-0.6)); // P21
  client.send_text("hap feedback 10 1 0 0");
  rig.run(0.2);
  CHECK(rig.force_n.x == doctest::Approx(-1.2));
  client.send_text("hap stop");
  rig.run(0.01);
  CHECK(rig.force_n == Vec3{});
}

TEST_CASE("without an anchor the spring begins where the handle is") {
  Rig rig(usual());
  rig.hold({0.02, 0.01, 0});
  rig.run(0.01);
  TestClient client(rig);
  client.hello();
  client.send_text("hap gains 100 100 0 0");
  client.send_text("hap start spring");
  rig.run(0.4);
  CHECK(norm(rig.force_n) == 0);
  rig.hold({0.02, 0.02, 0});
  client.send_text("hap ping 1");
  rig.run(0.4);
  CHECK(rig.force_n.y == doctest::Approx(-1).epsilon(0.25)); // the motors are still rising
  CHECK(rig.force_n.x == 0);
}

TEST_CASE("a start begins with gamma 0, whatever the last client felt") {
  RenderModel model;
  haptic::State state;
  RenderRequest request;
  request.mode = RenderMode::kSpring;
  request.gains = {0, 100, 0, 0};
  request.anchored = true;
  request.starts = 1;
  request.gamma = {1, 1, 1};
  model.set(request);
  state.position = {0.01, 0, 0};
  static_cast<void>(model.force({1, 1, 1e-3}, state));
  CHECK(model.force({2, 2, 1e-3}, state).x == doctest::Approx(-1));
  request.starts = 2;
  request.gamma = {};
  model.set(request);
  CHECK(model.force({3, 2.001, 1e-3}, state) == Vec3{});
}

TEST_CASE("gains are cut to what the device renders stably, and said") {
  auto [rig, client] = Served();
  client.received();
  client.send_text("hap gains 100 100000 1 1000");
  CHECK(client.received().front() == "status 'gains' 100.000000 500.000000 1.000000 5.000000");
  client.send_text("hap gains 100 50 0 0");
  CHECK(client.has_received("error 'range'"));
  client.send_text("hap gains -1 50 0 0");
  CHECK(client.has_received("error 'range'"));
}

TEST_CASE("sequence numbers: older ones are ignored, a jump back is bad") {
  ActiveServer p;
  const auto force = [&](int sequence, int x) {
    p.client.send_text("hap force " + std::to_string(sequence) + " " + std::to_string(x) + " 0 0");
    return p.rig.server.servo_command().force_n.x;
  };
  CHECK(force(5000, 1) == 1);
  CHECK(force(4999, 2) == 1);
  CHECK(force(5000, 2) == 1);
  CHECK(force(4000, 2) == 1);
  CHECK(!p.client.has_received("error"));
  CHECK(force(3999, 2) == 1);
  CHECK(p.client.has_received("error 'sequence'"));
  CHECK(force(5001, 2) == 2);
  CHECK(force(2147483647, 1) == 1);
  CHECK(force(-2147483647, 2) == 2); // runs over
  CHECK(force(0, 1) == 1);
  CHECK(force(500, 2) == 2);
  CHECK(force(1, 1) == 1); // begins again
  p.client.send_text("hap start force");
  CHECK(force(1, 1) == 1);
  p.client.send_text("hap start spring");
  const auto feedback = [&](int sequence, double gamma) {
    p.client.send_text("hap feedback " + std::to_string(sequence) + " " + std::to_string(gamma));
    return p.rig.server.servo_command().render.gamma.y;
  };
  CHECK(feedback(2000, 0.5) == doctest::Approx(0.5));
  CHECK(feedback(1999, 0.25) == doctest::Approx(0.5));
  p.client.received();
  CHECK(feedback(999, 0.25) == doctest::Approx(0.5));
  CHECK(p.client.has_received("error 'sequence'"));
  CHECK(feedback(2001, 1.5) == doctest::Approx(0.5));
  CHECK(p.client.has_received("error 'range'"));
}

TEST_CASE("a count in Pd's six digits goes on, and what goes to Pd has six digits") {
  Rig rig(usual());
  TestClient client(rig, Framing::kFudi);
  client.hello();
  const auto say = [&](const std::string& line) { client.send_bytes(bytes_of(line + ";")); };
  say("hap start force");
  for (const double x : {1., 2., 1.5}) {
    say("hap force 1e+06 " + std::to_string(x) + " 0 0");
    CHECK(rig.server.servo_command().force_n.x == x);
  }
  say("hap start spring");
  for (const double gamma : {0.25, 0.75, 0.5}) {
    say("hap feedback 1.67772e+07 " + std::to_string(gamma));
    CHECK(rig.server.servo_command().render.gamma.y == gamma);
  }
  client.received();
  say("hap ping 1");
  rig.now_s += 1000.001;
  for (const char* echo : {"", " 475000", " 475713"})
    say("hap ping 2" + std::string(echo));
  CHECK(client.received() ==
        std::vector<std::string>{"pong 1.000000 0.000000", "pong 2.000000 475713.000000",
                                 "pong 2.000000 475713.000000", "pong 2.000000 475713.000000"});
  say("hap ping 3 475813");
  CHECK(client.has_received("error 'range'"));
}

TEST_CASE("wrong arguments are bad packets, and what is not of the mode is refused") {
  ActiveServer p;
  p.client.send_text("hap feedback 1 0.5");
  CHECK(p.client.has_received("error 'stopped'"));
  p.client.send_text("hap start spring");
  p.client.send_text(kPush);
  CHECK(p.client.has_received("error 'stopped'"));
  CHECK(p.rig.server.servo_command().force_n == Vec3{});
  for (const char* line :
       {"hap force 1 2", "hap force", "hap force a b c", "hap force 1 2 3 4 5",
        "hap force 1.5 2 3 4", "hap start", "hap start dance", "hap feedback 1", "hap ping",
        "hap gains 1 2 3", "hap workspace 1 2 3", "hap anchor 1", "hap workspace 1 1 1 0 0 0",
        "hap cp begin", "hap cp set 1", "hap forcemax", "hap subscribe pos", "hap hello 1"}) {
    p.client.send_text(line);
    CHECK_MESSAGE(p.client.has_received("error"), line);
    p.rig.run(0.1);
  }
  CHECK(!p.client.closing());
  CHECK(p.rig.force_n == Vec3{});
}
