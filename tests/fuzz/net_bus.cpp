// A bus link's session behind its frames, both as listener and as caller: whatever a peer
// sends, what is handed on can be read, is named and numbered as a topic, and was sent before it
// came.
#include "net/bus_node.hpp"
#include "net/bus_topic.hpp"
#include "net/osc.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace tactus;
using namespace tactus::net;
using tactus::fuzz::check;

namespace {

struct End {
  explicit End(BusSession::Side side) : node(side, {"fuzzed", ""}, exchange) {}
  BusExchange exchange{};
  BusNode node;
};

double now_s = 1;

void check_exchange(End& end) {
  for (auto& incoming : end.exchange.incoming) {
    check(incoming.delay_s >= 0 && incoming.delay_s <= PlayoutDelay::kMax_s,
          "a playout delay beyond its limits");
    while (const auto packet = incoming.ring.front()) {
      Message topic;
      check(decode_osc(packet->bytes, topic).empty() && topic.address() == Address::kTopic,
            "what was handed on cannot be read");
      check(is_topic_name(topic.name()), "a topic's name that is none");
      check(topic.size() <= kMaxTopicFields, "more fields than a topic has");
      for (std::size_t i = 0; i < topic.size(); ++i)
        check(std::isfinite(topic.number_at(i).value_or(0)), "a field that is not finite");
      check(!bus_topic(topic.name()).has_time || topic.number_at(0).has_value(), "no time");
      check(std::isfinite(packet->time_s) && packet->time_s <= now_s, "a time to come");
      incoming.ring.pop();
    }
  }
}

void feed(End& end, std::span<const std::uint8_t> input) {
  const auto id = end.node.connect("127.0.0.1", now_s);
  // In two pieces, with time in between.
  const auto first = input.first(input.size() / 2);
  end.node.receive(id, first, now_s);
  end.node.advance(now_s += 0.3);
  check_exchange(end);
  end.node.receive(id, input.subspan(first.size()), now_s);
  end.node.advance(now_s += 0.3);
  check_exchange(end);
  check(end.node.out(id).size() <= OutQueue::kCapacity, "the queue is longer than it may be");
  end.node.disconnect(id);
  check(end.exchange.ready == 0, "a peer is ready that has gone");
  std::vector<BusExchange::Notice> notices;
  check(end.exchange.try_take(notices) && notices.size() <= 64, "news without end");
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  static End listener(BusSession::Side::kListener), caller(BusSession::Side::kCaller);
  feed(listener, input);
  feed(caller, input);
}
