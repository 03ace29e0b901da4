#include "net/client.hpp"

#include "core/text.hpp"
#include "net/admission.hpp"
#include "net/limits.hpp"

namespace tactus::net {
namespace {

Message& add_mm(Message& message, const Vec3& position_m) {
  for (int axis = 0; axis < 3; ++axis)
    message.real(position_m[axis] * kMm_per_m);
  return message;
}

/// The vector of a `pos` or `vel`; nullopt for any other message and for a sample that is not newer
/// than `last`, such as an overtaken or repeated datagram.
std::optional<Vec3> newer_sample(const Message& message,
                                 std::optional<std::int32_t>& last) noexcept {
  const auto sequence = message.integer_at(0);
  const auto x = message.number_at(2), y = message.number_at(3), z = message.number_at(4);
  if (!sequence || !x || !y || !z || (last && !is_newer(*sequence, *last)))
    return {};
  last = sequence;
  return Vec3{*x, *y, *z};
}

std::string_view word_of(RenderMode mode) noexcept {
  return mode == RenderMode::kSpring ? "spring" : mode == RenderMode::kDamper ? "damper" : "force";
}

} // namespace

void Client::send(const Message& message) {
  std::array<std::uint8_t, kMaxSent + 4> bytes;
  const std::size_t size = encode_frame(Framing::kLength, message, bytes);
  if (!out_.add_event({bytes.data(), size})) {
    trouble_ = "the server does not read its data";
    ended_ = true;
  }
}

void Client::connect(double now_s) {
  disconnect();
  trouble_.clear();
  last_message_s_ = connected_s_ = pinged_s_ = now_s;
  send(Message(Address::kHello)
           .integer(kProtocol)
           .string(settings_.name)
           .string("control")
           .string(settings_.token));
  send_setup();
}

void Client::disconnect() noexcept {
  reader_ = {};
  out_.consume(out_.size());
  welcomed_ = ready_ = in_control_ = ended_ = false;
  buttons_ = 0;
  position_s_ = -1e9;
  position_sequence_.reset();
  velocity_sequence_.reset();
  velocity_ = {};
  datagrams_.close();
  udp_refused_ = false;
  round_trip_s_.reset();
  server_ms_.reset();
}

void Client::set(ClientSetup setup) {
  setup_ = std::move(setup);
  if (welcomed_)
    send_setup();
}

void Client::send_setup() {
  if (setup_.workspace) {
    Message message(Address::kWorkspace);
    add_mm(message, setup_.workspace->min);
    send(add_mm(message, setup_.workspace->max));
  }
  if (!setup_.points.empty()) {
    send(Message(Address::kCpBegin).integer(static_cast<std::int32_t>(setup_.points.size())));
    for (std::size_t id = 0; id < setup_.points.size(); ++id) {
      Message message(Address::kCpSet);
      message.integer(static_cast<std::int32_t>(id));
      send(add_mm(message, setup_.points[id]));
    }
    send(Message(Address::kCpEnd));
  }
  if (setup_.gains)
    send(Message(Address::kGains)
             .real(setup_.gains->stiffness_min_n_per_m)
             .real(setup_.gains->stiffness_max_n_per_m)
             .real(setup_.gains->damping_min_n_s_per_m)
             .real(setup_.gains->damping_max_n_s_per_m));
  if (setup_.anchor) {
    Message message(Address::kAnchor);
    send(add_mm(message, *setup_.anchor));
  }
  if (setup_.force_limit_n)
    send(Message(Address::kForceMax).real(*setup_.force_limit_n));
}

void Client::start(RenderMode mode) {
  if (!welcomed_ || mode == RenderMode::kStopped)
    return;
  send(Message(Address::kStart).string(word_of(mode)));
  in_control_ = true;
  force_ = feedback_ = 0;
  trouble_.clear();
}

void Client::stop() {
  if (welcomed_)
    send(Message(Address::kStop));
  in_control_ = false;
}

void Client::send_force(const Vec3& force_n) {
  if (in_control_ && is_finite(force_n))
    send(
        Message(Address::kForce).integer(++force_).real(force_n.x).real(force_n.y).real(force_n.z));
}

void Client::send_feedback(const Vec3& gamma) {
  if (in_control_ && is_finite(gamma))
    send(
        Message(Address::kFeedback).integer(++feedback_).real(gamma.x).real(gamma.y).real(gamma.z));
}

bool Client::advance(double now_s) {
  if (ended_)
    return false;
  if (!welcomed_ && now_s - connected_s_ >= kWelcome_s) {
    trouble_ = "no haptic server answers at this address";
    return false;
  }
  if (now_s - last_message_s_ >= kSilence_s) {
    trouble_ = "the server has stopped sending";
    return false;
  }
  if (welcomed_ && now_s - pinged_s_ >= kPingInterval_s) {
    pinged_s_ = now_s;
    Message ping(Address::kPing);
    ping.integer(++ping_);
    if (server_ms_)
      ping.integer(*server_ms_);
    send(ping);
  }
  return !ended_;
}

bool Client::receive(std::span<const std::uint8_t> bytes, double now_s) {
  using Frame = FrameReader::Outcome;
  while (!ended_) {
    Message message;
    const Frame outcome = reader_.next(bytes, message);
    if (outcome == Frame::kNeedMore)
      return true;
    if (outcome != Frame::kMessage || reader_.framing() != Framing::kLength) {
      trouble_ = "the program at this address is not a haptic server";
      ended_ = true;
      break;
    }
    last_message_s_ = now_s;
    take(message, now_s);
  }
  return false;
}

void Client::receive_datagram(std::span<const std::uint8_t> bytes, double now_s) {
  Message message;
  if (!ended_ && datagrams_.take(bytes, message))
    take(message, now_s);
}

void Client::take(const Message& message, double now_s) {
  switch (message.address()) {
  case Address::kWelcome:
    return take_welcome(message);
  case Address::kStatus:
    return take_status(message);
  case Address::kError:
    return take_error(message);
  case Address::kBye:
    if (trouble_.empty())
      trouble_ = welcomed_
                     ? "the server closed the connection: " +
                           printable(message.string_at(0).value_or("no reason given"))
                     : "the server reports: " +
                           std::string(refusal_text_of_peer(message.string_at(0).value_or("")));
    ended_ = true;
    return;
  case Address::kPosition:
    if (const auto mm = newer_sample(message, position_sequence_)) {
      server_ms_ = message.integer_at(1);
      position_ = *mm * (1 / kMm_per_m);
      position_s_ = now_s;
      ready_ = welcomed_;
    }
    return;
  case Address::kVelocity:
    velocity_ = newer_sample(message, velocity_sequence_).value_or(velocity_);
    return;
  case Address::kButton: {
    const auto number = message.integer_at(0), on = message.integer_at(1);
    if (number && on && *number >= 0 && *number < 32)
      buttons_ = (buttons_ & ~(1u << *number)) | (*on != 0 ? 1u << *number : 0u);
    return;
  }
  case Address::kPong:
    server_ms_ = message.integer_at(1);
    if (message.integer_at(0) == ping_)
      round_trip_s_ = std::min(round_trip_s_.value_or(1e9), now_s - pinged_s_);
    return;
  default: // messages of newer servers are ignored
    return;
  }
}

void Client::take_welcome(const Message& message) {
  const auto protocol = message.integer_at(0), axes = message.integer_at(3);
  const auto device = message.string_at(1), model = message.string_at(2);
  const auto limit_n = message.number_at(4), rate_hz = message.number_at(5);
  if (!protocol || !axes || !device || !model || !limit_n || !rate_hz || *protocol < kProtocol ||
      !(*limit_n >= 0) || !(*rate_hz > 0)) {
    trouble_ = "the server's welcome message is not valid";
    ended_ = true;
    return;
  }
  welcome_ = {printable(*device), printable(*model), *axes, *limit_n, *rate_hz};
  welcomed_ = true;
  for (const std::string_view stream : {"pos", "vel"})
    send(Message(Address::kSubscribe)
             .string(stream)
             .real(std::min(settings_.position_hz, welcome_.rate_hz)));
  if (settings_.udp)
    send(Message(Address::kUdp).integer(1));
}

void Client::take_status(const Message& message) {
  const std::string_view word = message.string_at(0).value_or("");
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = message.number_at(i + 1).value_or(0);
  if (word == "workspace" && message.size() == 7) {
    const haptic::Workspace box{Vec3{numbers[0], numbers[1], numbers[2]} * (1 / kMm_per_m),
                                Vec3{numbers[3], numbers[4], numbers[5]} * (1 / kMm_per_m)};
    if (box.valid())
      welcome_.workspace = box;
  } else if (word == "limits" && message.size() == 3) {
    welcome_.stiffness_limit_n_per_m = numbers[0];
    welcome_.damping_limit_n_s_per_m = numbers[1];
  } else if (word == "udp" && settings_.udp) {
    const auto key = message.integer_at(1), port = message.integer_at(2);
    if (key && port && *key > 0 && *port > 0 && *port <= 65535)
      datagrams_.open(*key, *port);
    else
      udp_refused_ = true;
  } else if (word == "stopped" && in_control_) {
    trouble_ = "the server has stopped the motors: " +
               printable(message.string_at(1).value_or("no reason given"));
    lose_control();
  }
}

void Client::take_error(const Message& message) {
  const std::string_view code = message.string_at(0).value_or("");
  if (settings_.udp && code == "unknown" && message.string_at(1) == "udp") {
    udp_refused_ = true; // the server does not support datagrams
    return;
  }
  if (code == "stopped" && !in_control_)
    return; // answers a force sent before control was lost; the loss has been reported
  trouble_ = "the server reports: " + (welcomed_ ? printable(message.string_at(1).value_or(code))
                                                 : std::string(refusal_text_of_peer(code)));
  if (code == "busy" || code == "estop" || code == "role")
    lose_control();
}

void Client::lose_control() {
  in_control_ = false;
  ++refusals_;
}

} // namespace tactus::net
