#include "programs/haptic_server/station.hpp"

#include "core/haptic/device/path.hpp"
#include "devices/driver.hpp"
#include "devices/scoped_signal_mask.hpp"
#include "files/file_bytes.hpp"
#include "files/path_file.hpp"
#include "net/token_file.hpp"

#include <chrono>
#include <cstdio>

namespace tactus::haptic_server {
namespace {

constexpr double kUsualForce_n = 8, kUnknownPeak_n = 3.3, kUnknownStiffness_n_per_m = 500,
                 kUnknownDamping = 5;
constexpr double kShareOfStiffness =
    0.6; // fraction of the stiffness that the device renders stably
constexpr double kFade_s = 0.3;

double or_else(double value, double otherwise) { return value > 0 ? value : otherwise; }

net::ServerSettings settings_of(const Options& options, const haptic::Caps& caps,
                                const haptic::Identity& identity) {
  net::ServerSettings settings;
  settings.device = options.device.driver == "sim" ? "simulated" : options.device.driver;
  settings.model = identity.model.empty() ? "-" : identity.model;
  settings.axes = caps.axes_in;
  settings.rate_hz = options.rate_hz;
  const double peak_n = or_else(caps.peak_force_n, kUnknownPeak_n);
  settings.force_limit_n = std::min(peak_n, options.force_limit_n.value_or(kUsualForce_n));
  settings.stiffness_limit_n_per_m = options.stiffness_limit_n_per_m.value_or(
      or_else(kShareOfStiffness * caps.stiffness_limit_n_per_m, kUnknownStiffness_n_per_m));
  settings.damping_limit_n_s_per_m = options.damping_limit_n_s_per_m.value_or(
      or_else(caps.damping_limit_n_s_per_m, kUnknownDamping));
  settings.workspace = {caps.workspace_min, caps.workspace_max};
  settings.grab_radius_m = options.grab_radius_mm * 1e-3;
  return settings;
}

} // namespace

Station::~Station() { close(); }

std::string Station::hold_simulated(const Options& options) {
  using Hold = haptic::HandSettings::Hold;
  haptic::SimulatedDevice::Settings settings;
  settings.hand.hold = options.hand == "free"     ? Hold::kFree
                       : options.hand == "rigid"  ? Hold::kRigid
                       : options.hand == "person" ? Hold::kPerson
                                                  : Hold::kSpring;
  simulated_->set(settings);
  if (options.path.empty())
    return {};
  std::string text;
  if (const std::string refusal = files::read_file(options.path, text, files::kMaxPathBytes);
      !refusal.empty())
    return "the path " + options.path + ": " + refusal;
  files::ParsedPath parsed = files::parse_path(text);
  if (!parsed.error.empty())
    return options.path + ": " + parsed.error;
  simulated_->set_path(haptic::RowPath(std::move(parsed.rows)));
  return {};
}

std::string Station::make_device(const Options& options) {
  if (options.device.driver == "simulated" || options.device.driver == "sim") {
    auto made = std::make_unique<haptic::SimulatedDevice>();
    simulated_ = made.get();
    device_ = std::move(made);
    if (std::string error = hold_simulated(options); !error.empty())
      return error;
  } else {
    const devices::Driver* driver = devices::find_driver(options.device.driver);
    if (!driver)
      return "unknown driver " + options.device.driver + "; see --help";
    device_ = driver->make();
    if (!device_)
      return options.device.driver + ": " + driver->problem();
  }
  if (std::string refusal = programs::configure(*device_, options.device); !refusal.empty())
    return refusal;
  return device_->open();
}

std::string Station::open(const Options& options) {
  std::string token;
  if (!options.token_file.empty()) {
    net::TokenFile file = net::read_token_file(options.token_file);
    if (!file.error.empty())
      return file.error;
    if (file.open_to_others)
      std::fprintf(stderr, "haptic_server: other users can read %s: chmod 600 it\n",
                   options.token_file.c_str());
    token = std::move(file.token);
  }
  if (std::string error = make_device(options); !error.empty()) {
    device_.reset();
    return error;
  }
  return serve(options, token);
}

std::string Station::serve(const Options& options, const std::string& token) {
  const haptic::Caps caps = device_->caps();
  net::ServerSettings settings = settings_of(options, caps, device_->identity());
  settings.token = token;
  haptic::ChainSettings chain;
  chain.workspace = settings.workspace;
  servo_.exchange().tracing = !options.trace.empty();
  servo_.attach(*device_, &model_);
  server_ = std::make_unique<net::Server>(settings);
  link_ = std::make_unique<net::ServoLink>(servo_, model_, chain);
  sockets_ = std::make_unique<net::TcpServer>(
      *server_, net::TcpServer::Hooks{[this](double now_s) { tick(now_s); },
                                      [this] { link_->send(server_->servo_command()); }});
  if (std::string error = sockets_->open({options.port, options.listen, options.udp});
      !error.empty())
    return error;
  if (std::string error = servo_thread_.start(servo_, *device_, 1 / options.rate_hz);
      !error.empty())
    return error;
  char limit[32];
  std::snprintf(limit, sizeof limit, "%.3g", settings.force_limit_n);
  description_ =
      settings.device + ", " + limit + " N at most, on " + sockets_->addresses() +
      (options.udp ? " with datagrams on port " + std::to_string(sockets_->udp_port()) : "");
  const devices::ScopedSignalMask held;
  network_ = std::thread([this] { sockets_->run(); });
  return {};
}

void Station::tick(double now_s) {
  link_->exchange(*server_, now_s);
  all_clients_left_ = server_->connections_made() > 0 && server_->clients() == 0;
  std::vector<std::string> fresh = server_->take_notices();
  if (const auto clipping = server_->take_clipping(); clipping && clipping->on) {
    char line[96];
    std::snprintf(line, sizeof line, "the force is clipped: %.3g N requested, limit %.3g N",
                  clipping->asked_n, clipping->limit_n);
    fresh.emplace_back(line);
  }
  if (fresh.empty())
    return;
  const std::lock_guard lock(mutex_);
  notices_.insert(notices_.end(), fresh.begin(), fresh.end());
}

std::vector<std::string> Station::take_notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

void Station::close() {
  if (network_.joinable()) {
    sockets_->stop();
    network_.join();
  }
  if (servo_thread_.running()) {
    servo_.exchange().motors.pause(true);
    const double give_up_s = devices::ServoThread::now_s() + kFade_s;
    while (!servo_.exchange().motors.zero_force_confirmed() &&
           devices::ServoThread::now_s() < give_up_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    static_cast<void>(servo_thread_.stop());
  }
  servo_.detach();
  if (device_)
    device_->close();
}

} // namespace tactus::haptic_server
