#include "devices/hid/hid.hpp"

#include "devices/real_time.hpp"
#include "files/file_bytes.hpp"

#include <algorithm>
#include <array>
#include <system_error>

namespace tactus::devices::hid {
namespace {

constexpr double kHalf_m = 0.05; // the workspace is +-50 mm
constexpr int kWait_ms = 20;     // interval at which requests of other threads are checked
constexpr int kLowBattery = 10;
constexpr std::uint8_t kLightReport = 4;

} // namespace

std::string Hid::open() {
  close();
  Settings settings;
  {
    const std::scoped_lock lock(mutex_);
    settings = settings_;
  }
  std::string problem;
  library_ = HidLibrary::get(settings.transport, problem);
  if (!library_)
    return problem;
  Entry entry;
  problem = find(settings, entry);
  if (!problem.empty())
    return problem;
  device_ = library_->open_path(entry.path.c_str());
  if (!device_)
    return entry.identity.model + " at " + entry.path + " cannot be opened: " +
           (entry.problem.empty() ? "close the program that uses it, or plug it in again"
                                  : entry.problem);
  problem = prepare(settings, entry);
  if (problem.empty()) {
    stopping_ = lost_ = false;
    try {
      reader_ = std::thread([this] { read_reports(); });
    } catch (const std::system_error&) {
      problem = "cannot start a thread for the device: close other programs";
    }
  }
  if (!problem.empty())
    close();
  const std::scoped_lock lock(mutex_);
  identity_ = entry.identity;
  return problem;
}

std::string Hid::find(const Settings& settings, Entry& entry) {
  const std::string& which = settings.device;
  const bool by_path = which.find('/') != std::string::npos || which.find(':') != std::string::npos;
  const std::vector<Entry> entries = catalogue(*library_, by_path);
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (which.empty() || which == std::to_string(i) || which == entries[i].path ||
        which == entries[i].identity.serial) {
      entry = entries[i];
      return {};
    }
  if (entries.empty())
    return "no six-axis controller, joystick or game pad is plugged in: check its cable or "
           "receiver";
  return "HID device " + which + ": not found; send devices for a list, or give its path";
}

std::string Hid::prepare(const Settings& settings, const Entry& entry) {
  const auto description = describe(*library_, device_, entry.path);
  space_mouse_ = entry.space_mouse;
  if (space_mouse_)
    decoder_ = Decoder::space_mouse(description.value_or(ReportDescriptor{}));
  else if (description)
    decoder_ = Decoder::described(*description);
  else
    return entry.identity.model + " has no report descriptor through this hidapi: "
                                  "install Debian's libhidapi-hidraw0";
  axes_ = decoder_.axes();
  step_ = decoder_.step();
  has_buttons_ = decoder_.has_buttons();
  if (axes_ == 0)
    return entry.identity.model + " has no axis: choose another device";
  table_ = AxisTable::default_for(axes_, space_mouse_ &&
                                             is_early_space_mouse(entry.vendor, entry.product));
  if (!settings.table.empty()) {
    constexpr std::uint64_t kMaxBytes = 1u << 20;
    std::string text;
    if (!files::read_file(settings.table, text, kMaxBytes).empty())
      return "the axis table " + settings.table + " cannot be read: check its path";
    const std::string parse_error = table_.read(text);
    if (!parse_error.empty())
      return settings.table + ": " + parse_error;
  }
  knobs_.write(Knob{});
  battery_percent_ = -1;
  position_ = {};
  glide_.reset();
  begun_ = false;
  return {};
}

void Hid::close() noexcept {
  stopping_ = true;
  if (reader_.joinable())
    reader_.join();
  if (device_)
    library_->close(device_);
  device_ = nullptr;
}

void Hid::light(bool on) noexcept {
  const std::array<std::uint8_t, 2> report{kLightReport, static_cast<std::uint8_t>(on)};
  library_->write(device_, report.data(), report.size());
}

void Hid::read_reports() noexcept {
  raise_thread_priority(kDeviceThreadPriority);
  bool light_is_on = false;
  while (!stopping_) {
    if (space_mouse_ && light_is_on != light_) {
      light_is_on = light_;
      light(light_is_on);
    }
    std::array<std::uint8_t, 256> report{};
    const int length = library_->read_timeout(device_, report.data(), report.size(), kWait_ms);
    if (length < 0) {
      lost_ = true;
      return;
    }
    if (length == 0)
      continue;
    const auto count = std::min(static_cast<std::size_t>(length), report.size());
    if (!decoder_.decode({report.data(), count}))
      continue;
    knobs_.write(decoder_.knob());
    battery_percent_.store(decoder_.knob().battery_percent, std::memory_order_relaxed);
  }
  if (space_mouse_ && light_is_on)
    light(false);
}

haptic::Caps Hid::caps() const noexcept {
  haptic::Caps caps;
  caps.axes_out = 0;
  caps.workspace_min = {-kHalf_m, -kHalf_m, -kHalf_m};
  caps.workspace_max = {kHalf_m, kHalf_m, kHalf_m};
  caps.position_noise_m = rate_ ? 0 : 0.5 * step_ * kHalf_m;
  caps.has_buttons = has_buttons_;
  caps.has_rotation = (axes_ & 0x38) != 0;
  return caps;
}

bool Hid::read(const haptic::Tick& tick, haptic::State& state) noexcept {
  const double passed_s = begun_ ? std::clamp(tick.time_s - time_s_, 0.0, 0.1) : 0;
  time_s_ = tick.time_s;
  begun_ = true;
  if (!device_ || lost_.load(std::memory_order_relaxed))
    return false;
  knobs_.read();
  const Knob& knob = knobs_.latest();
  const double dead_zone = dead_zone_.load(std::memory_order_relaxed);
  Vec3 share = table_.position(knob), turn = table_.rotation(knob);
  for (int axis = 0; axis < 3; ++axis) {
    share[axis] = apply_dead_zone(share[axis], dead_zone);
    turn[axis] = apply_dead_zone(turn[axis], dead_zone);
  }
  if (rate_.load(std::memory_order_relaxed)) {
    const double speed = speed_m_per_s_.load(std::memory_order_relaxed);
    for (int axis = 0; axis < 3; ++axis)
      position_[axis] =
          std::clamp(position_[axis] + share[axis] * speed * passed_s, -kHalf_m, kHalf_m);
    glide_.reset();
  } else {
    position_ = glide_.update(share * kHalf_m, tick.time_s);
  }
  state.position = position_;
  state.rotation = turn;
  state.buttons = knob.buttons;
  state.flags = haptic::State::kHomed;
  return true;
}

bool Hid::write(const Vec3&) noexcept { return device_ && !lost_.load(std::memory_order_relaxed); }

haptic::Identity Hid::identity() const {
  const std::scoped_lock lock(mutex_);
  return identity_;
}

std::string Hid::trouble() const {
  if (lost_)
    return "the device was disconnected: plug it in, or switch it on, and open it again";
  const int battery = battery_percent_;
  if (battery >= 0 && battery <= kLowBattery)
    return "the device's battery is at " + std::to_string(battery) + " %: charge it";
  return {};
}

} // namespace tactus::devices::hid
