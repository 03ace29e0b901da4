#include "net/server.hpp"

#include "net/limits.hpp"

#include <cmath>

namespace tactus::net {
namespace {

std::optional<RenderMode> mode_of(std::string_view word) noexcept {
  if (word == "spring")
    return RenderMode::kSpring;
  if (word == "damper")
    return RenderMode::kDamper;
  if (word == "force")
    return RenderMode::kForce;
  return {};
}

/// Reads three numbers from that argument on.
std::optional<Vec3> vector_at(const Message& message, std::size_t first) noexcept {
  const auto x = message.number_at(first), y = message.number_at(first + 1),
             z = message.number_at(first + 2);
  return x && y && z ? std::optional(Vec3{*x, *y, *z}) : std::nullopt;
}

constexpr std::string_view kSequenceText =
    "the sequence number went back by more than 1000: continue counting, or restart at 0";

enum class Order { kNewer, kOld, kJump };

/// Compares by the difference in 32 bits, so the counter may overflow. The counter may restart at 0
/// or 1, and a value that Pd has rounded may repeat.
Order order_of(const std::optional<std::int32_t>& last, const Message& message) noexcept {
  if (!last)
    return Order::kNewer;
  const std::int32_t sequence = *message.integer_at(0);
  const auto ahead = static_cast<std::int32_t>(static_cast<std::uint32_t>(sequence) -
                                               static_cast<std::uint32_t>(*last));
  const bool begins = ahead < 0 && (sequence == 0 || sequence == 1);
  if (ahead > 0 || begins || (ahead == 0 && may_be_rounded(message[0])))
    return Order::kNewer;
  return ahead < -kSequenceWindow ? Order::kJump : Order::kOld;
}

} // namespace

Server::Refusal Server::handle(Session& session, Words message, double now_s) {
  const Address address = message.address();
  if (address == Address::kHello)
    return on_hello(session, message, now_s);
  if (address == Address::kPing && (session.admitted || !admission_.needs_token()))
    return on_ping(session, message, now_s);
  if (!session.admitted)
    return {"hello", "send hello first: hello protocol name role token"};
  switch (address) {
  case Address::kSubscribe:
    return on_subscribe(session, message);
  case Address::kUdp:
    return on_udp(session, message);
  case Address::kStop:
    if (controller_ == &session)
      release_control("stop");
    return {};
  case Address::kWorkspace:
  case Address::kCpBegin:
  case Address::kCpSet:
  case Address::kCpEnd:
  case Address::kCpClear:
  case Address::kGains:
  case Address::kForceMax:
  case Address::kAnchor:
  case Address::kStart:
  case Address::kFeedback:
  case Address::kForce:
    break;
  default:
    return {"unknown", message.name()};
  }
  if (session.role != Session::Role::kControl)
    return {"role", "an observer cannot change anything: send hello with the role control"};
  switch (address) {
  case Address::kWorkspace:
    return on_workspace(session, message);
  case Address::kGains:
    return on_gains(session, message);
  case Address::kForceMax:
    return on_force_max(session, message);
  case Address::kAnchor:
    return on_anchor(session, message);
  case Address::kStart:
    return on_start(session, message, now_s);
  case Address::kFeedback:
    return on_feedback(session, message);
  case Address::kForce:
    return on_force(session, message);
  default:
    return on_points(session, message);
  }
}

Server::Refusal Server::on_hello(Session& session, Words message, double now_s) {
  const auto protocol = message.integer_at(0);
  const auto name = message.string_at(1), role = message.string_at(2);
  if (!protocol || !name || !role || message.size() > 4 ||
      (message.size() == 4 && !message.string_at(3)))
    return {"arguments", "expected hello protocol name role token", true};
  const bool controls = *role == "control";
  if (!controls && *role != "observe")
    return {"arguments", "expected the role control or observe", true};
  if (session.admitted)
    return {"hello", "hello was already sent"};
  if (const auto code =
          admission_.admit(session.peer, message.string_at(3).value_or(""), *protocol, now_s);
      !code.empty()) {
    if (refusal_notices_.allow(now_s))
      log_event(session, "refused: " + std::string(refusal_text(code)));
    session.refuse_hello(code, now_s);
    return {};
  }
  session.admitted = true;
  session.name = name->empty() ? "-" : name->substr(0, kMaxName);
  session.role = controls ? Session::Role::kControl : Session::Role::kObserve;
  log_event(session, controls ? "connected" : "connected as observer");
  welcome(session);
  return {};
}

void Server::welcome(Session& session) {
  session.send_event(Message(Address::kWelcome)
                         .integer(kProtocol)
                         .string(settings_.device)
                         .string(settings_.model)
                         .integer(settings_.axes)
                         .real(settings_.force_limit_n)
                         .real(settings_.rate_hz));
  Message workspace(Address::kStatus);
  workspace.string("workspace");
  for (const Vec3& corner : {settings_.workspace.min, settings_.workspace.max})
    for (int axis = 0; axis < 3; ++axis)
      workspace.real(corner[axis] / kM_per_mm);
  session.send_event(workspace);
  session.send_event(Message(Address::kStatus)
                         .string("limits")
                         .real(settings_.stiffness_limit_n_per_m)
                         .real(settings_.damping_limit_n_s_per_m));
}

Server::Refusal Server::on_start(Session& session, Words message, double now_s) {
  const auto word = message.string_at(0);
  const auto mode = word && message.size() == 1 ? mode_of(*word) : std::nullopt;
  if (!mode)
    return {"arguments", "expected start spring, damper or force", true};
  if (controller_ && controller_ != &session)
    return {"busy", "another client is in control"};
  if (report_.emergency_stopped)
    return {"estop", "the emergency stop is on at the server: release it there"};
  controller_ = &session;
  faults_ = report_.faults;
  session.force_sequence.reset();
  session.feedback_sequence.reset();
  liveness_.start(now_s);
  servo_command_.running = true;
  servo_command_.render.mode = *mode;
  servo_command_.render.gamma = {};
  ++servo_command_.render.starts;
  servo_command_.force_n = {};
  ++servo_command_.forces;
  servo_command_.alive_s = now_s;
  apply_setup();
  log_event(session, "took control: " + std::string(*word));
  broadcast(Message(Address::kStatus).string("started").string(*word).string(session.name));
  return {};
}

Server::Refusal Server::on_force(Session& session, Words message) {
  const bool numbered = message.size() == 4;
  const auto sequence = message.integer_at(0);
  const auto force_n = vector_at(message, numbered ? 1 : 0);
  if (!force_n || (!numbered && message.size() != 3) || (numbered && !sequence))
    return {"arguments", "expected force fx fy fz, or force sequence fx fy fz", true};
  if (controller_ != &session || servo_command_.render.mode != RenderMode::kForce)
    return {"stopped", "send start force first"};
  if (numbered) {
    const Order order = order_of(session.force_sequence, message);
    if (order == Order::kJump)
      return {"sequence", kSequenceText, true};
    if (order == Order::kOld)
      return {};
    session.force_sequence = sequence;
  }
  servo_command_.force_n = *force_n;
  ++servo_command_.forces;
  return {};
}

Server::Refusal Server::on_feedback(Session& session, Words message) {
  const auto sequence = message.integer_at(0);
  const bool single = message.size() == 2;
  const auto number = message.number_at(1);
  const auto gamma =
      single && number ? std::optional(Vec3{*number, *number, *number}) : vector_at(message, 1);
  if (!sequence || !gamma || (!single && message.size() != 4))
    return {"arguments", "expected feedback sequence gamma, or three gammas", true};
  for (int axis = 0; axis < 3; ++axis)
    if (!((*gamma)[axis] >= 0 && (*gamma)[axis] <= 1))
      return {"range", "gamma: expected 0..1", true};
  const RenderMode mode = servo_command_.render.mode;
  if (controller_ != &session || (mode != RenderMode::kSpring && mode != RenderMode::kDamper))
    return {"stopped", "send start spring or start damper first"};
  const Order order = order_of(session.feedback_sequence, message);
  if (order == Order::kJump)
    return {"sequence", kSequenceText, true};
  if (order == Order::kOld)
    return {};
  session.feedback_sequence = sequence;
  servo_command_.render.gamma = *gamma;
  return {};
}

Server::Refusal Server::on_ping(Session& session, Words message, double now_s) {
  const auto sequence = message.integer_at(0);
  const auto echo = message.integer_at(1);
  if (!sequence || message.size() > 2 || (message.size() == 2 && !echo))
    return {"arguments", "expected ping sequence, or ping sequence ms", true};
  if (echo) {
    const std::int32_t last_ms = session.last_count(); // is a power of 2 minus 1, used as a mask
    const std::int32_t age_ms = (milliseconds(session, now_s) - *echo) & last_ms;
    if (*echo < 0 || *echo > last_ms || age_ms > last_ms / 2)
      return {"range", "the echoed time is in the future", true};
    session.echoed_s = std::max(session.echoed_s.value_or(-1e9), now_s - 1e-3 * age_ms);
  }
  session.send_event(
      Message(Address::kPong).integer(*sequence).integer(milliseconds(session, now_s)));
  return {};
}

/// Time since the first call, ms, in this client's counting range, after which it restarts at 0.
std::int32_t Server::milliseconds(const Session& session, double now_s) noexcept {
  if (!origin_s_)
    origin_s_ = now_s;
  const auto total_ms = static_cast<std::uint64_t>(std::max(0.0, now_s - *origin_s_) * 1e3);
  return static_cast<std::int32_t>(total_ms) & session.last_count();
}

} // namespace tactus::net
