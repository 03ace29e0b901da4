#include "net/fudi.hpp"
#include "net/osc.hpp"
#include "tests/net/bytes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace tactus::net;

namespace {

Message force() { return Message(Address::kForce).real(1).real(-2).real(0.5); }

std::string osc_reason(const Bytes& packet) {
  Message message;
  return std::string(decode_osc(packet, message));
}

std::string fudi_reason(std::string text) {
  Message message;
  bool found = false;
  return std::string(decode_fudi(text, message, found));
}

std::string fudi(std::string text) {
  Message message;
  bool found = false;
  REQUIRE(decode_fudi(text, message, found) == "");
  return found ? to_text(message) : "nothing";
}

/// A packet of any address, tags and argument bytes.
Bytes packet_of(std::string_view address, std::string_view tags, Bytes arguments = {}) {
  Bytes packet = bytes_of(address);
  do
    packet.push_back(0);
  while (packet.size() % 4 != 0);
  packet = packet + bytes_of(tags);
  do
    packet.push_back(0);
  while (packet.size() % 4 != 0);
  return packet + arguments;
}

} // namespace

TEST_CASE("a force is the 32 bytes of the OSC specification, 35 in SLIP") {
  CHECK(force_packet().size() == 32);
  Bytes out(100);
  out.resize(encode_osc(force(), out));
  CHECK(out == force_packet());
  Message message;
  CHECK(decode_osc(out, message) == "");
  CHECK(message == force());
  const Bytes slip = frame(Framing::kSlip, force()); // with the end of each frame and one escape
  CHECK(slip.size() == 35);
  CHECK(slip.front() == 0xC0);
  CHECK(slip.back() == 0xC0);
  CHECK(slip[1 + 24] == 0xDB); // -2 is C0 00 00 00
  CHECK(slip[1 + 25] == 0xDC);
  CHECK(read_all(slip + Bytes(slip.begin() + 1, slip.end())).size() == 2); // one END between two
  CHECK(read_all(Bytes{0xC0, 0xC0, 0xC0} + slip).size() == 1);
}

TEST_CASE("three framings give the same message, however the stream is cut") {
  const std::vector<std::string> expected(3, "force 1.000000 -2.000000 0.500000");
  const Bytes slip = frame(Framing::kSlip, force());
  const Bytes length = with_length(force_packet());
  CHECK(frame(Framing::kLength, force()) == length);
  const Bytes text = bytes_of("hap force 1 -2 0.5;\n");
  CHECK(frame(Framing::kFudi, force()) == text);
  for (const Bytes& one : {slip, length, text})
    for (const std::size_t piece : {1u, 2u, 3u, 7u, 35u, 1000u})
      CHECK(read_all(one + one + one, piece) == expected);
}

TEST_CASE("Pd's integers come as floats and are read as integers") {
  Message message = Message(Address::kPing).real(7);
  CHECK(message.integer_at(0) == 7);
  CHECK(!Message(Address::kPing).real(7.5).integer_at(0));
  CHECK(!Message(Address::kPing).real(3e9).integer_at(0));
  CHECK(!Message(Address::kPing).string("7").integer_at(0));
  CHECK(!message.integer_at(1));
  CHECK(Message(Address::kPing).integer(7).number_at(0) == 7);
}

TEST_CASE("names in two words are one in FUDI") {
  CHECK(fudi("hap cp set 3 1 2.5 -4") == "cp/set 3.000000 1.000000 2.500000 -4.000000");
  CHECK(fudi("hap cp/begin 3") == "cp/begin 3.000000");
  CHECK(fudi("hap cp end") == "cp/end");
  CHECK(frame(Framing::kFudi, Message(Address::kCpMove).integer(3).real(1).real(2).real(3)) ==
        bytes_of("hap cp move 3 1 2 3;\n"));
  Message message;
  bool found = false;
  std::string text = "hap cp nothing 3";
  CHECK(decode_fudi(text, message, found) == "");
  CHECK(message.address() == Address::kUnknown);
  CHECK(message.name() == "cp");
}

TEST_CASE("every address has one name, found again") {
  for (int i = 1; i <= static_cast<int>(Address::kBye); ++i) {
    const auto address = static_cast<Address>(i);
    CHECK(find_address(name_of(address)) == address);
    const std::string_view name = name_of(address);
    if (const auto slash = name.find('/'); slash != name.npos)
      CHECK(find_address(name.substr(0, slash), name.substr(slash + 1)) == address);
  }
  CHECK(find_address("") == Address::kUnknown);
  CHECK(find_address("?x") == Address::kUnknown);
  CHECK(find_address("cp", "begi") == Address::kUnknown);
}

TEST_CASE("FUDI words: numbers, escapes, blanks") {
  CHECK(fudi("hap hello 1 a\\ b con\\;trol \\\\x \\5") ==
        "hello 1.000000 'a b' 'con;trol' '\\x' '5'");
  CHECK(fudi("\n  hap\tforce  -1.5e-3 +2 .5\r\n") == "force -0.001500 2.000000 0.500000");
  CHECK(fudi("hap start 1-2") == "start '1-2'");
  CHECK(fudi("hap start - + e5 nan inf 0x10") == "start '-' '+' 'e5' 'nan' 'inf' '0x10'");
  CHECK(fudi("   \n") == "nothing");
  CHECK(frame(Framing::kFudi, Message(Address::kError).string("").string("a\nb")) ==
        bytes_of("hap error - a?b;\n"));
  CHECK(fudi("hello there") == "hello");
  CHECK(fudi_reason("hap force 1, 2") != "");
  CHECK(fudi_reason("hap start \\") != "");
  CHECK(fudi_reason("hap start \x01") != "");
  CHECK(fudi_reason("hap force 1e999 0 0") != "");
  CHECK(fudi_reason("hap force 1e39 0 0") != ""); // beyond 32 bits
  CHECK(fudi_reason("hap status 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16") == "");
  CHECK(fudi_reason("hap status 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17") != "");
}

TEST_CASE("bad OSC packets are refused with the reason") {
  const Bytes good = force_packet();
  for (std::size_t size = 0; size < good.size(); ++size)
    CHECK(osc_reason({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}) != "");
  CHECK(osc_reason(good + Bytes{0, 0, 0, 0}) == "bytes are left after the arguments");
  CHECK(osc_reason(packet_of("/hap/force", ",ffd")) == "the packet ends inside its arguments");
  CHECK(osc_reason(packet_of("/hap/force", ",b", Bytes(4))) == kOtherType);
  CHECK(osc_reason(packet_of("/hap/force", ",d", {0x7F, 0xF0, 0, 0, 0, 0, 0, 0})) ==
        "not a finite number");
  CHECK(osc_reason(packet_of("/hap/force", ",d", {0x7F, 0xE0, 0, 0, 0, 0, 0, 0})) ==
        "a number is out of range");
  CHECK(osc_reason(packet_of("/hap/force", ",h", Bytes(4))) ==
        "the packet ends inside its arguments");
  CHECK(osc_reason(packet_of("/hap/force", "fff", Bytes(12))) == "there are no type tags");
  CHECK(osc_reason(packet_of("hap/force", ",fff", Bytes(12))) != "");
  CHECK(osc_reason(packet_of("#bundle", "", Bytes(8))).find("bundles") == 0);
  CHECK(osc_reason(packet_of("/hap/hello", ",s", bytes_of("abcd"))) ==
        "a string is not terminated");
  CHECK(osc_reason(packet_of("/hap/force", ",f", {0x7F, 0x80, 0, 0})) == "not a finite number");
  CHECK(osc_reason(packet_of("/hap/force", ",f", {0x7F, 0xC0, 0, 0})) == "not a finite number");
  CHECK(osc_reason(packet_of("/hap/force", ",f", {0xFF, 0x80, 0, 0})) == "not a finite number");
  CHECK(osc_reason(packet_of("/hap/status", ",iiiiiiiiiiiiiiiii", Bytes(68))) ==
        "more than 16 arguments");
  Message message;
  const Bytes elsewhere = packet_of("/elsewhere/force", ",");
  CHECK(decode_osc(elsewhere, message) == "");
  CHECK(message.address() == Address::kUnknown);
  CHECK(message.name() == "/elsewhere/force");
}

TEST_CASE("types that mean one thing are taken as it") {
  const Bytes arguments{0x3F, 0xE0, 0,    0,    0,    0, 0, 0,                    // d 0.5
                        0,    0,    0,    0,    0,    0, 0, 5,                    // h 5
                        0xFF, 0xFF, 0xFF, 0xFF, 0x80, 0, 0, 0,                    // h -2^31
                        0,    0,    0,    1,    0,    0, 0, 0, 'w', 'o', 'r', 0}; // h 2^32, S wor
  Message message;
  const Bytes packet = packet_of("/hap/start", ",dhhhTFS", arguments);
  REQUIRE(decode_osc(packet, message) == "");
  CHECK(to_text(message) == "start 0.500000 5.000000 -2147483648.000000 4294967296.000000 1.000000 "
                            "0.000000 'wor'");
  CHECK(message.integer_at(2) == std::numeric_limits<std::int32_t>::min());
}

TEST_CASE("a bundle is its messages, one within another too; a damaged one is none of them") {
  const std::string one = "force 1.000000 -2.000000 0.500000";
  const Bytes force = force_packet(), stop = packet_of("/hap/stop", ",");
  const auto all = [](const Bytes& packet, std::size_t piece = 1000) {
    return read_all(with_length(packet) + with_length(force_packet()), piece);
  };
  using Lines = std::vector<std::string>;
  CHECK(all(bundle({force})) == Lines{one, one});
  for (const std::size_t piece : {1u, 5u, 1000u})
    CHECK(all(bundle({bundle({bundle({}), stop, force}), stop}), piece) ==
          Lines{"stop", one, "stop", one});
  CHECK(all(bundle({})) == Lines{one});
  Bytes damaged = bundle({force, stop}), deep = force;
  damaged[damaged.size() - 1] = 1;
  for (int depth = 0; depth < 9; ++depth)
    deep = bundle({deep});
  for (const Bytes& bad : {damaged, deep, Bytes(deep.begin(), deep.begin() + 12),
                           bundle({force, Bytes{}}), bundle({force}) + Bytes(4)}) {
    const Lines lines = all(bad);
    REQUIRE(lines.size() == 2);
    CHECK(lines[0].starts_with("bad: "));
  }
  CHECK(all(bundle({force, packet_of("/hap/stop", ",N")})) ==
        Lines{"refused: " + std::string(kOtherType), one});
}

TEST_CASE("SLIP may have its END behind a packet alone, and text may begin with a slash") {
  const std::string one = "force 1.000000 -2.000000 0.500000";
  const Bytes slip = frame(Framing::kSlip, force()), behind(slip.begin() + 1, slip.end());
  for (const std::size_t piece : {1u, 7u, 1000u})
    CHECK(read_all(behind + behind, piece) == std::vector<std::string>{one, one});
  CHECK(read_all(bytes_of("/hap/force 1; hap force 1 -2 0.5;")) ==
        std::vector<std::string>{"/hap/force", one});
  Bytes bundled = bundle({force_packet()}); // -2 is C0 00 00 00
  const auto end = std::find(bundled.begin(), bundled.end(), 0xC0);
  *end = 0xDB;
  bundled.insert(end + 1, 0xDC);
  CHECK(read_all(bundled + Bytes{0xC0}) == std::vector<std::string>{one});
}

TEST_CASE("a bad packet is dropped and the next is read") {
  const Bytes good = frame(Framing::kSlip, force());
  const Bytes cut{0xC0, '/', 'h', 0xC0};
  CHECK(read_all(good + cut + good).size() == 3);
  CHECK(read_all(good + Bytes{0xC0, 'x', 0xDB, 'y', 'z', 0xC0} + good)[1] ==
        "bad: an unknown SLIP escape");
  CHECK(read_all(good + Bytes{0xC0, 'x', 0xDB, 0xC0} + good)[1] ==
        "bad: an escape at the end of a SLIP frame");
  CHECK(read_all(with_length({}) + with_length(force_packet())).size() == 2);
  CHECK(read_all(bytes_of("hap force 1,2; hap stop;"))[1] == "stop");
}

TEST_CASE("a packet of 70 kB is one bad packet in every framing, one of 64 KiB is read") {
  const Bytes long_text(70000, 'x');
  const std::vector<std::string> expected{"bad: a packet is longer than 65536 bytes",
                                          "force 1.000000 -2.000000 0.500000"};
  for (const std::size_t piece : {977u, 100000u}) {
    CHECK(read_all(Bytes{0xC0} + long_text + frame(Framing::kSlip, force()), piece) == expected);
    CHECK(read_all(with_length(long_text) + with_length(force_packet()), piece) == expected);
    CHECK(read_all(long_text + bytes_of(";hap force 1 -2 0.5;"), piece) == expected);
  }
  const std::string name(kMaxPacket - 20, 'n');
  const Bytes full = packet_of("/hap/hello", ",s", bytes_of(name) + Bytes(4));
  CHECK(full.size() == kMaxPacket);
  CHECK(read_all(with_length(full)) == std::vector<std::string>{"hello '" + name + "'"});
}

TEST_CASE("a negative length and an unknown first byte break the stream") {
  CHECK(read_all(with_length(force_packet()) + Bytes{0xFF, 0xFF, 0xFF, 0xFF} +
                 with_length(force_packet())) ==
        std::vector<std::string>{"force 1.000000 -2.000000 0.500000",
                                 "broken: a packet's length is negative"});
  for (const int first : {0x01, 0x0A, 0x7F, 0x80, 0xFF})
    CHECK(read_all(Bytes{static_cast<std::uint8_t>(first), 'a'}).front().starts_with("broken: "));
}

TEST_CASE("a frame is open from its first byte to its last") {
  FrameReader reader;
  Message message;
  const auto feed = [&](const Bytes& bytes) {
    std::span<const std::uint8_t> rest(bytes);
    while (reader.next(rest, message) != FrameReader::Outcome::kNeedMore) {
    }
    return reader.in_frame();
  };
  CHECK(!reader.in_frame());
  CHECK(!feed({0xC0}));
  CHECK(feed({'/'}));
  CHECK(!feed({0xC0}));
  reader = {};
  CHECK(feed({0}));
  CHECK(feed({0, 0, 32}));
  CHECK(!feed(force_packet()));
  reader = {};
  CHECK(!feed(bytes_of("  \n")));
  CHECK(feed(bytes_of("hap ")));
  CHECK(feed(bytes_of("\n")));
  CHECK(!feed(bytes_of("stop; \n")));
}

TEST_CASE("random messages survive each framing") {
  std::mt19937 random(1);
  const auto pick = [&](int from, int to) {
    return std::uniform_int_distribution<int>(from, to)(random);
  };
  for (int round = 0; round < 3000; ++round) {
    Message message(static_cast<Address>(pick(1, static_cast<int>(Address::kBye))));
    std::array<std::string, Message::kMaxArguments> texts;
    const int count = pick(0, static_cast<int>(Message::kMaxArguments));
    for (int i = 0; i < count; ++i) {
      switch (pick(0, 2)) {
      case 0:
        message.integer(static_cast<std::int32_t>(random()));
        break;
      case 1: // halves: no whole number, which FUDI gives back as an integer
        message.real((2 * pick(-100000, 100000) + 1) * std::exp2(pick(-60, -1)));
        break;
      default: {
        std::string& text = texts[static_cast<std::size_t>(i)];
        for (int n = pick(1, 30); n > 0; --n)
          text += static_cast<char>(pick(0x20, 0x7e));
        if (pick(0, 3) == 0)
          text = std::to_string(pick(-99, 99)); // a word of digits stays a word
        message.string(text);
      }
      }
    }
    for (const Framing framing : {Framing::kSlip, Framing::kLength, Framing::kFudi}) {
      const Bytes bytes = frame(framing, message);
      REQUIRE(!bytes.empty());
      FrameReader reader;
      std::span<const std::uint8_t> rest(bytes);
      Message back;
      REQUIRE(reader.next(rest, back) == FrameReader::Outcome::kMessage);
      CHECK(back == message);
      CHECK(reader.next(rest, back) == FrameReader::Outcome::kNeedMore);
    }
  }
}

TEST_CASE("what does not fit is not written at all") {
  Bytes small(31);
  CHECK(encode_osc(force(), small) == 0);
  std::array<char, 19> text{};
  CHECK(encode_fudi(force(), text) == 0);
  const std::string name(3000, 'n');
  Bytes large(10000);
  CHECK(encode_frame(Framing::kSlip, Message(Address::kError).string(name), large) == 0);
  CHECK(encode_frame(Framing::kSlip, force(), std::span(large).first(34)) == 0);
  CHECK(encode_frame(Framing::kSlip, force(), std::span(large).first(35)) == 35);
}
