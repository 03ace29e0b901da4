#include "tests/net/rig.hpp"

#include <random>

/// Peers that are broken or mean harm.
using namespace tactus;
using namespace tactus::net;

TEST_CASE("20 bad packets within a second end a connection") {
  Rig rig(usual());
  TestClient fast(rig), slow(rig);
  fast.hello();
  slow.hello();
  for (int i = 0; i < 19; ++i)
    fast.send_text("hap force x 0 0");
  CHECK(!fast.closing());
  fast.send_text("hap force x 0 0");
  CHECK(fast.closing());
  CHECK(fast.has_received("bye 'bad'"));
  for (int i = 0; i < 40; ++i) {
    slow.send_text("hap force x 0 0");
    rig.run(0.06);
  }
  CHECK(!slow.closing());
}

TEST_CASE("a broken frame ends a connection and its force") {
  auto [rig, client] = Served();
  client.send_text("hap start force");
  client.send_bytes({0xFF, 0xFF, 0xFF, 0xFF});
  CHECK(client.has_received("bye 'frame'"));
  CHECK(client.closing());
  CHECK(!rig.server.servo_command().running);
  client.send_text("hap start force");
  CHECK(!rig.server.servo_command().running);
}

TEST_CASE("a flood is cut to 5000 packets a second, and the rest is no sign of life") {
  auto [rig, client] = Served();
  client.send_text("hap start force");
  client.received();
  for (int i = 0; i < 20000; ++i)
    client.send_text("hap force 1 0 0");
  CHECK(rig.server.servo_command().forces < 5010);
  const auto lines = client.received();
  CHECK(std::count_if(lines.begin(), lines.end(), [](const std::string& line) {
          return line.starts_with("error 'flood'");
        }) == 1);
  rig.run(0.1);
  client.send_text("hap force 2 0 0");
  CHECK(rig.server.servo_command().force_n.x == 2);
}

TEST_CASE("a half-sent frame is given 2 s, a byte a second too") {
  Rig rig(usual());
  TestClient half(rig), dribble(rig), good(rig);
  half.hello();
  dribble.hello();
  good.hello();
  const Bytes bytes = frame(Framing::kLength, Message(Address::kPing).integer(1));
  half.send_bytes({bytes.begin(), bytes.begin() + 5});
  for (std::size_t second = 0; second < 3; ++second) {
    dribble.send_bytes({bytes[second]});
    for (int i = 0; i < 10; ++i) {
      good.send_text("hap ping 1");
      half.send_bytes({}); // nothing
      CHECK(half.closing() == (second >= 2));
      rig.run(0.1);
    }
  }
  CHECK(half.has_received("bye 'frame'"));
  CHECK(dribble.closing());
  CHECK(!good.closing());
}

TEST_CASE("frames that come in pieces in time are no half-sent frame") {
  auto [rig, client] = Served();
  const Bytes bytes = frame(Framing::kLength, Message(Address::kPing).integer(1));
  for (int i = 0; i < 60; ++i) { // there is always a frame open
    client.send_bytes({bytes.begin() + (i ? 5 : 0), bytes.end()});
    client.send_bytes({bytes.begin(), bytes.begin() + 5});
    rig.run(0.1);
    client.received();
  }
  CHECK(!client.closing());
}

TEST_CASE("a client that does not read loses positions, never events, and is let go at 1 MiB") {
  auto [rig, client] = Served();
  client.send_text("hap subscribe pos 1000");
  client.received();
  int asked = 0;
  for (int i = 0; i < 3000; ++i) {
    client.send_text("hap ping " + std::to_string(asked++));
    rig.run(0.001);
  }
  CHECK(client.out().dropped() > 1000);
  const auto lines = client.received();
  int pongs = 0;
  for (const std::string& line : lines)
    if (line.starts_with("pong "))
      CHECK(line.starts_with("pong " + std::to_string(pongs++) + "."));
  CHECK(pongs == asked);
  while (!client.closing()) {
    for (int i = 0; i < 4; ++i)
      client.send_text("hap ping 1");
    rig.run(0.001);
    REQUIRE(client.out().size() <= OutQueue::kCapacity);
  }
  CHECK(client.out().size() > OutQueue::kCapacity - 100);
}

TEST_CASE("the queue gives back what went in, in order") {
  OutQueue queue;
  std::mt19937 random(3);
  std::vector<std::uint8_t> in, out;
  for (int i = 0; i < 1000; ++i) {
    Bytes bytes(random() % 3000);
    for (auto& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    if (queue.add_event(bytes))
      in.insert(in.end(), bytes.begin(), bytes.end());
    const auto front = queue.front();
    const std::size_t taken = std::min<std::size_t>(front.size(), random() % 3000);
    out.insert(out.end(), front.begin(), front.begin() + static_cast<std::ptrdiff_t>(taken));
    queue.consume(taken);
  }
  while (queue.size() > 0) {
    out.insert(out.end(), queue.front().begin(), queue.front().end());
    queue.consume(queue.front().size());
  }
  CHECK(in == out);
}

TEST_CASE("tokens: wrong ones are refused, three lock out for ten seconds") {
  ServerSettings settings = usual();
  settings.token = "correct horse battery";
  Rig rig(settings);
  const auto attempt = [&](const std::string& token, std::string_view peer = "10.0.0.1") {
    TestClient client(rig, Framing::kLength, peer);
    client.hello("control", token);
    std::string answer = client.received().front();
    answer = answer.substr(0, answer.find(' ', answer.find(' ') + 1));
    client.disconnect();
    return answer;
  };
  CHECK(attempt("correct horse battery") == "welcome 1.000000");
  CHECK(attempt("") == "error 'token'");
  CHECK(attempt("correct horse batter") == "error 'token'");
  CHECK(attempt("correct horse battery") == "welcome 1.000000"); // begins the count anew
  for (int i = 0; i < 3; ++i)
    CHECK(attempt("correct horse batterycorrect horse battery") == "error 'token'");
  CHECK(attempt("correct horse battery") == "error 'locked'");
  CHECK(attempt("correct horse battery", "10.0.0.2") == "welcome 1.000000");
  rig.run(9.9);
  CHECK(attempt("correct horse battery") == "error 'locked'");
  rig.run(0.2);
  CHECK(attempt("wrong") == "error 'token'");
  CHECK(attempt("correct horse battery") == "welcome 1.000000");
}

TEST_CASE("connections that have not said hello are few and short, whatever they say") {
  ServerSettings settings = usual();
  settings.token = "correct horse battery";
  Rig rig(settings);
  TestClient owner(rig);
  owner.hello("control", settings.token);
  std::vector<TestClient> crowd;
  for (int i = 0; i < 4; ++i, rig.run(0.001))
    crowd.emplace_back(rig, Framing::kLength, "10.0.0.1");
  TestClient other(rig, Framing::kLength, "10.0.0.2"), again(rig, Framing::kLength, "10.0.0.1");
  CHECK(other.id() == crowd[0].id()); // of the crowd's address the first gives way, twice
  CHECK(again.id() == crowd[1].id());
  CHECK(rig.server.clients() == 1);
  for (int i = 0; i < 20; ++i) {
    CHECK(!other.closing());
    other.send_text("hap ping 1");
    owner.send_text("hap ping 1");
    rig.run(0.1);
  }
  CHECK(other.closing());
  CHECK(!owner.closing());
  static_cast<void>(rig.server.take_notices());
  for (int i = 0; i < 100; ++i) {
    TestClient one(rig, Framing::kLength, "10.0.0." + std::to_string(i));
    one.hello("control", "wrong\nwrong");
    one.disconnect();
  }
  CHECK(rig.server.take_notices().size() <= 4); // a log that nobody can fill
}

TEST_CASE("when the table of failures is full, strangers are locked out together") {
  LockOut lock_out;
  for (int peer = 0; peer < 64; ++peer)
    lock_out.fail("peer " + std::to_string(peer), 10);
  CHECK(!lock_out.locked("somebody", 10));
  for (int i = 0; i < 3; ++i)
    lock_out.fail("another " + std::to_string(i), 10);
  CHECK(lock_out.locked("somebody", 10));
  CHECK(!lock_out.locked("peer 3", 10));
  CHECK(!lock_out.locked("somebody", 20));
  lock_out.fail("new", 80); // the old ones are forgotten
  CHECK(!lock_out.locked("somebody", 80));
}

TEST_CASE("the comparison of tokens looks at every byte") {
  CHECK(equal_in_constant_time("abcd", "abcd"));
  for (const char* wrong : {"", "a", "abc", "abcde", "abcx", "xbcd", "abcdabcd", "axcd"})
    CHECK(!equal_in_constant_time("abcd", wrong));
  CHECK(!equal_in_constant_time("", "a"));
}
