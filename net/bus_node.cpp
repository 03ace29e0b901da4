#include "net/bus_node.hpp"

#include "net/bus_topic.hpp"
#include "net/osc.hpp"

#include <utility>

namespace tactus::net {

using Notice = BusExchange::Notice;

void BusExchange::post(Notice notices) {
  constexpr std::size_t kMaxNotices = 64;
  const std::lock_guard lock(mutex_);
  if (notices_.size() == kMaxNotices)
    notices_.erase(notices_.begin());
  notices_.push_back(std::move(notices));
}

bool BusExchange::try_take(std::vector<Notice>& notices) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (lock)
    notices = std::exchange(notices_, {});
  return lock.owns_lock();
}

Service::ClientId BusNode::connect(std::string_view peer, double now_s, int) {
  const ClientId client = slot_for(sessions_, peer);
  sessions_[client] =
      std::make_unique<BusSession>(side_, settings_, admission_, std::string(peer), now_s);
  reported_ready_[client] = reported_late_[client] = false;
  return client;
}

void BusNode::receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) {
  BusSession& session = *sessions_[client];
  BusExchange::Incoming& incoming = exchange_.incoming[client];
  session.receive(bytes, now_s, [&](const Message& message, double sent_s, bool late) {
    Message topic(Address::kTopic, message.name());
    for (std::size_t i = kTopicHead; i < message.size(); ++i)
      topic.add(message[i]);
    std::array<std::uint8_t, kMaxSent> packet;
    const std::size_t size = encode_osc(topic, packet);
    // Sets the delay before the message becomes visible, since the message may have raised the
    // delay.
    incoming.delay_s = session.playout().value(now_s);
    const std::size_t reserve = bus_topic(message.name()).is_event ? 0 : BusExchange::kReserve;
    return size > 0 && incoming.ring.push(sent_s, {packet.data(), size}, late, reserve);
  });
  watch(client, now_s);
}

/// Posts notices of changes since the last call.
void BusNode::watch(ClientId client, double now_s) {
  BusSession& session = *sessions_[client];
  if (std::string complaint = session.take_warning(); !complaint.empty())
    exchange_.post({Notice::What::kWarning, std::move(complaint)});
  if (session.ready() && !reported_ready_[client]) {
    reported_ready_[client] = true;
    exchange_.post({Notice::What::kConnected, session.name, ++exchange_.ready});
  }
  if (!reported_ready_[client])
    return;
  exchange_.incoming[client].transit_s = session.clock().round_trip_s() / 2;
  const bool late = session.late(now_s);
  if (late != reported_late_[client]) {
    reported_late_[client] = late;
    exchange_.post({late ? Notice::What::kLate : Notice::What::kBack, session.name});
  }
}

void BusNode::disconnect(ClientId client) {
  const BusSession& session = *sessions_[client];
  last_reason_ = session.reason().empty() ? "the connection was lost" : session.reason();
  if (reported_ready_[client])
    exchange_.post({Notice::What::kEnded, last_reason_, --exchange_.ready});
  if (session.admitted && side_ == BusSession::Side::kListener)
    admission_.leave();
  sessions_[client].reset();
}

void BusNode::close(std::string_view reason) {
  for (const auto& session : sessions_)
    if (session && !session->closing)
      session->send_bye(reason);
}

void BusNode::send_all(double now_s) {
  while (const auto packet = exchange_.outgoing.front()) {
    Message topic;
    if (decode_osc(packet->bytes, topic).empty())
      for (const auto& session : sessions_)
        if (session)
          session->send(topic, stamp_of(packet->time_s), now_s);
    exchange_.outgoing.pop();
  }
  if (exchange_.overflowed.exchange(false))
    close("busy");
}

void BusNode::advance(double now_s) {
  const double fixed_s = exchange_.playout_s;
  send_all(now_s);
  for (ClientId client = 0; client < kMaxConnections; ++client) {
    if (!sessions_[client])
      continue;
    BusSession& session = *sessions_[client];
    session.playout().set_fixed(fixed_s < 0 ? std::nullopt : std::optional(fixed_s));
    session.advance(now_s);
    exchange_.incoming[client].delay_s = session.playout().value(now_s);
    watch(client, now_s);
  }
}

} // namespace tactus::net
