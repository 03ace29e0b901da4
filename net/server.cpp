#include "net/server.hpp"

namespace tactus::net {

using Outcome = FrameReader::Outcome;

std::size_t Server::clients() const noexcept {
  std::size_t count = 0;
  for (const auto& session : sessions_)
    count += session && session->admitted ? 1 : 0;
  return count;
}

Server::ClientId Server::connect(std::string_view peer, double now_s, int udp_port) {
  const ClientId client = slot_for(sessions_, peer);
  sessions_[client] = std::make_unique<Session>(std::string(peer), udp_port, now_s);
  Setup& setup = sessions_[client]->setup;
  ++connections_made_;
  setup.workspace = settings_.workspace;
  setup.force_limit_n = settings_.force_limit_n;
  return client;
}

void Server::disconnect(ClientId client) {
  if (sessions_[client]->admitted) {
    log_event(*sessions_[client], "left");
    admission_.leave();
  }
  if (controller_ == sessions_[client].get())
    release_control("disconnected");
  sessions_[client].reset();
}

void Server::receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) {
  Session& session = *sessions_[client];
  while (!session.closing) {
    Message message;
    const Outcome outcome = session.next(bytes, message, now_s);
    if (outcome == Outcome::kNeedMore)
      return;
    take(session, outcome, message, now_s);
  }
  if (controller_ == &session)
    release_control("closed");
}

std::optional<Server::ClientId>
Server::receive_datagram(std::string_view peer, std::span<const std::uint8_t> bytes, double now_s) {
  if (const auto probe = read_probe(bytes))
    for (ClientId client = 0; client < kMaxConnections; ++client) {
      Session* const session = sessions_[client].get();
      if (!session || session->datagrams.key() != probe->key || session->peer != peer)
        continue;
      session->datagrams.take_probe(probe->sequence, now_s);
      return client;
    }
  ++ignored_datagrams_;
  return {};
}

void Server::take(Session& session, Outcome outcome, const Message& message, double now_s) {
  if (outcome == Outcome::kBroken) {
    session.send_error("frame", session.reader.reason(), now_s);
    return session.send_bye("frame");
  }
  if (!session.packets.allow(now_s)) {
    if (!session.flooding)
      session.send_error("flood", "more than 5000 packets a second: further packets are dropped",
                         now_s);
    session.flooding = true;
    return;
  }
  session.flooding = false;
  if (outcome ==
      Outcome::kRefused) // not a sign of life, or the old force would continue despite the error
    return session.send_error("bad", session.reader.reason(), now_s);
  if (outcome == Outcome::kBad)
    return session.count_bad_packet("bad", session.reader.reason(), now_s);
  const Refusal refusal = handle(session, message, now_s);
  if (refusal.bad)
    return session.count_bad_packet(refusal.code, refusal.text, now_s);
  if (!refusal.code.empty())
    session.send_error(refusal.code, refusal.text, now_s);
  session.last_message_s = now_s;
  if (controller_ == &session && is_recent(session, now_s)) {
    liveness_.on_message(now_s);
    servo_command_.alive_s = liveness_.alive_s();
  }
}

/// A slow connection may deliver messages whose sender has already ended.
bool Server::is_recent(const Session& session, double now_s) noexcept {
  return !session.echoed_s || now_s - *session.echoed_s < kMaxAge_s;
}

/// Ends the force, whether or not the session that had control still exists.
void Server::release_control(std::string_view why) {
  release_point();
  log_event(*controller_, "gave up control: " + std::string(why));
  controller_ = nullptr;
  servo_command_.running = false;
  servo_command_.render.mode = RenderMode::kStopped;
  servo_command_.force_n = {};
  ++servo_command_.forces;
  broadcast(Message(Address::kStatus).string("stopped").string(why));
}

void Server::log_event(const Session& session, std::string_view what) {
  add_notice(session.peer + " " + printable(session.name) + " " + std::string(what));
}

void Server::add_notice(std::string line) {
  constexpr std::size_t kMaxNotices = 64;
  if (notices_.size() == kMaxNotices)
    notices_.erase(notices_.begin());
  notices_.push_back(std::move(line));
}

void Server::broadcast(const Message& message) {
  for (const auto& session : sessions_)
    if (session && session->admitted)
      session->send_event(message);
}

/// Sent to every client, since observers too see less force than was requested.
void Server::send_clipping(const Clipping& clipping) {
  clipping_ = clipping;
  broadcast(Message(Address::kStatus)
                .string("clipped")
                .integer(clipping.on ? 1 : 0)
                .real(clipping.asked_n)
                .real(clipping.limit_n));
}

void Server::advance(const DeviceReport& report, double now_s) {
  if (report.clipping != report_.clipping)
    send_clipping({report.clipping, report.asked_n, servo_command_.force_limit_n});
  report_ = report;
  for (const auto& session : sessions_)
    if (session)
      session->check_timeouts(now_s);
  if (controller_ && controller_->closing)
    release_control("closed");
  if (controller_ && (report.emergency_stopped || report.faults != faults_))
    release_control(report.emergency_stopped ? "estop" : "fault");
  if (controller_ && now_s - controller_->last_message_s >= kSilence_s &&
      !(servo_command_.force_n == Vec3{})) {
    servo_command_.force_n = {}; // a client that resumes starts from zero force
    ++servo_command_.forces;
  }
  drag();
  for (const auto& session : sessions_)
    if (session && session->admitted)
      send_streams(*session, now_s);
}

void Server::close(std::string_view reason) {
  if (controller_)
    release_control(reason);
  for (const auto& session : sessions_)
    if (session && !session->closing)
      session->send_bye(reason);
}

} // namespace tactus::net
