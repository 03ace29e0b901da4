#include "net/server.hpp"

#include "net/limits.hpp"

namespace tactus::net {
namespace {

/// Reads exactly N numbers as arguments; nullopt otherwise.
template <std::size_t N>
bool numbers(const Message& message, std::array<double, N>& values) noexcept {
  if (message.size() != N)
    return false;
  for (std::size_t i = 0; i < N; ++i) {
    const auto number = message.number_at(i);
    if (!number)
      return false;
    values[i] = *number;
  }
  return true;
}

} // namespace

/// Applies the setup of the client in control to the command for the servo.
void Server::apply_setup() noexcept {
  const Setup& setup = controller_->setup;
  servo_command_.render.gains = setup.gains;
  servo_command_.render.anchored = setup.anchor.has_value();
  servo_command_.render.anchor = setup.anchor.value_or(Vec3{});
  servo_command_.force_limit_n = setup.force_limit_n;
}

Server::Refusal Server::on_workspace(Session& session, Words message) {
  std::array<double, 6> mm{};
  if (!numbers(message, mm))
    return {"arguments", "expected workspace xmin ymin zmin xmax ymax zmax", true};
  const haptic::Workspace box{Vec3{mm[0], mm[1], mm[2]} * kM_per_mm,
                              Vec3{mm[3], mm[4], mm[5]} * kM_per_mm};
  if (!box.valid())
    return {"range", "workspace: expected each minimum below its maximum", true};
  session.setup.workspace = box;
  return {};
}

Server::Refusal Server::on_points(Session& session, Words message) {
  PointList& list = session.list;
  switch (message.address()) {
  case Address::kCpBegin: {
    const auto count = message.integer_at(0);
    if (!count || message.size() != 1)
      return {"arguments", "expected cp/begin number", true};
    if (*count < 0 || static_cast<std::size_t>(*count) > kMaxControlPoints)
      return {"range", "cp/begin: expected 0..4096 control points", true};
    list.begin(static_cast<std::size_t>(*count));
    return {};
  }
  case Address::kCpSet: {
    const auto id = message.integer_at(0);
    const auto x = message.number_at(1), y = message.number_at(2), z = message.number_at(3);
    if (!id || !x || !y || !z || message.size() != 4)
      return {"arguments", "expected cp/set id x y z", true};
    if (!list.open())
      return {"points", "send cp/begin first"};
    if (*id < 0 || static_cast<std::size_t>(*id) >= list.size())
      return {"range", "cp/set: expected an id below the number in cp/begin", true};
    list.set(static_cast<std::size_t>(*id), Vec3{*x, *y, *z} * kM_per_mm);
    return {};
  }
  case Address::kCpEnd:
    if (!list.open())
      return {"points", "send cp/begin first"};
    list.close();
    if (list.missing() > 0)
      return {"points", "not every control point was set: the old ones are kept"};
    break;
  default: // cp/clear
    list.begin(0);
    list.close();
  }
  if (controller_ == &session)
    release_point();
  session.setup.points = list.points();
  return {};
}

Server::Refusal Server::on_gains(Session& session, Words message) {
  std::array<double, 4> values{};
  if (!numbers(message, values))
    return {"arguments", "expected gains kmin kmax bmin bmax", true};
  const auto [kmin, kmax, bmin, bmax] = values;
  if (!(kmin >= 0 && kmin <= kmax && bmin >= 0 && bmin <= bmax))
    return {"range", "gains: expected 0 or more, each minimum not above its maximum", true};
  const double k = settings_.stiffness_limit_n_per_m, b = settings_.damping_limit_n_s_per_m;
  stress::RenderGains& gains = session.setup.gains;
  gains = {std::min(kmin, k), std::min(kmax, k), std::min(bmin, b), std::min(bmax, b)};
  session.send_event(Message(Address::kStatus)
                         .string("gains")
                         .real(gains.stiffness_min_n_per_m)
                         .real(gains.stiffness_max_n_per_m)
                         .real(gains.damping_min_n_s_per_m)
                         .real(gains.damping_max_n_s_per_m));
  if (controller_ == &session)
    apply_setup();
  return {};
}

Server::Refusal Server::on_force_max(Session& session, Words message) {
  std::array<double, 1> limit_n{};
  if (!numbers(message, limit_n))
    return {"arguments", "expected forcemax N", true};
  if (!(limit_n[0] >= 0))
    return {"range", "forcemax: expected 0 N or more", true};
  session.setup.force_limit_n = std::min(limit_n[0], settings_.force_limit_n);
  session.send_event(
      Message(Address::kStatus).string("forcemax").real(session.setup.force_limit_n));
  if (controller_ == &session)
    apply_setup();
  return {};
}

Server::Refusal Server::on_anchor(Session& session, Words message) {
  std::array<double, 3> mm{};
  if (!numbers(message, mm))
    return {"arguments", "expected anchor x y z", true};
  session.setup.anchor = Vec3{mm[0], mm[1], mm[2]} * kM_per_mm;
  if (controller_ == &session)
    apply_setup();
  return {};
}

Server::Refusal Server::on_subscribe(Session& session, Words message) {
  const auto what = message.string_at(0);
  const auto rate_hz = message.number_at(1);
  if (!what || !rate_hz || message.size() != 2)
    return {"arguments", "expected subscribe stream rate", true};
  Subscription* stream = *what == "pos"   ? &session.position
                         : *what == "vel" ? &session.velocity
                         : *what == "cp"  ? &session.moves
                                          : nullptr;
  if (!stream)
    return {"range", "subscribe: expected pos, vel or cp", true};
  if (!(*rate_hz >= 0 && *rate_hz <= settings_.rate_hz))
    return {"range", "subscribe: expected a rate from 0 to the device's", true};
  stream->set(*rate_hz);
  return {};
}

Server::Refusal Server::on_udp(Session& session, Words message) {
  const auto on = message.integer_at(0);
  if (!on || (*on != 0 && *on != 1) || message.size() != 1)
    return {"arguments", "expected udp 0 or udp 1", true};
  session.datagrams.close();
  if (*on == 1 && session.udp_port != 0)
    session.datagrams.open(make_datagram_key());
  const std::int32_t key = session.datagrams.key();
  session.send_event(Message(Address::kStatus)
                         .string("udp")
                         .integer(key)
                         .integer(key != 0 ? session.udp_port : 0));
  return {};
}

} // namespace tactus::net
