#include "tests/net/rig.hpp"

#include <cstdio>

using namespace tactus;
using namespace tactus::net;

TEST_CASE("hello is answered with the device and its limits, and a force obeyed, in each framing") {
  for (const Framing framing : {Framing::kSlip, Framing::kLength, Framing::kFudi}) {
    Rig rig(usual());
    TestClient client(rig, framing);
    client.hello();
    const auto lines = client.received();
    REQUIRE(lines.size() == 3);
    CHECK(lines[0] == "welcome 1.000000 'simulated' '-' 3.000000 3.000000 1000.000000");
    CHECK(lines[1].starts_with("status 'workspace' -50.000000 -50.000000 -50.000000 50.000000"));
    CHECK(lines[2].starts_with("status 'limits' 500.000000 5.000000"));
    client.send_text("hap start force");
    client.send_text("hap force 1 -2 0.5");
    CHECK(rig.server.servo_command().force_n == Vec3{1, -2, 0.5});
    CHECK(rig.server.servo_command().running);
  }
}

TEST_CASE(
    "the first client to start has control; others get 'busy' until it stops or disconnects") {
  Rig rig(usual());
  TestClient first(rig), second(rig);
  first.hello();
  second.hello();
  first.send_text("hap start force");
  second.send_text("hap start force");
  CHECK(second.has_received("error 'busy'"));
  second.send_text("hap force 1 0 0");
  CHECK(second.has_received("error 'stopped'"));
  CHECK(rig.server.servo_command().force_n == Vec3{});
  second.send_text("hap stop"); // not its own
  CHECK(rig.server.servo_command().running);
  first.send_text("hap stop");
  CHECK(!rig.server.servo_command().running);
  second.send_text("hap start spring");
  CHECK(rig.server.servo_command().running);
  first.send_text("hap start force");
  CHECK(first.has_received("error 'busy'"));
  second.disconnect();
  CHECK(!rig.server.servo_command().running);
  first.send_text("hap start force");
  CHECK(rig.server.servo_command().running);
}

TEST_CASE("an observer receives everything and changes nothing") {
  Rig rig(usual());
  TestClient control(rig), observer(rig);
  control.hello();
  observer.hello("observe");
  observer.received();
  for (const char* line :
       {"hap start force", "hap force 1 0 0", "hap cp begin 1", "hap gains 0 1 0 1",
        "hap workspace -1 -1 -1 1 1 1", "hap feedback 1 0.5", "hap anchor 0 0 0", "hap forcemax 1",
        "hap cp clear"}) {
    observer.send_text(line);
    CHECK(observer.has_received("error 'role'"));
  }
  observer.send_text("hap subscribe pos 100");
  control.send_text("hap start force");
  rig.run(0.1);
  const auto lines = observer.received();
  CHECK(std::count_if(lines.begin(), lines.end(),
                      [](const std::string& line) { return line.starts_with("pos "); }) == 10);
  CHECK(lines.front() == "status 'started' 'force' 'test'");
}

TEST_CASE("a type that is not taken is an error, no bad packet and no sign of life") {
  auto [rig, client] = Served();
  client.send_text("hap start force");
  client.send_text("hap force 1 0 0");
  client.received();
  Bytes refused = force_packet();
  refused[14] = 'N'; // of ,fff
  for (int i = 0; i < 100; ++i) {
    client.send_bytes(with_length(refused));
    rig.run(0.01);
  }
  CHECK(client.has_received("error 'bad' 'unsupported type tag"));
  CHECK(!client.closing());
  CHECK(rig.force_n == Vec3{});
  client.send_bytes(with_length(bundle({force_packet()})));
  CHECK(rig.server.servo_command().force_n.y == -2);
}

TEST_CASE("before hello everything else is refused, but for ping where no token is needed") {
  Rig rig(usual());
  TestClient client(rig);
  client.send_text("hap start force");
  CHECK(client.has_received("error 'hello'"));
  client.send_text("hap ping 9");
  CHECK(client.has_received("pong 9.000000"));
  ServerSettings guarded = usual();
  guarded.token = "sixteen bytes long";
  Rig other(guarded);
  TestClient stranger(other);
  stranger.send_text("hap ping 9");
  CHECK(stranger.has_received("error 'hello'"));
}

TEST_CASE("versions: a newer client is sent the server's, an older one is disconnected") {
  Rig rig(usual());
  TestClient newer(rig), older(rig);
  newer.send(Message(Address::kHello).integer(7).string("n").string("control").string(""));
  CHECK(newer.has_received("welcome 1.000000"));
  older.send(Message(Address::kHello).integer(0).string("n").string("control").string(""));
  CHECK(older.has_received("error 'version'"));
  CHECK(older.closing());
}

TEST_CASE("an unknown address and a second hello are answered by an error and ignored") {
  auto [rig, client] = Served();
  client.received();
  for (int i = 0; i < 30; ++i) // no bad packet
    client.send_bytes(with_length(bytes_of(std::string_view("/hap/dance\0\0,\0\0\0", 16))));
  CHECK(client.has_received("error 'unknown' 'dance'"));
  client.send_text("hap welcome 1");
  CHECK(client.has_received("error 'unknown' 'welcome'") == false); // at most 20 errors a second
  rig.run(1);
  client.send_text("hap welcome 1");
  CHECK(client.has_received("error 'unknown' 'welcome'"));
  client.hello();
  CHECK(client.has_received("error 'hello'"));
  CHECK(!client.closing());
}

TEST_CASE("eight clients, not nine") {
  Rig rig(usual());
  std::vector<TestClient> clients;
  for (int i = 0; i < 9; ++i)
    clients.emplace_back(rig).hello();
  CHECK(rig.server.clients() == 8);
  CHECK(clients[8].has_received("error 'full' 'eight clients are already connected'"));
  CHECK(clients[8].closing());
  CHECK(rig.server.take_notices().back() ==
        "127.0.0.1 - refused: eight clients are already connected");
  clients[3].disconnect();
  TestClient next(rig);
  next.hello();
  CHECK(next.has_received("welcome"));
}

TEST_CASE("streams have their rate and skip what they missed") {
  auto [rig, client] = Served();
  rig.hold({0.01, -0.02, 0.03});
  client.received();
  rig.run(0.01);
  client.send_text("hap subscribe pos 250");
  client.send_text("hap subscribe vel 50");
  rig.run(1);
  int positions = 0, velocities = 0;
  for (const std::string& line : client.received()) {
    positions += line.starts_with("pos ");
    velocities += line.starts_with("vel ");
    if (line.starts_with("pos "))
      CHECK(line.ends_with(" 10.000000 -20.000000 30.000000"));
    client.send_text("hap ping 1");
    client.received();
  }
  CHECK(positions == 250);
  CHECK(velocities == 50);
  client.send_text("hap subscribe pos 0");
  rig.run(0.1);
  CHECK(!client.has_received("pos "));
  client.send_text("hap subscribe pos 1001");
  CHECK(client.has_received("error 'range'"));
  client.send_text("hap subscribe smell 10");
  CHECK(client.has_received("error 'range'"));
}

TEST_CASE("control points are replaced as a whole") {
  auto [rig, client] = Served();
  client.send_text("hap start spring");
  for (const auto& [line, answer] : {std::pair{"hap cp begin 2", ""},
                                     {"hap cp set 0 1 2 3", ""},
                                     {"hap cp end", "error 'points'"},
                                     {"hap cp set 0 1 2 3", "error 'points'"},
                                     {"hap cp begin 2", ""},
                                     {"hap cp set 2 1 2 3", "error 'range'"},
                                     {"hap cp set -1 1 2 3", "error 'range'"},
                                     {"hap cp begin 4097", "error 'range'"},
                                     {"hap cp begin 4096", ""}}) {
    client.received();
    client.send_text(line);
    CHECK(client.has_received(*answer ? answer : "error") == (*answer != 0));
  }
}

TEST_CASE("the first button drags the nearest point, within the client's workspace") {
  auto [rig, client] = Served();
  TestClient observer(rig);
  observer.hello("observe");
  client.send_text("hap cp begin 2");
  client.send_text("hap cp set 0 6 0 0");
  client.send_text("hap cp set 1 -4 0 0");
  client.send_text("hap cp end");
  client.send_text("hap workspace -20 -20 -20 20 20 20");
  client.send_text("hap start force");
  rig.run(0.01);
  client.received();
  rig.device.set_button(1, true);
  rig.run(0.01);
  auto lines = client.received();
  CHECK(lines.front() == "button 1.000000 1.000000");
  CHECK(lines.size() == 1);
  rig.device.set_button(0, true);
  rig.run(0.005);
  lines = client.received();
  CHECK(lines[0] == "button 0.000000 1.000000");
  CHECK(lines[1] == "grab 1.000000 1.000000");
  rig.hold({0.01, 0.03, 0});
  rig.run(0.1);
  CHECK(client.has_received("cp/move 1.000000 6.000000 20.000000 0.000000"));
  rig.hold({0.011, 0, 0});
  rig.run(0.001);
  client.received();
  rig.run(0.001);
  rig.device.set_button(0, false);
  rig.run(0.005);
  lines = client.received();
  REQUIRE(lines.size() >= 3);
  CHECK(lines[lines.size() - 2] == "cp/move 1.000000 7.000000 0.000000 0.000000");
  CHECK(lines.back() == "grab 1.000000 0.000000");
  CHECK(observer.has_received("cp/move"));
  // Out of reach: nothing is grabbed. New points end a grab.
  rig.hold({0, 0.04, 0});
  rig.run(0.01);
  rig.device.set_button(0, true);
  rig.run(0.01);
  CHECK(!client.has_received("grab"));
  rig.device.set_button(0, false);
  rig.hold({0.007, 0, 0});
  rig.run(0.01);
  rig.device.set_button(0, true);
  rig.run(0.01);
  CHECK(client.has_received("grab"));
  client.send_text("hap cp clear");
  CHECK(client.has_received("grab 1.000000 0.000000"));
  rig.run(0.1);
  CHECK(!client.has_received("cp/move"));
}

TEST_CASE("a force above the limit is told to every client, and so is its end") {
  Rig rig(usual());
  TestClient client(rig), observer(rig);
  client.hello();
  observer.hello("observe");
  client.send_text("hap start force");
  client.repeat("hap force 2.9 0 0", 0.5);
  CHECK(!observer.has_received("status 'clipped'"));
  client.repeat("hap force 100 0 0", 0.5);
  double asked_n = 0, limit_n = 0;
  for (const std::string& line : observer.received())
    std::sscanf(line.c_str(), "status 'clipped' 1.000000 %lf %lf", &asked_n, &limit_n);
  CHECK(limit_n == 3);
  CHECK(asked_n > 3);
  CHECK(asked_n <= 100);
  CHECK(client.has_received("status 'clipped' 1.000000"));
  const auto clipping = rig.server.take_clipping();
  REQUIRE(clipping);
  CHECK(clipping->on);
  CHECK(clipping->asked_n == doctest::Approx(asked_n));
  CHECK(clipping->limit_n == 3);
  CHECK(!rig.server.take_clipping());
  client.repeat("hap force 1 0 0", 1);
  CHECK(client.has_received("status 'clipped' 0.000000"));
}
