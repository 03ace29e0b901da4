#include "devices/evdev/device.hpp"

#include "core/text.hpp"
#include "devices/evdev/joysticks.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace tactus::devices::evdev {
namespace {

using haptic::State;

constexpr auto kBetweenUploads = std::chrono::milliseconds(4);
// Values above 32767 ms are unspecified (linux/input.h, struct ff_replay). Many drivers take 0 as
// an endless effect, but hid-pidff.c sent it to PID devices as a duration of zero before it had
// PID_INFINITE.
constexpr std::uint16_t kLength_ms = 1000;
constexpr auto kBetweenStarts = std::chrono::milliseconds(250);
constexpr std::size_t kMaxButtons = 32;
constexpr int kMaxEventsPerTick = 256;

const char* permission_advice() {
  return "install packaging/udev/70-tactus.rules and plug the device in again, or join the group "
         "input and log in again";
}

} // namespace

std::string Device::configure(std::span<const std::string> words) {
  const std::string name = words.empty() ? "nothing" : words[0];
  const double value = words.size() == 2 ? to_number(words[1]).value_or(-1) : -1;
  const std::lock_guard lock(settings_mutex_);
  if (name == "device" && words.size() == 2)
    settings_.device = words[1];
  else if (name == "reach" && value >= 1 && value <= 1000)
    settings_.reach_m = value * 1e-3;
  else if (name == "peak" && value >= 0.1 && value <= 40)
    settings_.peak_n = value;
  else if (name == "wheel" && words.size() == 2 && words[1] == "auto")
    settings_.wheel.reset();
  else if (name == "wheel" && words.size() == 2 && (value == 0 || value == 1))
    settings_.wheel = value == 1;
  else if (name == "reverse" && words.size() == 2 && (value == 0 || value == 1))
    settings_.reverse = value == 1;
  else if (words.size() == 2 &&
           (name == "reach" || name == "peak" || name == "wheel" || name == "reverse"))
    return "evdev: " + name + " " + words[1] + ": expected " +
           (name == "reach"   ? "1..1000 mm"
            : name == "peak"  ? "0.1..40 N"
            : name == "wheel" ? "0, 1 or auto"
                              : "0 or 1");
  else
    return "evdev: setting " + name +
           ": expected device INDEX, /dev/input/eventN or SERIAL, reach MM (1..1000), peak N "
           "(0.1..40), wheel 0|1|auto or reverse 0|1";
  return {};
}

std::string Device::open() {
  close();
  {
    const std::lock_guard lock(settings_mutex_);
    active_settings_ = settings_;
  }
  const std::vector<Joystick> all = joysticks();
  if (all.empty())
    return "evdev: no joystick or wheel with constant-force feedback is plugged in: check its "
           "cable and, for a wheel, its power supply";
  const std::string& requested = active_settings_.device;
  auto found = all.begin();
  if (!requested.empty()) {
    found = std::find_if(all.begin(), all.end(), [&](const Joystick& one) {
      return one.node == requested || (!one.serial.empty() && one.serial == requested);
    });
    const auto index = to_number<std::size_t>(requested);
    if (found == all.end() && index && *index < all.size())
      found = all.begin() + static_cast<std::ptrdiff_t>(*index);
  }
  if (found == all.end())
    return "evdev: device " + requested + ": not found among " + std::to_string(all.size()) +
           " devices; the first is device 0, " + all.front().node + ", " + all.front().name;
  identity_ = {"", found->name, found->serial};
  std::string sentence = open_node(found->node);
  if (!sentence.empty())
    close();
  return sentence;
}

std::string Device::open_node(const std::string& node) {
  effect_ = {}; // first, so that close() removes only the effect of this opening
  effect_.type = FF_CONSTANT;
  effect_.id = -1;
  effect_.replay.length = kLength_ms;
  file_ = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0)
    return "evdev: " + node + " cannot be opened (" + std::strerror(errno) +
           "): " + (errno == EACCES ? permission_advice() : "plug the device in again");
  if (!read_axes())
    return "evdev: " + node +
           " has no axis X: it is not a joystick or wheel; choose another device";
  read_buttons();
  state_ = {};
  query_all();
  read_error_ = force_error_ = 0;
  dropping_ = false;
  // Sets full gain and switches off the device's own spring. A device without gain or spring
  // refuses the event, which does no harm.
  for (const auto& [code, value] : {std::pair{FF_GAIN, 0xFFFF}, std::pair{FF_AUTOCENTER, 0}}) {
    input_event event{};
    event.type = EV_FF;
    event.code = static_cast<unsigned short>(code);
    event.value = value;
    if (::write(file_, &event, sizeof event) < 0)
      continue;
  }
  two_axes_ = axes_[1].half > 0 && !active_settings_.wheel.value_or(looks_like_wheel());
  if (!upload(constant_force({}, active_settings_.peak_n, two_axes_)))
    return "evdev: " + node + " refuses a force (" + std::strerror(force_error_) +
           "): close other programs that use it, then open it again";
  if (!start())
    return "evdev: " + node + " cannot start a force (" + std::strerror(force_error_) +
           "): plug the device in again";
  caps_ = {};
  caps_.axes_in = axes_[2].half > 0 ? 3 : axes_[1].half > 0 ? 2 : 1;
  caps_.axes_out = two_axes_ ? 2 : 1;
  caps_.peak_force_n = active_settings_.peak_n;
  caps_.workspace_min = Vec3{1, 1, 1} * -active_settings_.reach_m;
  caps_.workspace_max = Vec3{1, 1, 1} * active_settings_.reach_m;
  caps_.position_noise_m = active_settings_.reach_m / (2 * axes_[0].half);
  caps_.rate_hz = 250;
  caps_.has_buttons = !buttons_.empty();
  forces_.reset();
  stop_ = false;
  try {
    sender_ = std::thread([this] { send_forces(); });
  } catch (const std::system_error&) {
    return "evdev: cannot start a thread for the device: close other programs";
  }
  return {};
}

void Device::close() noexcept {
  stop_ = true;
  if (sender_.joinable())
    sender_.join();
  if (file_ < 0)
    return;
  if (effect_.id >= 0) {
    static_cast<void>(upload(constant_force({}, active_settings_.peak_n, two_axes_)) && start());
    ioctl(file_, EVIOCRMFF, static_cast<long>(effect_.id));
  }
  ::close(file_);
  file_ = -1;
}

/// Returns false if the device lacks the first axis.
bool Device::read_axes() noexcept {
  for (Axis& axis : axes_) {
    input_absinfo range{};
    axis.half = 0;
    if (ioctl(file_, EVIOCGABS(static_cast<unsigned>(axis.code)), &range) < 0)
      continue;
    axis.centre = 0.5 * (static_cast<double>(range.minimum) + range.maximum);
    axis.half = std::max(0.0, 0.5 * (static_cast<double>(range.maximum) - range.minimum));
  }
  return axes_[0].half > 0;
}

void Device::read_buttons() {
  std::array<unsigned char, KEY_MAX / 8 + 1> keys{};
  buttons_.clear();
  if (ioctl(file_, EVIOCGBIT(EV_KEY, keys.size()), keys.data()) < 0)
    return;
  for (int code = BTN_MISC; code < KEY_MAX && buttons_.size() < kMaxButtons; ++code)
    if (keys[static_cast<std::size_t>(code / 8)] >> (code % 8) & 1)
      buttons_.push_back(code);
}

/// Queries all axes and buttons at the beginning and after events were lost.
void Device::query_all() noexcept {
  for (const Axis& axis : axes_) {
    input_absinfo now{};
    if (axis.half > 0 && ioctl(file_, EVIOCGABS(static_cast<unsigned>(axis.code)), &now) >= 0)
      set_axis(axis.code, now.value);
  }
  std::array<unsigned char, KEY_MAX / 8 + 1> keys{};
  if (ioctl(file_, EVIOCGKEY(keys.size()), keys.data()) < 0)
    return;
  state_.buttons = 0;
  for (std::size_t i = 0; i < buttons_.size(); ++i)
    if (keys[static_cast<std::size_t>(buttons_[i] / 8)] >> (buttons_[i] % 8) & 1)
      state_.buttons |= 1u << i;
}

void Device::set_axis(int code, int value) noexcept {
  for (const Axis& axis : axes_)
    if (axis.code == code && axis.half > 0)
      state_.position[axis.project_axis] = axis.sign * active_settings_.reach_m *
                                           std::clamp((value - axis.centre) / axis.half, -1.0, 1.0);
}

void Device::handle_event(const input_event& event) noexcept {
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    dropping_ = true;
  } else if (event.type == EV_SYN && event.code == SYN_REPORT && dropping_) {
    dropping_ = false;
    query_all();
  } else if (dropping_) {
    return;
  } else if (event.type == EV_ABS) {
    set_axis(event.code, event.value);
  } else if (event.type == EV_KEY) {
    const auto found = std::find(buttons_.begin(), buttons_.end(), static_cast<int>(event.code));
    if (found == buttons_.end())
      return;
    const std::uint32_t mask = 1u << (found - buttons_.begin());
    state_.buttons = event.value ? state_.buttons | mask : state_.buttons & ~mask;
  }
}

bool Device::read(const haptic::Tick& /*tick*/, State& state) noexcept {
  if (file_ < 0)
    return false;
  std::array<input_event, 32> events;
  for (int taken = 0; taken < kMaxEventsPerTick;) {
    const ssize_t got = ::read(file_, events.data(), sizeof events);
    if (got < 0 && errno != EAGAIN && errno != EINTR)
      read_error_ = errno;
    if (got <= 0)
      break;
    const auto count = static_cast<std::size_t>(got) / sizeof events[0];
    for (std::size_t i = 0; i < count; ++i)
      handle_event(events[i]);
    taken += static_cast<int>(count);
    if (count < events.size())
      break;
  }
  state = state_;
  return read_error_ == 0;
}

bool Device::write(const Vec3& force_n) noexcept {
  forces_.write(force_n);
  return file_ >= 0 && force_error_ == 0;
}

/// Many wheels have a pedal for the axis Y.
bool Device::looks_like_wheel() const {
  std::string name = identity_.model;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.find("wheel") != std::string::npos ||
         std::find(buttons_.begin(), buttons_.end(), BTN_WHEEL) != buttons_.end();
}

bool Device::upload(const ConstantForce& force) noexcept {
  effect_.u.constant.level = force.level;
  effect_.direction = force.direction;
  if (ioctl(file_, EVIOCSFF, &effect_) >= 0) {
    force_error_ = 0;
    return true;
  }
  force_error_ = errno;
  return false;
}

/// Starts the effect. If it is playing already, its duration restarts.
bool Device::start() noexcept {
  input_event play{};
  play.type = EV_FF;
  play.code = static_cast<unsigned short>(effect_.id);
  play.value = 1;
  if (::write(file_, &play, sizeof play) >= 0)
    return true;
  force_error_ = errno;
  return false;
}

ConstantForce Device::requested_force() noexcept {
  Vec3 force_n = forces_.read();
  force_n = force_n * forces_.gain(); // gain() belongs to the force that was read
  return constant_force(active_settings_.reverse ? -force_n : force_n, active_settings_.peak_n,
                        two_axes_);
}

void Device::send_forces() noexcept {
  auto next = std::chrono::steady_clock::now(), started = next;
  while (!stop_) {
    const ConstantForce requested = requested_force();
    const bool changed = force_error_ != 0 || requested.level != effect_.u.constant.level ||
                         requested.direction != effect_.direction;
    const auto now = std::chrono::steady_clock::now();
    if ((changed ? upload(requested) : now - started >= kBetweenStarts) && start())
      started = now;
    next = std::max(next + kBetweenUploads, std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
}

std::string Device::trouble() const {
  if (read_error_ == ENODEV || force_error_ == ENODEV)
    return "evdev: the device was unplugged: plug it in and open it again";
  if (const int error = read_error_)
    return std::string("evdev: the device cannot be read (") + std::strerror(error) +
           "): plug it in again and open it";
  if (const int error = force_error_)
    return std::string("evdev: the device refuses a force (") + std::strerror(error) +
           "): close other programs that use it, and for a wheel check its power supply";
  return {};
}

} // namespace tactus::devices::evdev
