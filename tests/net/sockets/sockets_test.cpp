#include "core/haptic/device/simulated_device.hpp"
#include "net/remote_device.hpp"
#include "net/servo_link.hpp"
#include "net/tcp_server.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

/// Sockets and threads: a remote device and a server in one process, each in its threads. Waits are
/// for states; how long they take is the machine's affair.
using namespace tactus;
using namespace tactus::net;
using haptic::State;

namespace {

void wait_1ms() { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

/// Half a minute at most.
template <class Condition> bool eventually(Condition holds) {
  for (int i = 0; i < 30000; ++i) {
    if (holds())
      return true;
    wait_1ms();
  }
  return false;
}

/// A server whose servo is stepped by the thread of its sockets.
class ServerThread {
public:
  explicit ServerThread(int port = 0, const ServerSettings& settings = {}, bool udp = false)
      : server_(settings) {
    haptic::SimulatedDevice::Settings held;
    held.hand.hold = haptic::HandSettings::Hold::kRigid;
    device_.set(held);
    device_.set_path(haptic::LinePath{{0.01, 0.02, 0.03}, {0.01, 0.02, 0.03}, 1});
    servo_.attach(device_, &model_);
    bool open = false;
    for (int i = 0; i < 2000 && !open; ++i) { // the port of a server that has just ended
      open = sockets_.open({port, "", udp}).empty();
      wait_1ms();
    }
    REQUIRE(open);
    port_ = sockets_.port();
    thread_ = std::thread([this] { sockets_.run(); });
  }
  ~ServerThread() {
    sockets_.stop();
    thread_.join();
  }
  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] double force_x() const { return force_x_; }
  /// The handle goes to and fro between 0 and 20 mm, at 0.2 m/s.
  void move() { moves_ = true; }
  void stop_motors() { servo_.exchange().motors.emergency_stop(); }
  /// Sends nothing for that long.
  void stall(double seconds) { stall_s_ = seconds; }
  void release_motors() { servo_.exchange().motors.enable(); }

private:
  void tick(double now_s) {
    std::this_thread::sleep_for(std::chrono::duration<double>(stall_s_.exchange(0)));
    if (moves_.exchange(false))
      device_.set_path(haptic::LinePath{{0, 0, 0}, {0.02, 0, 0}, 0.2});
    link_.exchange(server_, now_s);
    servo_.step({++ticks_, now_s, 1e-3});
    force_x_ = servo_.chain().written.x;
  }
  Server server_;
  haptic::SimulatedDevice device_{};
  RenderModel model_{};
  haptic::Servo servo_{};
  ServoLink link_{servo_, model_, {}};
  TcpServer sockets_{
      server_,
      {[this](double now_s) { tick(now_s); }, [this] { link_.send(server_.servo_command()); }}};
  std::uint64_t ticks_ = 0;
  int port_ = 0;
  std::atomic<bool> moves_{false};
  std::atomic<double> force_x_{0}, stall_s_{0};
  std::thread thread_;
};

/// A remote device with a servo's thread that writes a force.
class ClientThread {
public:
  explicit ClientThread(int port, bool udp = false) {
    const std::string words[] = {"device", "127.0.0.1", std::to_string(port), "udp",
                                 udp ? "1" : "0"};
    REQUIRE(device.configure(words) == "");
    const std::string refusal = device.open();
    REQUIRE_MESSAGE(refusal == "", refusal);
    thread_ = std::thread([this] {
      while (!stop_) {
        if (!reads) {
          static_cast<void>(device.write({force.load(), 0, 0}));
          wait_1ms();
          continue;
        }
        State state;
        const bool answered = device.read({}, state);
        answers = answered;
        unreachable = (state.flags & State::kUnreachable) != 0;
        alive = answered && (state.flags & State::kUnreachable) == 0;
        failed = answered && (state.flags & State::kFault) != 0;
        failures += failed;
        no_answers += !answered;
        no_positions += answered && unreachable;
        x = state.position.x;
        fast += alive && std::abs(state.velocity.x) > 0.1;
        still += answered && unreachable && state.velocity.x == 0;
        if (writes)
          static_cast<void>(device.write({force.load(), 0, 0}));
        wait_1ms();
      }
    });
  }
  /// Writes no force, then this one, as an operator who lets go and takes hold again; on a computer
  /// whose threads were late, as often as it takes. True if the server then has it.
  bool takes_hold(const ServerThread& server, double force_n) {
    for (int i = 0; i < 30; ++i) {
      force = 0;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      force = force_n;
      for (int j = 0; j < 1000; ++j) {
        if (server.force_x() > 0.8 * force_n)
          return true;
        wait_1ms();
      }
    }
    return false;
  }
  ~ClientThread() {
    stop_ = true;
    thread_.join();
    device.close();
  }
  RemoteDevice device{};
  std::atomic<bool> answers{false}, unreachable{false}, alive{false}, failed{false}, writes{true},
      reads{true};
  std::atomic<double> x{0}, force{0};
  /// Reads that showed a failure, no answer, an old position: a state may last a single tick.
  std::atomic<int> failures{0}, no_answers{0}, no_positions{0};
  std::atomic<int> fast{0}, still{0}; ///< reads of a moving handle, and of one with old positions

private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A connected socket of the system's, since asio's headers are compiled once, in net/.
int call(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  return socket;
}

bool stays_still(const ServerThread& server) {
  bool still = true;
  for (int i = 0; i < 300; ++i) {
    still = still && server.force_x() == 0;
    wait_1ms();
  }
  return still;
}

} // namespace

TEST_CASE("a remote device gives positions and takes forces; a servo that stalls has none") {
  ServerSettings settings;
  settings.force_limit_n = 2;
  ServerThread server(0, settings);
  ClientThread client(server.port());
  CHECK(client.device.caps().peak_force_n == 2);
  CHECK(client.device.caps().latency_ticks >= 1);
  CHECK(client.device.identity().model == "simulated");
  CHECK(eventually([&] { return client.alive && client.x == doctest::Approx(0.01); }));
  CHECK(eventually([&] { return client.alive.load(); }));
  client.force = 5; // beyond the limit
  CHECK(eventually([&] { return server.force_x() > 1.9; }));
  CHECK(server.force_x() <= 2 * (1 + 1e-12));
  client.writes = false;
  CHECK(eventually([&] { return server.force_x() == 0; }));
  client.writes = true;
  CHECK(eventually([&] { return server.force_x() > 1; }));
  client.device.close();
  CHECK(eventually([&] { return server.force_x() == 0; }));
}

TEST_CASE("a server that ends is a failure of the device, and one that comes back is found") {
  auto server = std::make_unique<ServerThread>();
  const int port = server->port();
  ClientThread client(port);
  CHECK(eventually([&] { return client.alive.load(); }));
  CHECK(client.takes_hold(*server, 0.5));
  server.reset();
  CHECK(eventually([&] { return !client.alive; }));
  CHECK(eventually([&] { return !client.device.trouble().empty(); }));
  server = std::make_unique<ServerThread>(port);
  CHECK(eventually([&] { return client.alive.load(); }));
  CHECK(stays_still(*server));            // the force of before is still wanted, and does not come
  CHECK(client.takes_hold(*server, 0.5)); // a latched servo writes 0 until motors 1
}

TEST_CASE("positions that stop coming take the force away, later they are a failure") {
  ServerThread server;
  ClientThread client(server.port());
  CHECK(eventually([&] { return client.alive.load(); }));
  server.stall(0.3);
  CHECK(eventually([&] { return client.no_positions > 0; }));
  CHECK(eventually([&] { return client.alive.load(); }));
  client.no_answers = 0;
  server.stall(0.8);
  CHECK(eventually([&] { return client.no_answers > 0; }));
  CHECK(eventually([&] { return client.alive.load(); }));
}

TEST_CASE("positions and velocities come as datagrams, too") {
  ServerThread server(0, {}, true);
  ClientThread client(server.port(), true);
  CHECK(eventually([&] { return client.alive && client.x == doctest::Approx(0.01); }));
  CHECK(client.device.trouble().empty());
  server.move();
  CHECK(eventually([&] { return client.fast > 100; }));
  server.stall(0.3); // the last velocity is not held for ever
  CHECK(eventually([&] { return client.still > 0; }));
  CHECK(eventually([&] { return client.alive.load(); }));
  CHECK(client.takes_hold(server, 0.5)); // forces go by TCP as before
}

TEST_CASE("a server without datagrams is told of, and serves by TCP") {
  ServerThread server;
  ClientThread client(server.port(), true);
  CHECK(eventually([&] { return client.device.trouble().find("--udp") != std::string::npos; }));
  CHECK(eventually([&] { return client.alive && client.x == doctest::Approx(0.01); }));
}

TEST_CASE(
    "an emergency stop at the server is a fault of the device, which waits for a late servo, and "
    "nothing but a new hold brings force back") {
  ServerThread server;
  ClientThread client(server.port());
  CHECK(eventually([&] { return client.alive.load(); }));
  CHECK(client.takes_hold(server, 0.5));
  client.reads = false;
  client.failures = 0;
  server.stop_motors();
  CHECK(eventually([&] { return client.device.trouble().find("stop") != std::string::npos; }));
  server.release_motors();
  std::this_thread::sleep_for(std::chrono::milliseconds(300)); // longer than a failure is shown
  client.reads = true;
  CHECK(eventually([&] { return client.failures > 0; }));
  CHECK(eventually([&] { return !client.failed; }));
  CHECK(stays_still(server));
  client.writes = false;
  std::this_thread::sleep_for(std::chrono::milliseconds(100)); // the force times out
  client.writes = true;
  CHECK(stays_still(server));
  CHECK(client.takes_hold(server, 0.5));
}

TEST_CASE("opening ends soon when nobody answers, and when it is cancelled") {
  RemoteDevice device;
  const std::string nobody[] = {"device", "127.0.0.1", "9"};
  REQUIRE(device.configure(nobody) == "");
  std::thread cancelling([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    device.cancel();
  });
  CHECK(device.open().find("cancelled") != std::string::npos);
  cancelling.join();
  CHECK(device.open().find("start haptic_server") != std::string::npos);
}

TEST_CASE("settings that are not understood are refused with what there is") {
  RemoteDevice device;
  const auto refusal = [&](std::initializer_list<std::string> words) {
    return device.configure(std::vector<std::string>(words));
  };
  for (const auto& good :
       std::vector<std::vector<std::string>>{{"device", "::1"},
                                             {"host", "box", "7771"},
                                             {"rate", "500"},
                                             {"udp", "1"},
                                             {"device", "box", "7771", "udp", "1"},
                                             {"device", "box:7771", "udp", "0"}})
    CHECK(device.configure(good) == "");
  CHECK(refusal({"device", "box", "7771", "udp", "2"}).find("expected 0 or 1") !=
        std::string::npos);
  CHECK(refusal({"device", "box", "0", "udp", "1"}).find("port") != std::string::npos);
  CHECK(refusal({"device", "box:0"}).find("port") != std::string::npos);
  CHECK(refusal({"host", "box", "66000"}).find("port") != std::string::npos);
  CHECK(refusal({"rte", "500"}).find("setting rte: expected") != std::string::npos);
  CHECK(refusal({"device", "5"}).find("device 5: expected") != std::string::npos);
  CHECK(refusal({"rate", "5"}).find("50..4000") != std::string::npos);
  CHECK(refusal({"token", "/nowhere"}).find("token") != std::string::npos);
  CHECK(refusal({}).find("host HOST PORT") != std::string::npos);
}

TEST_CASE("connections without the token neither stay nor keep its owner out") {
  ServerSettings settings;
  settings.token = "sixteen_bytes_ok";
  ServerThread server(0, settings);
  std::vector<int> callers;
  for (int i = 0; i < 12; ++i) // as many as there are places
    callers.push_back(call(server.port()));
  const auto send = [](int to, std::string_view line) {
    static_cast<void>(::send(to, line.data(), line.size(), MSG_NOSIGNAL));
  };
  char answer[256] = {};
  const int owner = call(server.port());
  send(owner, "hap hello 1 me control sixteen_bytes_ok;");
  CHECK(eventually([&] { return ::recv(owner, answer, sizeof answer, MSG_DONTWAIT) > 0; }));
  CHECK(std::string_view(answer).starts_with("hap welcome"));
  for (const int caller : callers) {
    CHECK(eventually([&] {
      send(caller, "hap ping 1;"); // on and on
      const auto size = ::recv(caller, answer, sizeof answer, MSG_DONTWAIT);
      return size == 0 || (size < 0 && errno != EAGAIN);
    }));
    ::close(caller);
  }
  ::close(owner);
}

namespace {

/// Places for two clients: what they say is of no account, what they are told is what the test puts
/// there.
class GreetingService final : public Service {
public:
  ClientId connect(std::string_view, double, int) override { return count++ % out_.size(); }
  void receive(ClientId, std::span<const std::uint8_t>, double) override {}
  void disconnect(ClientId) override { ++left; }
  void close(std::string_view reason) override {
    closed = true;
    for (OutQueue& queue : out_)
      static_cast<void>(
          queue.add_event({reinterpret_cast<const std::uint8_t*>(reason.data()), reason.size()}));
  }
  OutQueue& out(ClientId client) noexcept override { return out_[client]; }
  [[nodiscard]] bool closing(ClientId) const noexcept override { return closed; }
  [[nodiscard]] bool guarded() const noexcept override { return false; }

  std::size_t count = 0, left = 0;
  bool closed = false;

private:
  std::array<OutQueue, 2> out_{OutQueue{}, OutQueue{}};
};

} // namespace

TEST_CASE("a server in a patch closes without waiting for a client that does not read") {
  // Each closing would take 200 ms with a wait, and takes longer without where the machine is busy:
  // the shortest of five tells.
  double shortest_s = 1e9;
  for (int i = 0; i < 5; ++i) {
    GreetingService service;
    TcpServer server(service, {});
    REQUIRE(server.open({0, ""}).empty());
    const int deaf = call(server.port());
    REQUIRE(eventually([&] { return server.poll(), service.count == 1; }));
    const int listening = call(server.port());
    REQUIRE(eventually([&] { return server.poll(), service.count == 2; }));
    const std::vector<std::uint8_t> much(1u << 18, 'x');
    while (service.out(0).add_event(much)) // until the system's buffers are full, and ours
      server.poll();
    const auto began = std::chrono::steady_clock::now();
    server.close();
    const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - began;
    shortest_s = std::min(shortest_s, lasted.count());
    CHECK(service.left == 2);
    char word[16] = {};
    CHECK(::recv(listening, word, sizeof word, 0) == 7);
    CHECK(std::string_view(word) == "closing");
    CHECK(::recv(listening, word, sizeof word, 0) == 0);
    ::close(listening);
    ::close(deaf);
  }
  CHECK(shortest_s < 0.1);
}
