#include "net/server.hpp"

#include "net/limits.hpp"

namespace tactus::net {
namespace {} // namespace

void Server::send_streams(Session& session, double now_s) {
  const auto sample = [&](Address address, const Vec3& v) {
    const Message message = Message(address)
                                .integer(session.sample)
                                .integer(milliseconds(session, now_s))
                                .real(v.x)
                                .real(v.y)
                                .real(v.z);
    if (session.datagrams.reachable(now_s))
      session.datagrams.add(message);
    if (!session.datagrams.confirmed(now_s))
      session.send_sample(message);
    session.sample = (session.sample + 1) & session.last_count();
  };
  if (session.position.due(now_s))
    sample(Address::kPosition, report_.state.position * kMm_per_m);
  if (session.velocity.due(now_s))
    sample(Address::kVelocity, report_.state.velocity);
  if (grabbed_ && session.moves.due(now_s))
    session.send_sample(move_message());
}

/// Sends a button as an event. The first button grabs the nearest control point within reach.
void Server::set_button(int number, bool on) {
  broadcast(Message(Address::kButton).integer(number).integer(on ? 1 : 0));
  if (number != 0)
    return;
  if (!on)
    return release_point();
  if (!controller_ || grabbed_)
    return;
  const std::vector<Vec3>& points = controller_->setup.points;
  double nearest_m = settings_.grab_radius_m;
  for (std::size_t id = 0; id < points.size(); ++id) {
    const double distance_m = norm(points[id] - report_.state.position);
    if (distance_m <= nearest_m) {
      nearest_m = distance_m;
      grabbed_ = id;
    }
  }
  if (!grabbed_)
    return;
  grab_offset_ = points[*grabbed_] - report_.state.position;
  broadcast(Message(Address::kGrab).integer(static_cast<std::int32_t>(*grabbed_)).integer(1));
}

/// Moves the grabbed point with the handle within the client's workspace.
void Server::drag() noexcept {
  if (!grabbed_)
    return;
  const haptic::Workspace& box = controller_->setup.workspace;
  const Vec3 wanted = report_.state.position + grab_offset_;
  Vec3& point = controller_->setup.points[*grabbed_];
  for (int axis = 0; axis < 3; ++axis)
    point[axis] = std::clamp(wanted[axis], box.min[axis], box.max[axis]);
}

Message Server::move_message() const noexcept {
  const Vec3 mm = controller_->setup.points[*grabbed_] * kMm_per_m;
  return Message(Address::kCpMove)
      .integer(static_cast<std::int32_t>(*grabbed_))
      .real(mm.x)
      .real(mm.y)
      .real(mm.z);
}

/// Sends the position of the released point once more, as an event: the stream may have dropped the
/// last sample.
void Server::release_point() {
  if (!grabbed_)
    return;
  broadcast(move_message());
  broadcast(Message(Address::kGrab).integer(static_cast<std::int32_t>(*grabbed_)).integer(0));
  grabbed_.reset();
}

} // namespace tactus::net
