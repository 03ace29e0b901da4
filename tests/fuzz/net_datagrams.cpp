// Datagrams of peers without and with the key: whatever comes, nothing is moved, said or
// counted as life but positions at a client and probes at a server.
#include "net/client.hpp"
#include "net/server.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <memory>
#include <vector>

using namespace tactus;
using namespace tactus::net;
using tactus::fuzz::check;

namespace {

constexpr std::string_view kPeer = "127.0.0.1";

/// A server and a client that know each other, and use datagrams.
struct Pair {
  Pair() : client(client_settings()) {
    id = server.connect(kPeer, now_s, kPort);
    client.connect(now_s);
    for (int i = 0; i < 4; ++i)
      exchange();
    check(client.datagrams().port() == kPort, "no datagrams were agreed upon");
  }
  static ClientSettings client_settings() {
    ClientSettings settings;
    settings.udp = true;
    return settings;
  }
  static std::vector<std::uint8_t> taken(OutQueue& queue) {
    const std::vector<std::uint8_t> bytes(queue.front().begin(), queue.front().end());
    queue.consume(bytes.size());
    return bytes;
  }
  void exchange() {
    now_s += 1e-3;
    check(client.advance(now_s), "the client has given up");
    server.receive(id, taken(client.out()), now_s);
    server.advance({}, now_s);
    check(client.receive(taken(server.out(id)), now_s), "the client has ended the connection");
  }
  double now_s = 1;
  Server server{ServerSettings{}};
  Client client;
  Server::ClientId id = 0;
};

std::unique_ptr<Pair> pair;
unsigned uses = 0;

void to_client(std::span<const std::uint8_t> input, bool has_key) {
  Client& client = pair->client;
  const Vec3 before = client.position();
  const std::uint64_t read = client.datagrams().received() + client.datagrams().ignored();
  const std::uint64_t taken = client.datagrams().received();
  client.receive_datagram(input, pair->now_s);
  check(client.datagrams().received() + client.datagrams().ignored() == read + 1,
        "a datagram was not counted");
  check(is_finite(client.position()), "a position that is not finite");
  check(has_key || client.position() == before, "a stranger has moved the handle");
  check(client.datagrams().received() == taken || input.size() <= kMaxDatagram,
        "a datagram was taken that is too long");
  check(client.out().size() == 0, "a datagram was answered over TCP");
  check(!client.in_control() && client.refusals() == 0 && client.trouble().empty(),
        "a datagram did more than bring a position");
}

void to_server(std::span<const std::uint8_t> input, std::string_view peer) {
  Server& server = pair->server;
  const std::uint64_t ignored = server.ignored_datagrams();
  const bool taken = server.receive_datagram(peer, input, pair->now_s).has_value();
  check(server.ignored_datagrams() == ignored + (taken ? 0 : 1), "a datagram was not counted");
  check(!taken || peer == kPeer, "another address was taken for the client's");
  const auto probe = read_probe(input);
  check(!taken || (probe && probe->key == server.datagrams(pair->id)->key()),
        "a datagram was taken that is no probe with the key");
  check(server.out(pair->id).size() == 0, "a datagram was answered over TCP");
  check(!server.servo_command().running && server.servo_command().force_n == Vec3{},
        "a datagram has moved a motor");
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  // A fresh pair every now and then: a far sequence number, once taken, makes old ones of the rest.
  if (uses++ % 64 == 0)
    pair = std::make_unique<Pair>();
  const std::int32_t key = pair->server.datagrams(pair->id)->key();
  bool has_key = false; // by chance
  for (std::size_t at = 0; at + 4 <= input.size() && !has_key; at += 4) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
      word = word << 8 | input[at + i];
    has_key = word == static_cast<std::uint32_t>(key);
  }
  to_client(input, has_key);
  to_server(input, kPeer);
  to_server(input, "127.0.0.2");
  // The same with the key where a position and where a probe has it.
  std::vector<std::uint8_t> keyed(input.begin(), input.end());
  const auto put = [&](std::size_t at) {
    for (std::size_t i = 0; i < 4 && at + i < keyed.size(); ++i)
      keyed[at + i] = static_cast<std::uint8_t>(key >> (24 - 8 * i));
  };
  put(keyed.size() >= 4 ? keyed.size() - 4 : 0);
  to_client(keyed, true);
  constexpr std::size_t kProbeKey = 12 + 4; // behind "/hap/udp" and ",ii"
  put(kProbeKey);
  to_server(keyed, kPeer);
  pair->exchange();
  check(pair->client.out().size() == 0 || pair->client.ready(), "the connection has suffered");
}
