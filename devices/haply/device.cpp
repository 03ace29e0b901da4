#include "devices/haply/device.hpp"

#include "core/text.hpp"
#include "devices/servo_thread.hpp"

#include <limits>

namespace tactus::devices::haply {
namespace {

using haptic::State;

struct Limits {
  double peak_n, stiffness_n_per_m, damping_n_s_per_m, radius_m;
};
// The maker's CHAI3D fork gives these figures for a pantograph (HaplyHaptics/chai3d,
// src/devices/CHaplyDevices.cpp). Another fork gives 10 N, 1000 N/m, 6 N s/m, 0.15 m for the
// Inverse3 (jashenlow/chai3d_haply) without a source, so the lower figures are used.
constexpr Limits kInverse3{5, 300, 2, 0.1};
// No force limit in newtons was found for the Minverse. These figures are cautious; the radius is
// that of the working sphere on the maker's pages.
constexpr Limits kMinverse{4, 300, 2, 0.04};
// No continuous force was found for either device, so it has the share of a Touch, 0.88 N of 3.3 N,
// rounded down.
constexpr double kContinuousShare = 0.25;
// Position of the handle in the vendor's examples, for a service without presets: in front of and
// above the mounting plate. The service's axes, m.
constexpr Vec3 kCentreFromBase{0, -0.12, 0.15};
constexpr double kStale_s = 0.02;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

} // namespace

Device::Device() { settings_.address = default_address(); }

std::string Device::configure(std::span<const std::string> words) {
  const std::string name = words.empty() ? "nothing" : words[0];
  const double value = words.size() == 2 ? to_number(words[1]).value_or(kNaN) : kNaN;
  const std::lock_guard lock(settings_mutex_);
  if (name == "device" && words.size() == 2) {
    settings_.device = words[1];
  } else if (name == "service" && words.size() == 3) {
    const auto port = to_number(words[2], 1, 65535);
    if (!port)
      return "haply: port " + words[2] + ": expected 1..65535";
    settings_.address = {words[1], std::to_string(*port)};
  } else if (name == "rate" && value >= 50 && value <= 4000) {
    settings_.rate_hz = value;
  } else if (name == "peak" && value >= 0.1 && value <= 20) {
    peak_n_ = value;
  } else if (words.size() == 2 && (name == "rate" || name == "peak")) {
    return "haply: " + name + " " + words[1] + ": expected " +
           (name == "rate" ? "50..4000 Hz" : "0.1..20 N");
  } else {
    return "haply: setting " + name +
           ": expected device INDEX or ID, service HOST PORT, rate HZ (50..4000) or peak N "
           "(0.1..20)";
  }
  return {};
}

std::string Device::open() {
  Settings settings;
  double peak_n = 0;
  {
    const std::lock_guard lock(settings_mutex_);
    settings = settings_;
    peak_n = peak_n_;
  }
  if (std::string sentence = connection_.open(settings); !sentence.empty())
    return "haply: " + sentence;
  const DeviceState seen = connection_.device_state();
  const bool small = seen.type.find("minverse") != std::string::npos;
  const Limits& limits = small ? kMinverse : kInverse3;
  const Vec3 centre = connection_.centred() ? Vec3{} : to_project(kCentreFromBase);
  caps_ = {};
  caps_.peak_force_n = peak_n > 0 ? peak_n : limits.peak_n;
  caps_.continuous_force_n = kContinuousShare * caps_.peak_force_n;
  caps_.stiffness_limit_n_per_m = limits.stiffness_n_per_m;
  caps_.damping_limit_n_s_per_m = limits.damping_n_s_per_m;
  caps_.workspace_min = centre - Vec3{1, 1, 1} * limits.radius_m;
  caps_.workspace_max = centre + Vec3{1, 1, 1} * limits.radius_m;
  last_position_ = centre;
  caps_.rate_hz = settings.rate_hz;
  // A message carries a force to the service; its answer carries a state. The force computed from
  // that state is sent with the next message. The delay of the service itself is unknown.
  caps_.latency_ticks = 1;
  caps_.has_velocity = caps_.has_buttons = caps_.has_rotation = caps_.needs_home = true;
  identity_ = {"Haply", seen.type.empty() ? "inverse3" : seen.type, seen.id};
  calibrated_ = true;
  return {};
}

bool Device::read(const haptic::Tick& /*tick*/, State& state) noexcept {
  const Sample& sample = connection_.newest();
  state = sample.state;
  haptic::reject_unreachable(caps_, state, last_position_);
  calibrated_ = sample.calibrated;
  return ServoThread::now_s() - sample.time_s < kStale_s;
}

bool Device::write(const Vec3& force_n) noexcept {
  connection_.ask(limited(force_n, caps_.peak_force_n));
  return true;
}

std::string Device::trouble() const {
  if (const std::string sentence = connection_.trouble(); !sentence.empty())
    return "haply: " + sentence;
  return calibrated_ ? std::string()
                     : "haply: the device is not calibrated: put the "
                       "handle into its rest until the light is steady";
}

} // namespace tactus::devices::haply
