// The round trip of the haptic protocol: ping to pong through the server's sockets, in each
// framing, beside a thread that sends back what it receives on a bare TCP socket.
//
//   bench_haptic_network [ROUNDS]
//
// The four take turns, a round trip each, so that they share whatever else the machine does.
// Trust the ratios. While it measures, the server also steps its link to a servo, once a
// millisecond.
#include "core/haptic/device/force_timeout.hpp"
#include "core/haptic/device/simulated_device.hpp"
#include "net/servo_link.hpp"
#include "net/tcp_server.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

namespace {

using namespace tactus;
using namespace tactus::net;

constexpr int kWarmUp = 200;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

void no_delay(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

int connect_to(int port) {
  const int made = socket(AF_INET, SOCK_STREAM, 0);
  const sockaddr_in address = loopback(port);
  if (made < 0 || connect(made, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    std::perror("bench_haptic_network: connect");
    std::exit(1);
  }
  no_delay(made);
  return made;
}

/// Sends back what one client sends, until it has gone.
class Echo {
public:
  Echo() : door_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    if (bind(door_, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
        listen(door_, 1) != 0 ||
        getsockname(door_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      std::perror("bench_haptic_network: listen");
      std::exit(1);
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Echo() {
    thread_.join();
    close(door_);
  }
  [[nodiscard]] int port() const { return port_; }

private:
  void serve() const {
    const int client = accept(door_, nullptr, nullptr);
    no_delay(client);
    char bytes[256];
    for (ssize_t count = 0; (count = recv(client, bytes, sizeof bytes, 0)) > 0;)
      if (send(client, bytes, static_cast<std::size_t>(count), MSG_NOSIGNAL) != count)
        break;
    close(client);
  }
  int door_, port_ = 0;
  std::thread thread_;
};

/// One round trip.
struct Path {
  const char* name;
  int socket;
  std::vector<std::uint8_t> request;
  std::unique_ptr<FrameReader> reader; ///< of the answer; null: as many bytes as the request
  std::vector<double> times_s{};

  bool complete(std::span<const std::uint8_t> bytes, std::size_t total) const {
    net::Message message;
    return reader ? reader->next(bytes, message) == FrameReader::Outcome::kMessage
                  : total >= request.size();
  }

  void trip(bool counts) {
    std::uint8_t bytes[256];
    const double began_s = haptic::ForceTimeout::now_s();
    static_cast<void>(!send(socket, request.data(), request.size(), MSG_NOSIGNAL));
    for (std::size_t total = 0;;) {
      const ssize_t count = recv(socket, bytes, sizeof bytes, 0);
      if (count <= 0) {
        std::fprintf(stderr, "bench_haptic_network: %s ended\n", name);
        std::exit(1);
      }
      total += static_cast<std::size_t>(count);
      if (complete({bytes, static_cast<std::size_t>(count)}, total))
        break;
    }
    if (counts)
      times_s.push_back(haptic::ForceTimeout::now_s() - began_s);
  }
  double quantile_us(double share) {
    std::sort(times_s.begin(), times_s.end());
    return 1e6 * times_s[static_cast<std::size_t>(share * static_cast<double>(times_s.size() - 1))];
  }
};

std::vector<std::uint8_t> encoded(Framing framing, const net::Message& message) {
  std::vector<std::uint8_t> bytes(256);
  bytes.resize(encode_frame(framing, message, bytes));
  return bytes;
}

} // namespace

int main(int count, char** words) {
  const int rounds = count > 1 ? std::atoi(words[1]) : 5000;
  if (rounds < 100)
    return std::fprintf(stderr, "usage: %s [ROUNDS, 100 or more]\n", words[0]), 2;
  haptic::SimulatedDevice device;
  haptic::Servo servo;
  RenderModel model;
  servo.attach(device, &model);
  Server server{ServerSettings{}};
  ServoLink link(servo, model, {});
  TcpServer sockets(server, {[&](double now_s) { link.exchange(server, now_s); },
                             [&] { link.send(server.servo_command()); }});
  if (const std::string error = sockets.open({0, ""}); !error.empty())
    return std::fprintf(stderr, "bench_haptic_network: %s\n", error.c_str()), 1;
  std::thread network([&] { sockets.run(); });
  {
    Echo echo;
    const net::Message ping = net::Message(Address::kPing).integer(1);
    std::vector<Path> paths;
    paths.push_back(
        {"bare TCP echo", connect_to(echo.port()), encoded(Framing::kLength, ping), nullptr});
    for (const auto& [name, framing] : {std::pair{"OSC, length", Framing::kLength},
                                        {"OSC, SLIP", Framing::kSlip},
                                        {"FUDI text", Framing::kFudi}})
      paths.push_back({name, connect_to(sockets.port()), encoded(framing, ping),
                       std::make_unique<FrameReader>()});
    for (int round = -kWarmUp; round < rounds; ++round)
      for (Path& path : paths)
        path.trip(round >= 0);
    std::printf("%d round trips each, us\n%-14s %8s %8s %8s\n", rounds, "", "median", "p99",
                "ratio");
    const double bare_us = paths[0].quantile_us(0.5);
    for (Path& path : paths)
      std::printf("%-14s %8.1f %8.1f %8.2f\n", path.name, path.quantile_us(0.5),
                  path.quantile_us(0.99), path.quantile_us(0.5) / bare_us);
    for (const Path& path : paths)
      close(path.socket);
  }
  sockets.stop();
  network.join();
  return 0;
}
