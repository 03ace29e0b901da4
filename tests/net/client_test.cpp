#include "net/backoff.hpp"
#include "tests/net/rig.hpp"

/// The client against the server, in a time of their own, over a line that can be cut.
using namespace tactus;
using namespace tactus::net;

TEST_CASE("a client learns what the device is and where its handle is") {
  Line line;
  line.rig.hold({0.01, 0.02, -0.03});
  line.connect();
  line.run(0.01);
  CHECK(line.client.ready());
  const Welcome& welcome = line.client.welcome();
  CHECK(welcome.device == "simulated");
  CHECK(welcome.force_limit_n == 3);
  CHECK(welcome.workspace.max.x == doctest::Approx(0.05));
  CHECK(welcome.stiffness_limit_n_per_m == 500);
  CHECK(norm(line.client.position() - Vec3{0.01, 0.02, -0.03}) < 1e-8);
  line.rig.device.set_button(2, true);
  line.run(0.3);
  CHECK(line.client.buttons() == 4);
  REQUIRE(line.client.round_trip_s().has_value());
  CHECK(*line.client.round_trip_s() <= 0.0021);
}

TEST_CASE("a client has the velocity of the server's servo, however its positions come") {
  Line line;
  line.rig.device.set_path(haptic::LinePath{{-0.02, 0, 0}, {0.02, 0, 0}, 0.2}); // there and back
  line.connect();
  line.run(0.15);
  const double served = line.rig.servo.exchange().reports.latest().state.velocity.x;
  CHECK(std::abs(served) > 0.1);
  CHECK(std::abs(line.client.velocity().x - served) < 0.02 * std::abs(served));
  line.passes = false; // and then much at once, as after a retransmission
  line.run(0.02);
  line.passes = true;
  line.run(0.001);
  CHECK(std::abs(line.client.velocity().x) < 1.1 * std::abs(served));
}

TEST_CASE("its pings keep a force alive, and its silence ends it") {
  Line line;
  line.connect();
  line.run(0.01);
  line.client.start(RenderMode::kForce);
  line.client.send_force({2, 0, 0});
  line.run(3);
  CHECK(line.rig.force_n.x == doctest::Approx(2));
  line.passes = false;
  line.run(0.51);
  CHECK(line.rig.force_n == Vec3{});
}

TEST_CASE("a client says which of the server's times it has seen") {
  Line line;
  line.connect();
  line.run(0.3);
  line.client.start(RenderMode::kForce);
  line.client.send_force({2, 0, 0});
  line.run(1);
  CHECK(line.rig.force_n.x == doctest::Approx(2));
  // From now on the client hears nothing, and what it sends still arrives.
  double last_force_s = 0;
  const double deaf_s = line.rig.now_s;
  for (int i = 0; i < 2500; ++i) {
    line.rig.tick();
    static_cast<void>(line.client.advance(line.rig.now_s));
    line.client.send_force({2, 0, 0});
    line.rig.server.receive(*line.id, Line::taken(line.client.out()), line.rig.now_s);
    Line::taken(line.rig.server.out(*line.id));
    if (norm(line.rig.force_n) > 0)
      last_force_s = line.rig.now_s;
  }
  CHECK(last_force_s - deaf_s <= kMaxAge_s + kSilence_s);
}

TEST_CASE("after a new connection all is set up again but the motors are off until start") {
  Line line;
  ClientSetup setup;
  setup.points = {{0.001, 0, 0}, {0.002, 0, 0}};
  setup.gains = stress::RenderGains{0, 100, 0, 1};
  setup.anchor = Vec3{0.01, 0, 0};
  setup.workspace = haptic::Workspace{{-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}};
  line.client.set(setup);
  line.connect();
  line.run(0.01);
  for (int round = 0; round < 2; ++round) {
    line.client.start(RenderMode::kSpring);
    line.client.send_feedback({1, 1, 1});
    line.run(0.8);
    CHECK(line.rig.force_n.x == doctest::Approx(1)); // 100 N/m, 10 mm
    line.cut();
    line.run(0.01);
    CHECK(line.rig.force_n == Vec3{});
    line.connect();
    line.run(1);
    CHECK(line.client.ready());
    CHECK(!line.client.in_control());
    CHECK(line.rig.force_n == Vec3{});
  }
  line.rig.device.set_button(0, true); // the points are there again, for the client in control
  line.run(0.01);
  line.rig.device.set_button(0, false);
  line.client.start(RenderMode::kSpring);
  line.run(0.01);
  CHECK(line.client.trouble() == "");
}

TEST_CASE("a server that falls silent is given up after two seconds") {
  Line line;
  line.connect();
  line.run(0.5);
  line.passes = false;
  line.run(1.9);
  CHECK(line.wanted);
  line.run(0.2);
  CHECK(!line.wanted);
  CHECK(line.client.trouble() == "the server has stopped sending");
}

TEST_CASE("what does not say welcome is no server") {
  Client client;
  client.connect(10);
  CHECK(client.advance(11.9));
  CHECK(!client.advance(12));
  CHECK(client.trouble() == "no haptic server answers at this address");
  Client other;
  other.connect(10);
  CHECK(!other.receive(bytes_of("HTTP/1.1 400 Bad Request\r\n\r\n;"), 10));
  CHECK(other.trouble().find("not a haptic server") != std::string::npos);
  for (const Address word : {Address::kError, Address::kBye}) { // none of its own words
    other.connect(10);
    static_cast<void>(
        other.receive(frame(Framing::kLength, Message(word).string("typed").string("typed")), 10));
    CHECK(other.trouble() == "the server reports: the connection was refused");
  }
}

TEST_CASE("another in control, an emergency stop and a wrong token are told") {
  Line second;
  second.connect();
  second.run(0.01);
  TestClient first(second.rig);
  first.hello();
  first.send_text("hap start force");
  second.client.start(RenderMode::kForce);
  second.run(0.01);
  CHECK(!second.client.in_control());
  CHECK(second.client.trouble() == "the server reports: another client is in control");
  Line line;
  line.connect();
  line.run(0.01);
  line.client.start(RenderMode::kForce);
  line.run(0.01);
  line.rig.servo.exchange().motors.emergency_stop();
  line.run(0.01);
  CHECK(!line.client.in_control());
  CHECK(line.client.refusals() == 1);
  CHECK(line.client.trouble() == "the server has stopped the motors: estop");
  line.client.start(RenderMode::kForce);
  line.client.send_force({1, 0, 0}); // under way before the refusal comes; its answer is no reason
  line.run(0.01);
  CHECK(line.client.refusals() == 2);
  CHECK(line.client.trouble().find("emergency stop") != std::string::npos);
  ServerSettings guarded = usual();
  guarded.token = "sixteen bytes long";
  Line wrong(guarded, {"n", "another sixteen bytes"});
  wrong.connect();
  wrong.run(0.01);
  CHECK(!wrong.wanted);
  CHECK(wrong.client.trouble() == "the server reports: the token is wrong");
  Line right(guarded, {"n", "sixteen bytes long"});
  right.connect();
  right.run(0.01);
  CHECK(right.client.ready());
}

TEST_CASE("a new connection begins with a new frame") {
  Client client;
  client.connect(1);
  CHECK(client.receive({}, 1));
  const Bytes half{0, 0, 0, 40, '/', 'h'};
  CHECK(client.receive(half, 1));
  client.disconnect();
  client.connect(2);
  const Bytes welcome = frame(
      Framing::kLength,
      Message(Address::kWelcome).integer(1).string("d").string("m").integer(3).real(3).real(1000));
  CHECK(client.receive(welcome, 2));
  CHECK(client.welcome().device == "d");
}

TEST_CASE("pauses between attempts double up to 4 s and are spread by a fifth") {
  double lowest = 9, highest = 0;
  for (std::uint64_t seed = 1; seed < 200; ++seed) {
    Backoff backoff(seed);
    for (const double expected : {0.25, 0.5, 1.0, 2.0, 4.0, 4.0, 4.0}) {
      const double share = backoff.next() / expected;
      CHECK(share >= 0.8);
      CHECK(share <= 1.2);
      lowest = std::min(lowest, share);
      highest = std::max(highest, share);
    }
    backoff.reset();
    CHECK(backoff.next() <= 0.3);
  }
  CHECK(lowest < 0.82);
  CHECK(highest > 1.18);
}
