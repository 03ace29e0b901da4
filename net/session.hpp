#pragma once

#include "core/haptic/device/workspace.hpp"
#include "core/stress/render.hpp"
#include "net/datagrams.hpp"
#include "net/peer_connection.hpp"

#include <optional>
#include <vector>

namespace tactus::net {

/// The settings of a client; they take effect while that client is in control.
struct Setup {
  haptic::Workspace workspace{}; ///< m; dragged points stay inside
  std::vector<Vec3> points{};    ///< control points, m
  stress::RenderGains gains{};
  std::optional<Vec3> anchor{}; ///< m
  double force_limit_n = 0;
};

/// The list of control points while a client sends it, between cp/begin and cp/end.
class PointList {
public:
  void begin(std::size_t count) {
    points_.assign(count, {});
    is_set_.assign(count, false);
    missing_ = count;
    open_ = true;
  }
  [[nodiscard]] bool open() const noexcept { return open_; }
  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
  [[nodiscard]] std::size_t missing() const noexcept { return missing_; }
  void set(std::size_t id, const Vec3& position) noexcept {
    points_[id] = position;
    missing_ -= is_set_[id] ? 0 : 1;
    is_set_[id] = true;
  }
  void close() noexcept { open_ = false; }
  [[nodiscard]] const std::vector<Vec3>& points() const noexcept { return points_; }

private:
  std::vector<Vec3> points_{};
  std::vector<bool> is_set_{};
  std::size_t missing_ = 0;
  bool open_ = false;
};

/// A stream of samples that a client has subscribed to.
class Subscription {
public:
  explicit Subscription(double rate_hz = 0) noexcept : rate_hz_(rate_hz) {}
  void set(double rate_hz) noexcept { rate_hz_ = rate_hz; }
  /// True if a sample is due; missed times are skipped.
  [[nodiscard]] bool due(double now_s) noexcept {
    constexpr double kRounding_s = 1e-6;
    if (!(rate_hz_ > 0) || now_s < next_s_ - kRounding_s)
      return false;
    const double period_s = 1 / rate_hz_;
    next_s_ = next_s_ + period_s > now_s ? next_s_ + period_s : now_s + period_s;
    return true;
  }

private:
  double rate_hz_ = 0, next_s_ = 0;
};

/// One client of the haptic server.
struct Session : PeerConnection {
  enum class Role : std::uint8_t { kNone, kObserve, kControl };
  static constexpr double kDefaultPoint_hz = 60;

  Session(std::string peer_address, int datagram_port, double now_s)
      : PeerConnection(std::move(peer_address), now_s), udp_port(datagram_port) {}

  Role role = Role::kNone;
  int udp_port;                     ///< the server's port for the client's probes; 0 without
                                    ///< datagrams
  std::optional<double> echoed_s{}; ///< the latest of the server's times that the client sent back

  Setup setup{};
  PointList list{};
  std::optional<std::int32_t> force_sequence{}, feedback_sequence{};
  Subscription position{}, velocity{}, moves{kDefaultPoint_hz};
  std::int32_t sample = 0; ///< counts samples of pos and vel
  DatagramSender datagrams{};
};

} // namespace tactus::net
