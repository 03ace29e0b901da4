#include "net/bus_session.hpp"

#include "core/text.hpp"
#include "net/bus_topic.hpp"

namespace tactus::net {
namespace {

constexpr std::string_view kRole = "bus";

std::int32_t wire_integer(std::uint32_t value) noexcept { return static_cast<std::int32_t>(value); }

} // namespace

BusSession::BusSession(Side side, const BusSettings& settings, Admission& admission,
                       std::string peer_address, double now_s)
    : PeerConnection(std::move(peer_address), now_s, kStreamLimit), side_(side),
      settings_(settings), admission_(admission) {
  if (side == Side::kListener)
    return;
  begins_in = Framing::kSlip;
  send_event(Message(Address::kHello)
                 .integer(kProtocol)
                 .string(settings_.name)
                 .string(kRole)
                 .string(settings_.token));
}

void BusSession::end(std::string_view why) {
  if (reason_.empty())
    reason_ = why;
  if (!closing)
    send_bye(why);
}

void BusSession::receive(std::span<const std::uint8_t> bytes, double now_s,
                         const Receiver& receiver) {
  while (!closing) {
    Message message;
    const FrameReader::Outcome outcome = next(bytes, message, now_s);
    if (outcome == FrameReader::Outcome::kNeedMore)
      return;
    take(outcome, message, now_s, receiver);
  }
  if (reason_.empty()) // PeerConnection ended the connection
    reason_ = "bad";
}

void BusSession::take(FrameReader::Outcome outcome, const Message& message, double now_s,
                      const Receiver& receiver) {
  if (outcome == FrameReader::Outcome::kBroken) {
    send_error("frame", reader.reason(), now_s);
    return end("frame");
  }
  // Above the maximum rate, streams are dropped; events are accepted while there is room.
  const bool event = outcome == FrameReader::Outcome::kMessage &&
                     message.address() == Address::kTopic && bus_topic(message.name()).is_event;
  if (!packets.allow(now_s) && !event) {
    if (!flooding)
      send_error("flood", "more than 5000 packets a second: streams are dropped", now_s);
    flooding = true;
    return;
  }
  flooding = false;
  if (outcome == FrameReader::Outcome::kRefused)
    return send_error("bad", reader.reason(), now_s);
  const Refusal refusal = outcome == FrameReader::Outcome::kBad ? Refusal{"bad", reader.reason()}
                                                                : handle(message, now_s, receiver);
  if (!refusal.code.empty())
    return count_bad_packet(refusal.code, refusal.text, now_s);
  last_message_s = now_s;
}

BusSession::Refusal BusSession::handle(const Message& message, double now_s,
                                       const Receiver& receiver) {
  switch (message.address()) {
  case Address::kHello:
    return on_hello(message, now_s);
  case Address::kWelcome:
    return on_welcome(message, now_s);
  case Address::kError: {
    const auto code = message.string_at(0), text = message.string_at(1);
    if (admitted)
      warning_ = printable(code.value_or("-")) + ": " + printable(text.value_or("-"));
    else if (side_ == Side::kCaller) // the answer to this side's hello
      warning_ = refusal_text_of_peer(code.value_or(""));
    return {};
  }
  case Address::kBye:
    if (admitted)
      reason_ = "the peer closed the connection: " +
                printable(message.string_at(0).value_or("no reason given"));
    else
      reason_ = refusal_text_of_peer(message.string_at(0).value_or(""));
    closing = true;
    return {};
  default:
    break;
  }
  if (!admitted)
    return {"hello", "send hello first: hello protocol name bus token"};
  switch (message.address()) {
  case Address::kPing:
  case Address::kPong:
    return on_clock(message, now_s);
  case Address::kTopic:
    return on_topic(message, now_s, receiver);
  default:
    return {"unknown", "expected ping, pong, error, bye or /bus/TOPIC"};
  }
}

BusSession::Refusal BusSession::on_hello(const Message& message, double now_s) {
  const auto protocol = message.integer_at(0);
  const auto peer_name = message.string_at(1), role = message.string_at(2);
  if (side_ == Side::kCaller || admitted)
    return {"hello", "only the caller sends hello, once"};
  if (!protocol || !peer_name || !role || message.size() > 4 ||
      (message.size() == 4 && !message.string_at(3)))
    return {"arguments", "expected hello protocol name bus token"};
  if (*role != kRole)
    return {"arguments", "expected the role bus"};
  if (const auto code = admission_.admit(peer, message.string_at(3).value_or(""), *protocol, now_s);
      !code.empty()) {
    reason_ = code;
    refuse_hello(code, now_s);
    return {};
  }
  name = printable(peer_name->substr(0, kMaxName));
  send_event(Message(Address::kWelcome).integer(kProtocol).string(settings_.name));
  welcome(now_s);
  return {};
}

BusSession::Refusal BusSession::on_welcome(const Message& message, double now_s) {
  const auto protocol = message.integer_at(0);
  const auto peer_name = message.string_at(1);
  if (side_ == Side::kListener || admitted)
    return {"hello", "welcome is sent once, in answer to hello"};
  if (!protocol || !peer_name || message.size() != 2)
    return {"arguments", "expected welcome protocol name"};
  name = printable(peer_name->substr(0, kMaxName));
  welcome(now_s);
  return {};
}

void BusSession::welcome(double now_s) {
  admitted = true;
  ping(now_s);
}

/// Both ping and pong carry the sender's clock and the minimum of its samples.
void BusSession::send_clock(Address address, std::int32_t sequence, double now_s) {
  Message message(address);
  message.integer(sequence).integer(wire_integer(stamp_of(now_s)));
  if (const auto minimum_us = clock_.minimum_us(now_s))
    message.integer(wire_integer(*minimum_us));
  send_event(message);
}

void BusSession::ping(double now_s) {
  pinged_s_ = now_s;
  send_clock(Address::kPing, ++pings_, now_s);
}

BusSession::Refusal BusSession::on_clock(const Message& message, double now_s) {
  const auto sequence = message.integer_at(0), clock_us = message.integer_at(1),
             minimum_us = message.integer_at(2);
  const bool complete = message.size() == 2 || (message.size() == 3 && minimum_us);
  if (!sequence || !clock_us || !complete)
    return {"arguments", "expected ping or pong sequence clock [minimum], integers of us"};
  const auto stamp = static_cast<std::uint32_t>(*clock_us);
  clock_.add(stamp, now_s);
  if (minimum_us)
    clock_.set_remote_minimum(static_cast<std::uint32_t>(*minimum_us), now_s);
  if (message.address() == Address::kPing)
    send_clock(Address::kPong, *sequence, now_s);
  if (clock_.known()) {
    playout_.add(clock_.delay_s(stamp, now_s), now_s);
    ready_ = ready_ || ++clocks_ >= kFirstPings;
  }
  return {};
}

BusSession::Refusal BusSession::on_topic(const Message& message, double now_s,
                                         const Receiver& receiver) {
  const auto sequence = message.integer_at(0), clock_us = message.integer_at(1);
  if (!sequence || !clock_us)
    return {"arguments", "expected /bus/TOPIC sequence clock fields..., two integers first"};
  if (!is_topic_name(message.name()))
    return {"arguments", "a topic is 1 to 32 letters, digits, _ and -"};
  const BusTopic topic = bus_topic(message.name());
  if (topic.has_time && !message.number_at(kTopicHead))
    return {"arguments",
            "the first field of this topic is its time, in ms after the message's time"};
  // Sequence 0 means that the sender does not number its events.
  if (*sequence != 0 && topic.is_event)
    count_event(message, now_s);
  const auto stamp = static_cast<std::uint32_t>(*clock_us);
  clock_.add(stamp, now_s);
  const double delay_s = clock_.delay_s(stamp, now_s);
  const bool late = clock_.known() && delay_s > playout_.value(now_s);
  if (clock_.known())
    playout_.add(delay_s, now_s);
  const bool taken = receiver(message, now_s - delay_s, late);
  if (!taken && topic.is_event)
    end("busy");
  dropped_ += taken ? 0 : 1;
  return {};
}

/// Events are numbered from 1; their numbers may restart at 1.
void BusSession::count_event(const Message& message, double now_s) {
  if (may_be_rounded(message[0]))
    return send_error("sequence",
                      "the event number has more than six digits: restart at 1 before 1000000",
                      now_s);
  const auto event = static_cast<std::uint32_t>(*message.integer_at(0));
  const std::uint32_t gap = event == 1 ? 0 : event - events_taken_ - 1;
  if (gap != 0) {
    lost_events_ += gap;
    send_error("sequence", "events are missing: their numbers must increase by one, from 1", now_s);
  }
  events_taken_ = event;
}

void BusSession::send(const Message& topic, std::uint32_t sent, double now_s) {
  if (!ready())
    return;
  const bool event = bus_topic(topic.name()).is_event;
  // A stream sample that the other side would drop is not sent; events count towards the rate and
  // are always sent.
  if (!sending_.allow(now_s) && !event) {
    ++dropped_;
    return;
  }
  Message message(Address::kTopic, topic.name());
  if (event)
    events_sent_ = events_sent_ < static_cast<std::uint32_t>(last_count()) ? events_sent_ + 1 : 1;
  message.integer(wire_integer(events_sent_)).integer(wire_integer(sent));
  for (std::size_t i = 0; i < topic.size(); ++i)
    message.add(topic[i]);
  if (!event)
    dropped_ += send_sample(message) ? 0 : 1;
  else if (send_event(message); closing && reason_.empty())
    reason_ = "the peer does not read its data";
}

void BusSession::advance(double now_s) {
  if (closing)
    return;
  check_timeouts(now_s);
  if (closing) {
    reason_ = !admitted
                  ? side_ == Side::kCaller ? "no bus answers at this address" : "received no hello"
              : now_s - last_message_s >= kTimeout_s ? "received nothing for 5 s"
                                                     : "a frame was still incomplete after 2 s";
    return;
  }
  const double pause_s = ready_ ? kPingInterval_s : kFirstPing_s;
  if (admitted && now_s - pinged_s_ >= pause_s)
    ping(now_s);
}

} // namespace tactus::net
