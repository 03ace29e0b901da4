#include "devices/falcon/packet.hpp"

#include "core/dsp/random.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace tactus::devices::falcon;

namespace {
std::string text(const Packet& packet) { return {packet.begin(), packet.end()}; }
} // namespace

TEST_CASE("orders are the bytes that the device's protocol names") {
  CHECK(text(encode(Command{})) == "<AAAAAAAAAAAAAA>");
  CHECK(text(encode(Command{{1000, -1000, 4095}, Command::kGreen | Command::kHoming})) ==
        "<IODAIBMPPPPADA>");
  CHECK(text(encode(Command{{-4096, 77, -1}, Command::kRed})) == "<AAAPNEAAPPPPIA>");
}

TEST_CASE("every value of an encoder and every flag comes through") {
  ResponseParser stream;
  int wrong = 0;
  for (int value = -32768; value <= 32767; ++value) {
    const auto v = static_cast<std::int16_t>(value);
    const Response sent{{v, static_cast<std::int16_t>(-1 - v), 7},
                        static_cast<std::uint8_t>(value & 0x7f)};
    int answers = 0;
    for (const std::uint8_t byte : encode(sent))
      answers += stream.process(byte);
    wrong += answers != 1 || stream.response().encoders != sent.encoders ||
             stream.response().flags != sent.flags;
  }
  CHECK(wrong == 0);
  CHECK(stream.errors() == 0);
}

TEST_CASE("after any garbage the next whole packet is found") {
  tactus::Random random(3);
  ResponseParser stream;
  const Response sent{{-5, 1200, -32768}, 0x75};
  int lost = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto length = random.next() % 40;
    for (std::uint64_t i = 0; i < length; ++i)
      static_cast<void>(stream.process(static_cast<std::uint8_t>(random.next())));
    // one cut short, then a whole one
    const Packet packet = encode(sent);
    for (std::size_t i = 0; i < random.next() % kPacketBytes; ++i)
      static_cast<void>(stream.process(packet[i]));
    bool found = false;
    for (const std::uint8_t byte : packet)
      found = stream.process(byte);
    lost += !found || stream.response().encoders != sent.encoders;
  }
  CHECK(lost == 0);
  CHECK(stream.errors() > 1000);
}

TEST_CASE("a packet with one wrong byte is refused and counted once") {
  const Packet packet = encode(Response{{1, 2, 3}, 0x70});
  for (const std::size_t at : {std::size_t{0}, std::size_t{5}, std::size_t{13}, std::size_t{15}}) {
    ResponseParser stream;
    Packet broken = packet;
    broken[at] = '@';
    for (const std::uint8_t byte : broken)
      CHECK_FALSE(stream.process(byte));
    CHECK(stream.errors() == 1);
  }
}
