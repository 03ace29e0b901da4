#include "net/osc.hpp"
#include "tests/net/rig.hpp"

/// Positions as datagrams: codec, keys, order, and what happens when they are lost.
using namespace tactus;
using namespace tactus::net;

namespace {

Bytes packet(const Message& message) {
  Bytes bytes(kMaxSent);
  bytes.resize(encode_osc(message, bytes));
  return bytes;
}

Message sample(std::int32_t sequence, double x = 1, Address address = Address::kPosition) {
  return Message(address).integer(sequence).integer(5).real(x).real(2).real(3);
}

/// That serves datagrams, to a client that wants them.
struct DatagramLine : Line {
  explicit DatagramLine(bool wants = true, int udp_port = 7770)
      : Line(usual(), own(wants), udp_port) {
    connect();
  }
  static ClientSettings own(bool wants) {
    ClientSettings settings;
    settings.udp = wants;
    return settings;
  }
};

} // namespace

TEST_CASE("sequence numbers are ordered over their wrap") {
  constexpr std::int32_t kLast = 0x7fffffff;
  CHECK(is_newer(1, 0));
  CHECK_FALSE(is_newer(0, 0));
  CHECK_FALSE(is_newer(0, 1));
  CHECK(is_newer(0, kLast));
  CHECK_FALSE(is_newer(kLast, 0));
  CHECK(is_newer(0x3fffffff, 0));
  CHECK_FALSE(is_newer(0x40000000, 0)); // half-way round is nobody's future
  CHECK(is_newer(5, kLast - 5));
}

TEST_CASE("a client takes positions with its key and nothing else") {
  DatagramReceiver receiver;
  Message message;
  CHECK_FALSE(receiver.take(packet(sample(1).integer(9)), message)); // not open
  receiver.open(9, 7770);
  CHECK_FALSE(receiver.take(packet(sample(1).integer(8)), message));
  CHECK_FALSE(receiver.take(packet(sample(1)), message));
  CHECK_FALSE(receiver.take(packet(sample(1).integer(9).integer(9)), message));
  CHECK_FALSE(receiver.take(packet(sample(-1).integer(9)), message));
  for (const Address address : {Address::kForce, Address::kStart, Address::kBye, Address::kStatus,
                                Address::kButton, Address::kPong, Address::kUdp})
    CHECK_FALSE(receiver.take(packet(sample(1, 1, address).integer(9)), message));
  CHECK_FALSE(receiver.take(bytes_of("/hap/pos"), message));
  CHECK_FALSE(receiver.take({}, message));
  Bytes padded = packet(sample(1).integer(9));
  padded.resize(kMaxDatagram + 4);
  CHECK_FALSE(receiver.take(padded, message));
  CHECK(receiver.ignored() == 14); // since it was opened
  CHECK(receiver.received() == 0);
  CHECK(receiver.take(packet(sample(1, 1, Address::kVelocity).integer(9)), message));
  CHECK(receiver.take(packet(sample(2).integer(9)), message));
}

TEST_CASE("a probe names the newest sample that came, twenty times a second") {
  DatagramReceiver receiver;
  receiver.open(9, 7770);
  const auto said = [&](double now_s) {
    const auto datagram = receiver.probe(now_s);
    return datagram ? read_probe(datagram->span()) : std::nullopt;
  };
  auto probe = said(1);
  REQUIRE(probe.has_value());
  CHECK(probe->key == 9);
  CHECK(probe->sequence == -1);
  CHECK_FALSE(said(1.049).has_value());
  Message message;
  for (const std::int32_t sequence : {0x7ffffffe, 1, 0x7fffffff}) // overtaken at the wrap
    CHECK(receiver.take(packet(sample(sequence).integer(9)), message));
  probe = said(1.051);
  REQUIRE(probe.has_value());
  CHECK(probe->sequence == 1);
}

TEST_CASE("what is no probe is none") {
  const auto is_probe = [](const Message& message) {
    return read_probe(packet(message)).has_value();
  };
  const Message probe(Address::kUdp);
  CHECK(is_probe(Message(probe).integer(3).integer(-1)));
  CHECK_FALSE(is_probe(Message(probe).integer(0).integer(1)));
  CHECK_FALSE(is_probe(Message(probe).integer(-3).integer(1)));
  CHECK_FALSE(is_probe(Message(probe).integer(3).integer(-2)));
  CHECK_FALSE(is_probe(Message(probe).integer(3)));
  CHECK_FALSE(is_probe(Message(Address::kPing).integer(3).integer(1)));
  CHECK_FALSE(read_probe(bytes_of("hap udp 3 1;")).has_value());
}

TEST_CASE("a server believes arrivals of what it sent, newer ones alone") {
  DatagramSender sender;
  sender.open(9);
  CHECK_FALSE(sender.reachable(1));
  sender.take_probe(-1, 1);
  CHECK(sender.reachable(1));
  CHECK_FALSE(sender.confirmed(1));
  sender.take_probe(4, 1); // nothing was sent yet
  CHECK_FALSE(sender.confirmed(1));
  sender.add(sample(4));
  sender.take_probe(5, 1);
  CHECK_FALSE(sender.confirmed(1));
  sender.take_probe(4, 1);
  CHECK(sender.confirmed(1));
  CHECK(sender.confirmed(1 + 0.99 * kDatagramSilence_s));
  CHECK_FALSE(sender.confirmed(1 + kDatagramSilence_s));
  sender.take_probe(4, 2); // the same again: nothing has arrived since
  CHECK_FALSE(sender.confirmed(2));
  CHECK(sender.reachable(2));
  CHECK_FALSE(sender.reachable(2 + kProbeTimeout_s));
  sender.add(sample(6));
  sender.take_probe(6, 3);
  CHECK(sender.confirmed(3));
  sender.close();
  CHECK_FALSE(sender.confirmed(3));
  CHECK_FALSE(sender.reachable(3));
}

TEST_CASE("a datagram holds a sample and the client's key; those that nobody fetched are replaced, "
          "oldest first") {
  DatagramSender sender;
  sender.open(0x7abcdef1);
  for (std::int32_t i = 0; i < 7; ++i)
    sender.add(sample(i, -12.25));
  DatagramReceiver receiver;
  receiver.open(0x7abcdef1, 7770);
  std::uint64_t found = 0;
  while (const auto datagram = sender.take()) {
    CHECK(datagram->size == 12 + 8 + 4 * 6); // "/hap/pos", ",iifffi", six arguments
    Message message;
    REQUIRE(receiver.take(datagram->span(), message));
    CHECK(to_text(message) == to_text(sample(static_cast<std::int32_t>(3 + found++), -12.25)));
  }
  CHECK(found == 4);
  CHECK(receiver.received() == 4);
}

TEST_CASE("positions come by datagrams alone while they arrive, and by TCP when they do not") {
  DatagramLine line;
  line.rig.hold({0.01, 0, 0});
  line.run(0.5);
  CHECK(line.client.ready());
  line.rig.hold({0.02, 0, 0});
  line.run(1);
  CHECK(line.datagrams == 2000); // position and velocity
  CHECK(line.tcp_bytes < 600);   // pongs
  CHECK(line.oldest_s < 1e-9);
  CHECK(line.client.position().x == doctest::Approx(0.02));

  line.datagrams_pass = false; // and the client goes on probing
  line.rig.hold({0.03, 0, 0});
  line.run(1);
  CHECK(line.oldest_s < kDatagramSilence_s + kProbeInterval_s + 0.002);
  CHECK(line.client.position().x == doctest::Approx(0.03));
  CHECK(line.datagrams == 2000); // tried again and again

  line.datagrams_pass = true;
  line.run(0.2);
  line.run(1);
  CHECK(line.tcp_bytes < 600);

  line.probes_pass = false; // the way to the server alone is closed
  line.run(kProbeTimeout_s + 0.1);
  CHECK(line.oldest_s < 1e-9);
  line.run(1);
  CHECK(line.datagrams == 0);
  CHECK(line.oldest_s < 1e-9);
  CHECK(line.tcp_bytes > 40000);
}

TEST_CASE("an older position is dropped, whichever way it came") {
  DatagramLine line;
  line.run(0.1);
  const double x = line.client.position().x;
  const std::int32_t key = line.rig.server.datagrams(*line.id)->key();
  line.client.receive_datagram(packet(sample(0, 40).integer(key)), line.rig.now_s);
  CHECK(line.client.position().x == x);
  CHECK(line.client.receive(frame(Framing::kLength, sample(3, 40)), line.rig.now_s));
  CHECK(line.client.position().x == x);
  line.client.receive_datagram(packet(sample(2000, 40).integer(key)), line.rig.now_s);
  CHECK(line.client.position().x == doctest::Approx(0.04));
  line.client.receive_datagram(packet(sample(2001, 41).integer(key ^ 1)), line.rig.now_s);
  CHECK(line.client.position().x == doctest::Approx(0.04));
}

TEST_CASE("without datagrams at the server, or without a wish, all stays with TCP") {
  for (const auto& [wanted, port] : {std::pair{true, 0}, {false, 7770}}) {
    DatagramLine line(wanted, port);
    line.run(0.3);
    CHECK(line.client.udp_refused() == wanted);
    CHECK(line.client.ready());
    CHECK(line.datagrams == 0);
    CHECK(line.rig.server.datagrams(*line.id)->key() == 0);
    CHECK(line.client.trouble().empty());
  }
}

TEST_CASE("a server that knows no datagrams is no trouble, and an ended connection has no key") {
  DatagramLine line;
  const Message unknown = Message(Address::kError).string("unknown").string("udp");
  CHECK(line.client.receive(frame(Framing::kLength, unknown), line.rig.now_s));
  CHECK(line.client.udp_refused());
  CHECK(line.client.trouble().empty());
  line.run(0.1);
  const std::int32_t key = line.rig.server.datagrams(*line.id)->key();
  CHECK(line.client.datagrams().port() == 7770);
  line.client.disconnect();
  CHECK(line.client.datagrams().port() == 0);
  CHECK_FALSE(line.client.datagrams().probe(line.rig.now_s + 1).has_value());
  line.client.receive_datagram(packet(sample(4000, 40).integer(key)), line.rig.now_s);
  CHECK(line.client.position().x != doctest::Approx(0.04));
}

TEST_CASE("a server answers nobody else's datagrams, and obeys none") {
  Rig rig(usual());
  const auto id = rig.server.connect("10.0.0.5", rig.now_s, 7770);
  rig.server.receive(id, frame(Framing::kLength, Message(Address::kUdp).integer(1)), rig.now_s);
  CHECK(rig.server.datagrams(id)->key() == 0); // hello comes first
  for (const Message& message :
       {Message(Address::kHello).integer(1).string("me").string("control").string(""),
        Message(Address::kSubscribe).string("pos").real(100),
        Message(Address::kSubscribe).string("vel").real(100), Message(Address::kUdp).integer(1)})
    rig.server.receive(id, frame(Framing::kLength, message), rig.now_s);
  const std::int32_t first = rig.server.datagrams(id)->key();
  rig.server.receive(id, frame(Framing::kLength, Message(Address::kUdp).integer(1)), rig.now_s);
  const std::int32_t key = rig.server.datagrams(id)->key();
  CHECK(std::min(first, key) > 0);
  CHECK(first != key); // another with every request
  const auto takes = [&](std::string_view peer, const Message& message) {
    return rig.server.receive_datagram(peer, packet(message), rig.now_s) == id;
  };
  const Message probe = Message(Address::kUdp).integer(key).integer(-1);
  CHECK_FALSE(takes("10.0.0.6", probe));
  CHECK_FALSE(takes("10.0.0.5", Message(Address::kUdp).integer(key ^ 1).integer(-1)));
  CHECK_FALSE(takes("10.0.0.5", Message(Address::kStart).string("force")));
  CHECK_FALSE(takes("10.0.0.5", Message(Address::kForce).real(1).real(0).real(0)));
  CHECK_FALSE(takes("10.0.0.5", Message(Address::kPing).integer(1)));
  CHECK(rig.server.ignored_datagrams() == 5);
  CHECK_FALSE(rig.server.servo_command().running);
  rig.run(0.1);
  CHECK_FALSE(rig.server.datagrams(id)->take().has_value());
  CHECK(takes("10.0.0.5", probe));
  rig.run(0.02);
  DatagramReceiver receiver;
  receiver.open(key, 7770);
  Message message;
  int positions = 0, velocities = 0;
  while (const auto datagram = rig.server.datagrams(id)->take()) {
    CHECK(receiver.take(datagram->span(), message));
    (message.address() == Address::kPosition ? positions : velocities) += 1;
  }
  CHECK(positions == 2);
  CHECK(velocities == 2);
  for (const int other : {2, 0}) // an answer of 0 ends it, a wrong one changes nothing
    rig.server.receive(id, frame(Framing::kLength, Message(Address::kUdp).integer(other)),
                       rig.now_s);
  CHECK(rig.server.datagrams(id)->key() == 0);
  rig.server.receive(id, frame(Framing::kLength, Message(Address::kUdp).integer(1)), rig.now_s);
  // Probes are no sign of life: the silence of TCP ends the connection all the same.
  for (int i = 0; i < 60; ++i) {
    static_cast<void>(takes("10.0.0.5", probe));
    rig.run(0.1);
  }
  CHECK(rig.server.closing(id));
  rig.server.disconnect(id);
  CHECK_FALSE(takes("10.0.0.5", probe));
}
