#include "externals/haptic_server/haptic_server.hpp"

#include "core/haptic/device/force_timeout.hpp"
#include "core/refusal.hpp"
#include "net/host_messages.hpp"

#include <cmath>

namespace tactus::haptic_server {
namespace {

using net::text_of;

constexpr double kShortest_s = 5e-4;
constexpr double kPeriod_ms = 1, kM_per_mm = 1e-3, kMaxCoordinate_mm = 1e5;

/// Reads numbers of at most 1e5 in magnitude; false if one is a word or larger.
template <std::size_t N> bool numbers(std::span<const Atom> atoms, std::array<double, N>& values) {
  for (std::size_t i = 0; i < N; ++i) {
    if (atoms[i].is_word || !(std::abs(atoms[i].number) <= kMaxCoordinate_mm))
      return false;
    values[i] = atoms[i].number;
  }
  return true;
}

} // namespace

struct HapticServerObject::Service {
  Service(const net::ServerSettings& settings, haptic::Servo& servo, net::RenderModel& model,
          const haptic::ChainSettings& chain)
      : server(settings), link(servo, model, chain),
        sockets(server, {[this](double now_s) { link.exchange(server, now_s); },
                         [this] { link.send(server.servo_command()); }}) {}
  net::Server server;
  net::ServoLink link;
  net::TcpServer sockets;
};

HapticServerObject::HapticServerObject() = default;

HapticServerObject::~HapticServerObject() {
  if (service_)
    service_->sockets.close();
}

void HapticServerObject::open(Host& host) {
  close(host);
  haptic::Caps caps;
  caps.peak_force_n = limits_.force_n;
  caps.workspace_min = workspace_.min;
  caps.workspace_max = workspace_.max;
  caps.has_buttons = true;
  device_.set_caps(caps);
  net::ServerSettings settings;
  settings.device = "patch";
  settings.force_limit_n = limits_.force_n;
  settings.stiffness_limit_n_per_m = limits_.stiffness_n_per_m;
  settings.damping_limit_n_s_per_m = limits_.damping_n_s_per_m;
  settings.grab_radius_m = limits_.grab_mm * kM_per_mm;
  settings.workspace = workspace_;
  settings.token = token_;
  haptic::ChainSettings chain;
  chain.workspace = workspace_;
  servo_.attach(device_, &model_);
  service_ = std::make_unique<Service>(settings, servo_, model_, chain);
  if (const std::string refusal = service_->sockets.open({static_cast<int>(limits_.port), listen_});
      !refusal.empty()) {
    service_.reset();
    return host.error("open: " + refusal);
  }
  host.info({"status", "open", static_cast<double>(service_->sockets.port())});
  host.wake_in(0, kPeriod_ms);
}

void HapticServerObject::close(Host& host) {
  if (!service_)
    return;
  service_->sockets.close();
  send_notices(host);
  service_.reset();
  servo_.detach();
  host.wake_in(0, -1);
  static_cast<void>(device_.write({}));
  send_force(host);
  host.info({"status", "closed"});
}

/// The patch's clock triggers the servo's steps, but their time is wall-clock time, since the
/// clients use it.
void HapticServerObject::tick(std::size_t, Host& host) {
  if (!service_)
    return;
  service_->sockets.poll();
  // Several ticks of one audio block run at the same wall-clock moment; two steps need different
  // times.
  if (const double now_s = haptic::ForceTimeout::now_s(); now_s - stepped_s_ >= kShortest_s) {
    stepped_s_ = now_s;
    servo_.step({++ticks_, now_s, kPeriod_ms * 1e-3});
  }
  host.wake_in(0, kPeriod_ms);
  send_notices(host);
  send_force(host);
}

void HapticServerObject::send_force(Host& host) {
  const Vec3 force_n = device_.force_n();
  if (force_n == sent_n_)
    return;
  sent_n_ = force_n;
  host.send(0, {force_n.x, force_n.y, force_n.z});
}

void HapticServerObject::send_notices(Host& host) {
  for (const std::string& line : service_->server.take_notices()) {
    std::vector<Atom> words{"client"};
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t end = std::min(line.find(' ', at), line.size());
      words.emplace_back(std::string_view(line).substr(at, end - at));
      at = end + 1;
    }
    host.info(words);
  }
  if (const auto clipping = service_->server.take_clipping())
    host.info(
        {"status", "clipped", clipping->on ? 1.0 : 0.0, clipping->asked_n, clipping->limit_n});
}

bool HapticServerObject::stopped() noexcept { return servo_.exchange().motors.request().stopped; }

void HapticServerObject::dump(Host& host) {
  host.info({"listen", listen_.empty() ? std::string_view("loopback") : std::string_view(listen_)});
  host.info({"estop", stopped() ? 1.0 : 0.0});
  host.info({"status", service_ ? "open" : "closed"});
  if (service_)
    host.info({"clients", static_cast<double>(service_->server.clients())});
}

void HapticServerObject::set_position(std::span<const Atom> arguments, Host& host) {
  std::array<double, 3> mm{};
  if (!numbers(arguments, mm))
    return host.error(refusal("list", arguments, "x y z in mm"));
  device_.set_position(Vec3{mm[0], mm[1], mm[2]} * kM_per_mm);
}

void HapticServerObject::set_address(const Atom& address, Host&) {
  listen_ = text_of(address) == "loopback" ? std::string() : text_of(address);
}

void HapticServerObject::set_token(const Atom& file, Host& host) {
  if (std::optional<std::string> token = net::read_token(file, host))
    token_ = *std::move(token);
}

void HapticServerObject::set_workspace(std::span<const Atom> arguments, Host& host) {
  std::array<double, 6> mm{};
  const bool given = numbers(arguments, mm);
  const haptic::Workspace box{Vec3{mm[0], mm[1], mm[2]} * kM_per_mm,
                              Vec3{mm[3], mm[4], mm[5]} * kM_per_mm};
  if (!given || !box.valid())
    return host.error(
        refusal("workspace", arguments,
                "xmin ymin zmin xmax ymax zmax in mm, each minimum below its maximum"));
  workspace_ = box;
}

void HapticServerObject::set_button(std::span<const Atom> arguments, Host& host) {
  std::array<double, 2> given{};
  if (!numbers(arguments, given) || !(given[0] >= 0 && given[0] <= 31) ||
      given[0] != std::floor(given[0]))
    return host.error(refusal("button", arguments, "n 0 or n 1, with n in 0..31"));
  device_.set_button(static_cast<int>(given[0]), given[1] != 0);
}

void HapticServerObject::stop(Host& host) {
  servo_.exchange().motors.emergency_stop();
  host.info({"status", "estop", 1.0});
}

void HapticServerObject::enable(std::span<const Atom> arguments, Host& host) {
  if (arguments[0].is_word || arguments[0].number != 1)
    return host.error(
        refusal("motors", arguments, "1; clients switch the motors by start and stop"));
  if (stopped())
    host.info({"status", "estop", 0.0});
  servo_.exchange().motors.enable();
}

} // namespace tactus::haptic_server
