#include "core/haptic/device/force_timeout.hpp"
#include "net/bus_link.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

/// Bus links in one process, each with its thread; the test is the patch. Waits are for states; how
/// long they take is the machine's affair.
using namespace tactus;
using namespace tactus::net;
using What = BusExchange::Notice::What;

namespace {

double now_s() { return haptic::ForceTimeout::now_s(); }

/// A link with the patch around it, whose logical time is the wall's and begins with it.
struct Side {
  struct Received {
    std::string topic;
    double number, sent_s, let_out_s;
  };
  void step() {
    for (auto& one : link.take_notices())
      notices.push_back(std::move(one));
    const double time_s = time();
    static_cast<void>(link.poll(time_s, [&](const BusLink::Delivered& one) {
      received.push_back(
          {std::string(one.topic.name()), one.topic.number_at(0).value_or(-1), one.sent_s, time_s});
      late += one.late ? 1 : 0;
    }));
  }
  [[nodiscard]] double time() const { return now_s() - born_s; }
  [[nodiscard]] const BusExchange::Notice* find(What what) const {
    const auto found = std::find_if(notices.begin(), notices.end(),
                                    [what](const auto& one) { return one.what == what; });
    return found != notices.end() ? &*found : nullptr;
  }
  void send(std::string_view topic, double number) {
    CHECK(link.send(Message(Address::kTopic, topic).real(number), time()));
  }
  BusLink link{};
  double born_s = now_s();
  std::vector<BusExchange::Notice> notices{};
  std::vector<Received> received{};
  int late = 0;
};

/// Steps both patches until that holds; half a minute at most.
template <class Condition> bool eventually(std::initializer_list<Side*> sides, Condition holds) {
  for (const double end_s = now_s() + 30; now_s() < end_s;) {
    for (Side* side : sides)
      side->step();
    if (holds())
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

bool connected(Side& caller, Side& listener) {
  return eventually({&listener, &caller},
                    [&] { return caller.link.peers() == 1 && listener.link.peers() == 1; });
}

int listening(Side& side, int port = 0) {
  side.link.listen(port, "");
  REQUIRE(eventually({&side}, [&] { return side.find(What::kListening) != nullptr; }));
  return side.find(What::kListening)->number;
}

} // namespace

TEST_CASE("two links give each other every event in order, evenly, with times of their own") {
  Side listener;
  const int port = listening(listener);
  std::this_thread::sleep_for(std::chrono::milliseconds(300)); // so that their times differ
  Side caller;
  caller.link.connect("127.0.0.1", port);
  REQUIRE(connected(caller, listener));
  constexpr int kEvents = 2000;
  std::vector<double> sent_s;
  for (int i = 0; i < kEvents; ++i) {
    sent_s.push_back(caller.time());
    caller.send("hit", i);
    listener.send("release", i);
    caller.send("hand", i);
    for (Side* side : {&listener, &caller})
      side->step();
    if (i % 4 == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const auto count = [](const Side& side, std::string_view topic) {
    return std::count_if(side.received.begin(), side.received.end(),
                         [topic](const auto& one) { return one.topic == topic; });
  };
  CHECK(eventually({&listener, &caller}, [&] {
    return count(listener, "hit") == kEvents && count(caller, "release") == kEvents;
  }));
  int hit = 0, release = 0;
  double last_s = 0;
  for (const auto& one : listener.received) {
    CHECK(one.let_out_s >= last_s);
    last_s = one.let_out_s;
    if (one.topic != "hit")
      continue;
    CHECK(one.number == hit);
    // The clocks are those of one machine: within what its threads' stalls leave of the minimum.
    const double true_s = sent_s[static_cast<std::size_t>(hit)] + caller.born_s - listener.born_s;
    CHECK(std::abs(one.sent_s - true_s) < 0.05);
    ++hit;
  }
  for (const auto& one : caller.received)
    CHECK(one.number == release++);
}

TEST_CASE("a link that ends is found again by who calls, and events pass again") {
  auto listener = std::make_unique<Side>();
  const int port = listening(*listener);
  Side caller;
  caller.link.connect("127.0.0.1", port);
  REQUIRE(connected(caller, *listener));
  listener.reset();
  REQUIRE(eventually({&caller}, [&] { return caller.link.peers() == 0; }));
  REQUIRE(caller.find(What::kEnded) != nullptr);
  listener = std::make_unique<Side>();
  CHECK(listening(*listener, port) == port); // the same port at once
  REQUIRE(connected(caller, *listener));
  caller.send("hit", 7);
  CHECK(eventually({listener.get(), &caller}, [&] { return listener->received.size() == 1; }));
}

TEST_CASE("ending a link waits for no peer that does not read what it is sent") {
  // It would wait 200 ms; what a busy machine adds is not in the shortest of nine.
  namespace asio = boost::asio;
  double shortest_s = 1e9;
  for (int i = 0; i < 9; ++i) {
    Side listener;
    const int port = listening(listener);
    asio::io_context context;
    asio::ip::tcp::socket peer(context);
    peer.connect({asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
    const std::string hello = "hap hello 1 mute bus;\n";
    asio::write(peer, asio::buffer(hello));
    std::array<char, 64> answer{};
    CHECK(peer.read_some(asio::buffer(answer)) > 0);
    const double began_s = now_s();
    listener.link.disconnect();
    shortest_s = std::min(shortest_s, now_s() - began_s);
  }
  CHECK(shortest_s < 0.05);
}

TEST_CASE("what cannot be opened, reached or entered is told in one sentence") {
  Side first, second, right;
  const auto says = [&](What what, const char* words) {
    REQUIRE(eventually({&first, &second}, [&] { return second.find(what) != nullptr; }));
    CHECK(second.find(what)->text.find(words) != std::string::npos);
    second.notices.clear();
  };
  first.link.set_token("sixteen bytes ok");
  const int port = listening(first);
  second.link.listen(port, "");
  says(What::kFailed, "choose another port");
  second.link.listen(0, "0.0.0.0");
  says(What::kFailed, "needs a token file");
  second.link.set_token("sixteen bytes no");
  second.link.connect("127.0.0.1", port);
  says(What::kWarning, "token is wrong");
  CHECK(first.link.peers() == 0);
  second.link.disconnect();
  right.link.set_token("sixteen bytes ok");
  right.link.connect("127.0.0.1", port);
  CHECK(connected(right, first));
  second.notices.clear();
  second.link.connect("127.0.0.1", 9);
  says(What::kFailed, "trying again");
}

TEST_CASE("a patch that ends its link from what it lets out is safe") {
  Side listener, caller;
  const int port = listening(listener);
  caller.link.connect("127.0.0.1", port);
  REQUIRE(connected(caller, listener));
  for (int i = 0; i < 10; ++i)
    caller.send("hit", i);
  int received = 0;
  for (int i = 0; i < 30000 && received == 0; ++i) {
    static_cast<void>(listener.link.poll(listener.time(), [&](const BusLink::Delivered&) {
      ++received;
      listener.link.disconnect();
    }));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK(received == 1);
  CHECK(listener.link.peers() == 0);
}
