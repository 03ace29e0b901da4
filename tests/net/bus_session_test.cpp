#include "net/bus_node.hpp"
#include "net/bus_topic.hpp"
#include "net/osc.hpp"
#include "tests/net/bytes.hpp"

#include <doctest/doctest.h>

#include <cmath>

/// Both ends of a bus link in a time of their own, over a line that can hesitate and be cut.
using namespace tactus;
using namespace tactus::net;

namespace {

constexpr double kTick_s = 1e-3;
constexpr std::string_view kToken = "sixteen bytes ok";

/// One end with the patch's side of its exchange.
struct End {
  explicit End(BusSession::Side side, std::string_view token = {})
      : node(side, {side == BusSession::Side::kCaller ? "caller" : "listener", std::string(token)},
             *exchange) {}

  struct Received {
    std::string text;
    double sent_s;
    bool late;
  };
  void take() {
    for (auto& incoming : exchange->incoming)
      while (const auto packet = incoming.ring.front()) {
        Message message;
        REQUIRE(decode_osc(packet->bytes, message).empty());
        received.push_back({to_text(message), packet->time_s, packet->late});
        incoming.ring.pop();
      }
  }
  void send(const Message& topic, double sent_s) {
    std::array<std::uint8_t, kMaxSent> packet;
    const std::size_t size = encode_osc(topic, packet);
    REQUIRE(size > 0);
    REQUIRE(exchange->outgoing.push(sent_s, {packet.data(), size}));
  }
  [[nodiscard]] std::vector<BusExchange::Notice> notices() const {
    std::vector<BusExchange::Notice> taken;
    static_cast<void>(exchange->try_take(taken));
    return taken;
  }
  [[nodiscard]] bool alive() const { return id && node.connected(*id); }

  std::unique_ptr<BusExchange> exchange = std::make_unique<BusExchange>();
  BusNode node;
  std::optional<BusNode::ClientId> id{};
  std::vector<Received> received{};
};

/// Two ends and what is on its way between them.
struct Link {
  explicit Link(std::string_view listener_token = {}, std::string_view caller_token = {})
      : listener(BusSession::Side::kListener, listener_token),
        caller(BusSession::Side::kCaller, caller_token) {
    connect();
  }
  void connect() {
    listener.id = listener.node.connect("127.0.0.1", listener_time());
    caller.id = caller.node.connect("127.0.0.1", now_s);
    to_listener.clear();
    to_caller.clear();
  }
  struct Piece {
    double due_s;
    Bytes bytes;
  };
  [[nodiscard]] double listener_time() const { return now_s + ahead_s; }

  void carry(End& from, std::vector<Piece>& pipe) const {
    if (!from.alive() || withheld)
      return;
    OutQueue& out = from.node.out(*from.id);
    if (out.size() > 0)
      pipe.push_back({now_s + delay_s, Bytes(out.front().begin(), out.front().end())});
    out.consume(out.size());
  }
  void bring(std::vector<Piece>& pipe, End& to, double time_s) const {
    while (!stalled && !pipe.empty() && pipe.front().due_s <= now_s) {
      const Bytes bytes = std::move(pipe.front().bytes);
      pipe.erase(pipe.begin());
      if (to.alive())
        to.node.receive(*to.id, bytes, time_s);
    }
  }
  void tick() {
    now_s += kTick_s;
    caller.node.advance(now_s);
    listener.node.advance(listener_time());
    carry(caller, to_listener);
    carry(listener, to_caller);
    bring(to_listener, listener, listener_time());
    bring(to_caller, caller, now_s);
    for (End* end : {&listener, &caller})
      if (end->alive() && end->node.closing(*end->id) && end->node.out(*end->id).size() == 0)
        end->node.disconnect(*end->id);
    listener.take();
    caller.take();
  }
  void run(double seconds) {
    for (const double until_s = now_s + seconds; now_s < until_s;)
      tick();
  }

  double now_s = 100, ahead_s = 5000, delay_s = 0.02;
  bool stalled = false;  ///< on the line, as a lost segment does
  bool withheld = false; ///< in the queue, as a peer that does not read
  End listener, caller;
  std::vector<Piece> to_listener{}, to_caller{};
};

Message hit(int number) {
  return Message(Address::kTopic, "hit").real(0).string("disk").real(number);
}
Message hand(int number) { return Message(Address::kTopic, "hand").real(0).real(number); }

/// A peer that sends single messages of the protocol to a listener.
struct RawPeer {
  explicit RawPeer(std::string_view token = {}) : end(BusSession::Side::kListener, token) {
    connect();
  }
  void connect() {
    if (end.alive())
      end.node.disconnect(*end.id);
    end.id = end.node.connect("192.0.2.1", now_s);
  }
  void say(const Message& message) { say(frame(Framing::kSlip, message)); }
  void say(const Bytes& bytes) {
    if (end.alive())
      end.node.receive(*end.id, bytes, now_s);
  }
  /// All that the listener has answered since.
  [[nodiscard]] std::string answer() {
    OutQueue& out = end.node.out(*end.id);
    const Bytes bytes(out.front().begin(), out.front().end());
    out.consume(out.size());
    std::string text;
    for (const std::string& line : read_all(bytes))
      text += line + "\n";
    return text;
  }
  void hello(std::string_view token = {}) {
    say(Message(Address::kHello).integer(1).string("stranger").string("bus").string(token));
  }
  [[nodiscard]] bool closing() const { return end.node.closing(*end.id); }
  double now_s = 10;
  End end;
};

Message topic(std::string_view name, int sequence, std::uint32_t stamp) {
  return Message(Address::kTopic, name)
      .integer(sequence)
      .integer(static_cast<std::int32_t>(stamp))
      .real(0);
}

} // namespace

TEST_CASE("messages pass both ways with their fields, and times in the receiver's clock") {
  Link link;
  link.run(0.5);
  REQUIRE(link.caller.exchange->ready == 1);
  REQUIRE(link.listener.exchange->ready == 1);
  const double sent_s = link.now_s;
  link.caller.send(Message(Address::kTopic, "model").string("add").string("disk").real(0.5),
                   sent_s);
  link.caller.send(hit(7), sent_s);
  link.listener.send(Message(Address::kTopic, "publish"), link.listener_time());
  link.run(0.1);
  REQUIRE(link.listener.received.size() == 2);
  CHECK(link.listener.received[0].text == "model 'add' 'disk' 0.500000");
  CHECK(link.listener.received[1].text == "hit 0.000000 'disk' 7.000000");
  for (const auto& received : link.listener.received)
    CHECK(received.sent_s == doctest::Approx(sent_s + link.ahead_s).epsilon(1e-7));
  REQUIRE(link.caller.received.size() == 1);
  CHECK(link.caller.received[0].sent_s == doctest::Approx(sent_s).epsilon(1e-5));
  CHECK(link.listener.exchange->incoming[0].transit_s == doctest::Approx(0.02).epsilon(0.1));
}

TEST_CASE("nothing is sent before clocks are known, and news tells when") {
  Link link;
  link.caller.send(hit(1), link.now_s);
  link.run(0.095); // the first pong came at 80 ms, two clocks come each 10 ms
  CHECK(link.caller.exchange->ready == 0);
  link.run(1);
  CHECK(link.listener.received.empty());
  const auto notices = link.listener.notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0].what == BusExchange::Notice::What::kConnected);
  CHECK(notices[0].text == "caller");
}

namespace {

/// Plays 1000 events and 3000 positions a second over a line that stalls twice for so long.
void stall(double seconds, double between_s) {
  Link link;
  link.run(0.5);
  int number = 0;
  const auto play = [&](double play_s) {
    for (const double until_s = link.now_s + play_s; link.now_s < until_s; link.tick())
      for (int i = 0; i < 3; ++i) {
        link.caller.send(hand(number), link.now_s);
        if (i == 0)
          link.caller.send(hit(++number), link.now_s);
      }
  };
  for (bool* const fault : {&link.stalled, &link.withheld}) {
    play(between_s);
    *fault = true;
    play(seconds);
    *fault = false;
  }
  play(between_s);
  link.run(1);
  int events = 0, hands = 0;
  for (const auto& received : link.listener.received)
    if (!received.text.starts_with("hit"))
      ++hands;
    else if (received.text != to_text(hit(++events)))
      FAIL(received.text << " came as number " << events);
  CHECK(events == number);
  CHECK(hands < 3 * events);
  CHECK(link.caller.node.session(0).dropped() > 0);
  CHECK(link.listener.node.session(0).lost_events() == 0);
}

} // namespace

TEST_CASE("a line that stalls loses no event, whatever it loses of streams") { stall(0.5, 0.1); }

TEST_CASE("a line that stalls for half of the time until it is given up loses no event" *
          doctest::test_suite("slow")) {
  stall(2.5, 1);
}

TEST_CASE("a burst above the rate, as after a stall, costs streams alone") {
  RawPeer raw_peer;
  raw_peer.hello();
  for (int i = 1; i <= 20000; ++i) {
    raw_peer.say(topic("hit", i, 0));
    raw_peer.say(topic("hand", i, 0));
    if (i % 1000 == 0)
      raw_peer.end.take();
  }
  raw_peer.end.take();
  std::size_t hits = 0, hands = 0;
  for (const auto& received : raw_peer.end.received)
    (received.text.starts_with("hit") ? hits : hands) += 1;
  CHECK(hits == 20000);
  CHECK(hands <= 5000);
  CHECK(hands > 1000);
  CHECK(raw_peer.answer().find("5000 packets a second") != std::string::npos);
  CHECK_FALSE(raw_peer.closing());
}

TEST_CASE("a patch that takes nothing ends the connection before an event is lost") {
  RawPeer raw_peer;
  raw_peer.hello();
  int sent = 0;
  for (; sent < 100000 && !raw_peer.closing(); ++sent)
    raw_peer.say(topic("hit", sent + 1, 0));
  CHECK(raw_peer.closing());
  CHECK(raw_peer.answer().find("bye 'busy'") != std::string::npos);
  raw_peer.end.take();
  CHECK(raw_peer.end.received.size() ==
        static_cast<std::size_t>(sent - 1)); // all but the refused one
}

TEST_CASE("streams that the patch does not take leave half of the room to events") {
  RawPeer raw_peer;
  raw_peer.hello();
  for (int i = 0; i < 20000; ++i) {
    raw_peer.say(topic("hand", 0, 0));
    raw_peer.now_s += 1e-3;
  }
  CHECK_FALSE(raw_peer.closing());
  CHECK(raw_peer.end.node.session(0).dropped() > 0);
  for (int i = 1; i <= 5000; ++i)
    raw_peer.say(topic("hit", i, 0));
  CHECK_FALSE(raw_peer.closing());
}

TEST_CASE("events that the patch could not hand over end the connection, too") {
  Link link;
  link.run(0.5);
  link.caller.exchange->overflowed = true;
  link.run(0.1);
  CHECK_FALSE(link.caller.alive());
  CHECK_FALSE(link.listener.alive());
  CHECK(link.listener.node.last_reason() == "the peer closed the connection: busy");
}

TEST_CASE("what the other side would drop is not sent: no flood is complained of") {
  Link link;
  link.run(0.5);
  for (int i = 0; i < 10000; ++i) {
    link.caller.send(hand(i), link.now_s);
    if (i % 20 == 0)
      link.tick();
  }
  link.run(0.1);
  CHECK(link.caller.node.session(0).dropped() > 1000);
  CHECK(link.listener.received.size() > 4000);
  for (const auto& notices : link.caller.notices())
    CHECK(notices.what != BusExchange::Notice::What::kWarning);
}

TEST_CASE("a peer that does not read is given up when a megabyte of events waits") {
  Link link;
  link.run(0.5);
  link.withheld = true;
  int number = 0;
  while (link.caller.alive() && !link.caller.node.closing(*link.caller.id) && number < 100000) {
    for (int i = 0; i < 10; ++i)
      link.caller.send(hit(++number), link.now_s);
    link.tick();
  }
  CHECK(number > 10000);
  CHECK(number < 30000);
  CHECK(link.caller.node.out(0).size() <= OutQueue::kCapacity);
}

TEST_CASE("half a second of silence is late, five end the connection, and it can be taken up") {
  Link link;
  link.run(1);
  static_cast<void>(link.caller.notices());
  link.stalled = true;
  link.run(0.22); // a ping may have come a quarter of a second before
  CHECK(link.caller.notices().empty());
  link.run(0.4);
  auto notices = link.caller.notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0].what == BusExchange::Notice::What::kLate);
  link.stalled = false;
  link.run(0.3);
  notices = link.caller.notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0].what == BusExchange::Notice::What::kBack);
  link.stalled = true;
  link.run(4.6);
  CHECK(link.caller.alive());
  link.run(0.6);
  CHECK_FALSE(link.caller.alive());
  CHECK(link.caller.node.last_reason() == "received nothing for 5 s");
  CHECK(link.caller.exchange->ready == 0);
  link.stalled = false;
  link.run(0.1);
  link.connect();
  link.run(0.5);
  CHECK(link.caller.exchange->ready == 1);
}

TEST_CASE("the right token enters, a wrong one does not; before hello nothing is taken") {
  Link link(kToken, kToken);
  link.run(0.5);
  CHECK(link.caller.exchange->ready == 1);
  RawPeer raw_peer(kToken);
  for (const Address word : {Address::kError, Address::kBye}) {
    raw_peer.say(Message(word).string("typed").string("typed"));
    raw_peer.end.node.advance(raw_peer.now_s);
    CHECK(raw_peer.end.notices().empty());
  }
  raw_peer.connect();
  for (int i = 0; i < 20; ++i) { // however alive it seems
    CHECK_FALSE(raw_peer.closing());
    raw_peer.now_s += 0.1;
    raw_peer.say(Message(Address::kError).string("busy").string("wait"));
    raw_peer.end.node.advance(raw_peer.now_s);
  }
  raw_peer.end.node.advance(raw_peer.now_s += 0.01);
  CHECK(raw_peer.closing());
  End caller(BusSession::Side::kCaller);
  const auto id = caller.node.connect("127.0.0.1", 10);
  caller.node.receive(
      id, frame(Framing::kSlip, Message(Address::kError).string("x").string("typed")), 10);
  const auto said = caller.notices();
  REQUIRE(said.size() == 1);
  CHECK(said[0].text == "the connection was refused");
  raw_peer.connect();
  raw_peer.say(topic("hit", 1, 0));
  CHECK(raw_peer.answer().find("send hello first") != std::string::npos);
  raw_peer.say(Message(Address::kPing).integer(1).integer(2));
  CHECK(raw_peer.answer().find("send hello first") != std::string::npos);
  raw_peer.end.take();
  CHECK(raw_peer.end.received.empty());
  raw_peer.hello("sixteen bytes no"); // lock-outs are the server's tests
  CHECK(raw_peer.answer().find("error 'token'") != std::string::npos);
  CHECK(raw_peer.closing());
}

TEST_CASE("messages that are wrong are answered with what was expected, and twenty end it") {
  struct Case {
    Message message;
    std::string_view expected;
  };
  const Message nameless(Address::kTopic, "a topic with blanks");
  for (const Case& one :
       {Case{Message(Address::kTopic, "hit").real(0.5).real(0), "two integers first"},
        {Message(Address::kTopic, "hit"), "two integers first"},
        {Message(nameless).integer(1).integer(0), "letters, digits"},
        {Message(Address::kTopic, "hit").integer(1).integer(0).string("disk"), "time"},
        {Message(Address::kPing).integer(1), "integers of us"},
        {Message(Address::kPong).integer(1).integer(1).string("x"), "integers of us"},
        {Message(Address::kHello).integer(1).string("a").string("bus"), "once"},
        {Message(Address::kWelcome).integer(1).string("a"), "hello"},
        {Message(Address::kForce).real(1).real(2).real(3), "expected ping, pong"}}) {
    RawPeer raw_peer;
    raw_peer.hello();
    static_cast<void>(raw_peer.answer());
    for (int i = 0; i < 20; ++i) {
      CHECK_FALSE(raw_peer.closing());
      raw_peer.say(one.message);
      CHECK((i > 0 || raw_peer.answer().find(one.expected) != std::string::npos));
    }
    CHECK(raw_peer.closing());
    raw_peer.end.take();
    CHECK(raw_peer.end.received.empty());
  }
}

TEST_CASE("who says hello in another role or an older protocol is told") {
  RawPeer control;
  control.say(Message(Address::kHello).integer(1).string("a").string("control"));
  CHECK(control.answer().find("expected the role bus") != std::string::npos);
  RawPeer old;
  old.say(Message(Address::kHello).integer(0).string("a").string("bus"));
  CHECK(old.answer().find("protocol version 1") != std::string::npos);
  CHECK(old.closing());
  RawPeer newer;
  newer.say(Message(Address::kHello).integer(9).string("a").string("bus"));
  CHECK(newer.answer().find("welcome 1.000000 'listener'") != std::string::npos);
}

TEST_CASE("a gap in the numbers of events is counted and said") {
  RawPeer raw_peer;
  raw_peer.hello();
  raw_peer.say(topic("hit", 1, 0));
  raw_peer.say(topic("hand", 1, 0));
  raw_peer.say(topic("hit", 2, 0));
  CHECK(raw_peer.end.node.session(0).lost_events() == 0);
  raw_peer.say(topic("hit", 0, 0)); // does not count
  raw_peer.say(topic("hit", 5, 0));
  CHECK(raw_peer.end.node.session(0).lost_events() == 2);
  CHECK(raw_peer.answer().find("error 'sequence'") != std::string::npos);
  raw_peer.say(topic("hit", 1, 0)); // begins again
  raw_peer.say(Message(Address::kTopic, "hit").real(1e6).integer(0).real(0).string("disk"));
  CHECK(raw_peer.end.node.session(0).lost_events() == 2);
  CHECK(raw_peer.answer().find("restart at 1") != std::string::npos);
}

TEST_CASE("whatever time a message claims, it was sent before it came") {
  RawPeer raw_peer;
  raw_peer.hello();
  for (const std::uint32_t stamp : {0u, 1u, 0x7fffffffu, 0x80000000u, 0xffffffffu, 12345678u}) {
    raw_peer.now_s += 0.7; // beyond the offset's warm-up
    raw_peer.say(Message(Address::kPing)
                     .integer(1)
                     .integer(static_cast<std::int32_t>(stamp))
                     .integer(static_cast<std::int32_t>(~stamp)));
    raw_peer.say(topic("hit", 0, stamp));
    raw_peer.end.take();
    CHECK(raw_peer.end.received.back().sent_s <= raw_peer.now_s);
    CHECK(std::isfinite(raw_peer.end.received.back().sent_s));
    CHECK(raw_peer.end.exchange->incoming[0].delay_s <= PlayoutDelay::kMax_s);
  }
}

TEST_CASE("late is what came after its playout time, and a fixed delay is kept") {
  Link link;
  link.listener.exchange->playout_s = 0.05;
  link.run(1);
  link.delay_s = 0.04;
  link.caller.send(hand(1), link.now_s);
  link.run(0.3);
  link.delay_s = 0.08;
  link.caller.send(hand(2), link.now_s);
  link.run(0.3);
  REQUIRE(link.listener.received.size() == 2);
  CHECK_FALSE(link.listener.received[0].late);
  CHECK(link.listener.received[1].late);
  CHECK(link.listener.exchange->incoming[0].delay_s == 0.05);
}

TEST_CASE("text and length framing are answered in kind") {
  RawPeer text;
  text.say(bytes_of("hap hello 1 script bus;\n"));
  CHECK(text.answer().find("welcome 1.000000 'listener'") == 0);
  text.say(bytes_of("bus hit 1 0 0 disk 25;\n"));
  text.say(bytes_of("bus 7 2 0 0;\n"));
  text.end.take();
  REQUIRE(text.end.received.size() == 2);
  CHECK(text.end.received[0].text == "hit 0.000000 'disk' 25.000000");
  CHECK(text.end.received[1].text == "7 0.000000");
  RawPeer length;
  length.say(
      frame(Framing::kLength, Message(Address::kHello).integer(1).string("script").string("bus")));
  CHECK(length.answer().find("welcome") == 0);
}

TEST_CASE("which topics are events, and which have a time") {
  for (const std::string_view name : {"hit", "release", "excite", "button", "rawbutton", "grip"})
    CHECK((bus_topic(name).is_event && bus_topic(name).has_time));
  for (const std::string_view name : {"model", "table", "quit", "publish", "anything"})
    CHECK((bus_topic(name).is_event && !bus_topic(name).has_time));
  for (const std::string_view name : {"raw", "hand", "contact", "force", "listener"})
    CHECK((!bus_topic(name).is_event && bus_topic(name).has_time));
  CHECK(is_topic_name("raw-2_B"));
  for (const std::string_view name :
       {"", "a b", "a/b", "a.b", "0123456789012345678901234567890123"})
    CHECK_FALSE(is_topic_name(name));
}
