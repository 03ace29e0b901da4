#include "devices/force_dimension/device.hpp"

#include "core/text.hpp"
#include "devices/force_dimension/limits.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace tactus::devices::force_dimension {
namespace {

using haptic::State;

constexpr int kSerialsFrom = 64;
constexpr unsigned char kWatchdogSteps = 240, kNoWatchdog = 0; // 240 steps of 125 us are 30 ms
constexpr int kStatusEvery_ticks = 64;
constexpr int kErrorFree_ticks = 200;
constexpr std::array<int, 3> kPausesBetweenTries_ms{0, 100, 400};
constexpr int kPoll_ms = 20; // interval at which a cancelled opening is detected

Vec3 to_project(double x, double y, double z) noexcept { return {y, z, x}; }

const char* meaning(int cause) noexcept {
  switch (cause) {
  case kForceButton:
    return "the force button switched the motors off: press it again, then send motors 1";
  case kTooFast:
    return "the handle moved too fast and the device switched its motors off: hold it, then send "
           "motors 1";
  case kWatchdog:
    return "the device received nothing for 30 ms and switched its motors off: send motors 1; if "
           "it happens again, the computer is too busy";
  case kUnplugged:
    return "the cable was unplugged: plug it in and open the device again";
  case kDeadMan:
    return "the grip is not held: hold it, then send motors 1";
  default:
    return "the motors are off: send motors 1";
  }
}

} // namespace

std::string Device::configure(std::span<const std::string> words) {
  if (words.size() == 1 && (words[0] == "home" || words[0] == "calibrate")) {
    const std::lock_guard lock(settings_mutex_);
    if (has_auto_init_) {
      const std::string reason = auto_init_.start();
      return reason.empty() ? reason : "dhd: " + reason;
    }
    reset_requested_ = true;
    return {};
  }
  if (words.empty() || words[0] != "device")
    return "dhd: setting " + (words.empty() ? std::string("nothing") : words[0]) +
           ": expected device INDEX or SERIAL, or home";
  const int which = words.size() == 2 ? to_number<int>(words[1]).value_or(-1) : -1;
  if (which < 0)
    return "dhd: device: expected an index from 0 or a serial number; send devices for a list";
  const std::lock_guard lock(settings_mutex_);
  requested_ = which;
  return {};
}

int Device::open_requested(int requested) {
  if (requested < kSerialsFrom)
    return library_.open_id(static_cast<char>(requested));
  return library_.open_serial ? library_.open_serial(requested) : -1;
}

std::string Device::open_with_retries(int requested) {
  const int count = library_.device_count();
  for (const int pause_ms : kPausesBetweenTries_ms) {
    for (int waited_ms = 0; waited_ms < pause_ms && !cancelled_; waited_ms += kPoll_ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
    if (cancelled_)
      return "dhd: opening was cancelled: open the device again";
    id_ = open_requested(requested);
    if (id_ >= 0 && is_open("dhd", std::to_string(id_))) {
      id_ = -1; // another object owns the device and keeps it open
      return "dhd: the device is already open in this program: close it there";
    }
    if (id_ >= 0)
      return {};
  }
  const char* reason = library_.last_error();
  return "dhd: device " + std::to_string(requested) + " cannot be opened (" +
         (reason ? reason : "unknown error") + "; " + std::to_string(count) +
         " connected): check its cable and power, that no other program uses "
         "it, and that your account may use USB devices (70-tactus.rules)";
}

/// Returns false if the controller has no watchdog, as older ones, or if the library cannot set it.
bool Device::set_watchdog(unsigned char steps) noexcept {
  if (!library_.expert_mode || !library_.set_watchdog || library_.expert_mode() < 0)
    return false;
  const bool set = library_.set_watchdog(steps, static_cast<char>(id_)) >= 0;
  if (library_.ordinary_mode)
    library_.ordinary_mode();
  return set;
}

/// Capabilities of wrist and gripper: values that the device reports take precedence over the
/// table's.
void Device::detect_wrist() noexcept {
  const auto id = static_cast<char>(id_);
  wrist_ = caps_.has_rotation =
      library_.has_wrist && library_.orientation && library_.has_wrist(id);
  caps_.has_gripper = library_.has_gripper && library_.gripper_gap && library_.has_gripper(id);
  if (!library_.set_all || !library_.has_active_wrist || !library_.has_active_wrist(id))
    caps_.peak_torque_n_m = 0;
  if (!library_.set_all || !library_.has_active_gripper || !library_.has_active_gripper(id))
    caps_.peak_grip_n = 0;
}

std::string Device::open() {
  close();
  cancelled_ = false;
  if (std::string sentence = library_.load(); !sentence.empty())
    return "dhd: " + sentence;
  int requested = 0;
  {
    const std::lock_guard lock(settings_mutex_);
    requested = requested_;
  }
  if (std::string sentence = open_with_retries(requested); !sentence.empty())
    return sentence;
  const auto id = static_cast<char>(id_);
  const char* name = library_.system_name ? library_.system_name(id) : nullptr;
  const Model& model = model_of(library_.system_type(id), name ? name : "");
  caps_ = caps_of(model);
  unsigned short serial = 0;
  const bool has_serial = library_.serial_number && library_.serial_number(&serial, id) >= 0;
  identity_ = {"Force Dimension", name ? name : std::string(model.name),
               has_serial ? std::to_string(serial) : ""};
  open_.set("dhd", requested < kSerialsFrom ? requested : id_, identity_, std::to_string(id_));
  caps_.has_buttons = library_.button_mask != nullptr;
  detect_wrist();
  {
    const std::lock_guard lock(settings_mutex_);
    has_auto_init_ = auto_init_.prepare(library_, id);
  }
  if (library_.set_max_force)
    library_.set_max_force(caps_.peak_force_n, id);
  // The watchdog is enabled with the first force, since nothing resets it before. The value 0
  // disables it (forcedimension_core, dhd.expert.setWatchdog). The call also shows whether the
  // controller has a watchdog.
  const bool watched = set_watchdog(kNoWatchdog);
  watchdog_due_ = has_watchdog_ = watched;
  initialising_ = false;
  library_.enable_force(1, id);
  library_.set_force(0, 0, 0, id);
  until_status_ = until_watchdog_ = error_free_ticks_ = 0;
  state_ = {};
  homed_ = true;
  limited_ = false;
  last_position_ = {};
  wrist_command_ = {};
  wrist_driven_ = false;
  timeout_ = {};
  written_s_ = -1e9;
  force_off_cause_ = kNoCause;
  needs_reset_ = broken_ = reset_requested_ = false;
  error_ = nullptr;
  if (watched)
    return {};
  const auto end_force = [](void* self) noexcept {
    auto& device = *static_cast<Device*>(self);
    if (!device.initialising_)
      static_cast<void>(device.send({}, {}));
  };
  std::string problem = stall_guard_.start(end_force, this);
  if (!problem.empty())
    close();
  return problem.empty() ? problem : "dhd: " + problem;
}

void Device::close() noexcept {
  stall_guard_.stop();
  if (id_ >= 0) {
    const auto id = static_cast<char>(id_);
    bool closed = false;
    {
      const std::lock_guard lock(settings_mutex_);
      has_auto_init_ = false;
      closed = auto_init_.stop_and_close();
    }
    if (!closed) {
      static_cast<void>(send({}, {}));
      library_.enable_force(0, id);
      library_.close(id);
    }
    id_ = -1;
  }
  error_ = nullptr;
  open_.clear();
}

bool Device::answered(int result) noexcept {
  if (result >= 0)
    return true;
  error_ = library_.last_error();
  return false;
}

void Device::update_status() noexcept {
  if (!library_.status || --until_status_ > 0)
    return;
  until_status_ = kStatusEvery_ticks;
  status_ = {};
  const auto id = static_cast<char>(id_);
  if (!answered(library_.status(status_.data(), id)))
    return;
  needs_reset_ = status_[kNeedsReset] != 0;
  homed_ = !needs_reset_;
  broken_ = status_[kBroken] != 0;
  if (status_[kForceOn]) {
    force_off_cause_ = kNoCause;
    return;
  }
  const int cause = status_[kForceOffCause];
  force_off_cause_ = cause == kNoCause ? static_cast<int>(kSoftware) : cause;
  const bool by_hand = cause == kForceButton || cause == kUnplugged || cause == kDeadMan;
  if (!by_hand && error_free_ticks_ >= kErrorFree_ticks)
    library_.enable_force(1, id);
}

bool Device::read(const haptic::Tick& /*tick*/, State& state) noexcept {
  if (id_ < 0 || !stall_guard_.enter())
    return false;
  const bool well = read_device(state);
  stall_guard_.leave();
  return well;
}

bool Device::read_device(State& state) noexcept {
  const auto id = static_cast<char>(id_);
  switch (auto_init_.turn()) {
  case AutoInit::Turn::kBegins:
    static_cast<void>(send({}, {}));
    [[fallthrough]];
  case AutoInit::Turn::kRunning:
    initialising_ = true;
    homed_ = false;
    state = state_;
    state.velocity = {};
    state.flags = 0;
    return true;
  case AutoInit::Turn::kEnded:
    initialising_ = false;
    until_status_ = 0;
    watchdog_due_ = has_watchdog_;
    break;
  case AutoInit::Turn::kServo:
    break;
  }
  double x = 0, y = 0, z = 0;
  if (!answered(library_.position(&x, &y, &z, id)))
    return false;
  state.position = to_project(x, y, z);
  if (!answered(library_.linear_velocity(&x, &y, &z, id)))
    return false;
  state.velocity = to_project(x, y, z);
  if (wrist_ && library_.orientation(&x, &y, &z, id) >= 0)
    state.rotation = to_project(x, y, z);
  if (caps_.has_gripper && library_.gripper_gap(&x, id) >= 0 && std::isfinite(x))
    state.gripper_m = x;
  state.buttons = library_.button_mask ? library_.button_mask(id) : 0u;
  if (reset_requested_.exchange(false) && library_.reset) {
    static_cast<void>(library_.reset(id));
    until_status_ = 0; // reads the status in this tick, so no force follows
  }
  update_status();
  error_ = nullptr;
  state.flags = homed_ ? State::kHomed : 0u;
  if (force_off_cause_ != kNoCause || broken_)
    state.flags |= State::kFault;
  if (limited_)
    state.flags |= State::kForceLimited;
  haptic::reject_unreachable(caps_, state, last_position_);
  state_ = state;
  return true;
}

bool Device::write(const Vec3& force_n) noexcept {
  if (id_ < 0 || !stall_guard_.enter())
    return false;
  const bool well = write_device(force_n);
  stall_guard_.leave();
  return well;
}

void Device::set_wrist(const haptic::WristCommand& command) noexcept {
  if (caps_.peak_torque_n_m <= 0 && caps_.peak_grip_n <= 0)
    return;
  wrist_command_ = command;
  wrist_driven_ = true;
}

int Device::send(const Vec3& force_n, const haptic::WristCommand& wrist) noexcept {
  const auto id = static_cast<char>(id_);
  if (!wrist_driven_)
    return library_.set_force(force_n.z, force_n.x, force_n.y, id);
  const Vec3& t = wrist.torque_n_m;
  return library_.set_all(force_n.z, force_n.x, force_n.y, t.z, t.x, t.y, wrist.grip_n, id);
}

bool Device::write_device(const Vec3& force_n) noexcept {
  if (initialising_)
    return force_n == Vec3{};
  const double now_s = haptic::ForceTimeout::now_s();
  const double share = timeout_.gain(std::exchange(written_s_, now_s), now_s);
  const bool none = force_n == Vec3{};
  error_free_ticks_ = none ? std::min(error_free_ticks_ + 1, kErrorFree_ticks) : 0;
  const bool allowed = homed_ && force_off_cause_ == kNoCause && is_finite(force_n);
  const Vec3 f = allowed ? limited(force_n, caps_.peak_force_n) * share : Vec3{};
  const haptic::WristCommand asked = std::exchange(wrist_command_, {});
  haptic::WristCommand wrist;
  if (allowed) {
    wrist.torque_n_m = limited(asked.torque_n_m, caps_.peak_torque_n_m) * share;
    if (std::isfinite(asked.grip_n))
      wrist.grip_n = std::clamp(asked.grip_n, -caps_.peak_grip_n, caps_.peak_grip_n) * share;
  }
  if (watchdog_due_ && --until_watchdog_ <= 0) {
    watchdog_due_ = !set_watchdog(kWatchdogSteps);
    until_watchdog_ = kStatusEvery_ticks;
  }
  const int result = send(f, wrist);
  limited_ = result == kMotorSaturated;
  return answered(result) && (allowed || none);
}

std::string Device::trouble() const {
  if (const char* error = error_)
    return std::string("dhd: the device does not answer (") + error +
           "): check its cable and power, then open it again";
  if (broken_)
    return "dhd: the device reports a fault: switch it off and on and open it again";
  const std::lock_guard lock(settings_mutex_);
  if (has_auto_init_ && auto_init_.failed())
    return std::string("dhd: the device could not initialise itself (") + auto_init_.why() +
           "): remove what blocks the arm and send home again";
  if (needs_reset_ && has_auto_init_)
    return "dhd: the device is not initialised: let go of it and send home; its motors will move "
           "it";
  if (needs_reset_)
    return "dhd: the device is not calibrated: put the calibration pole into its hole until the "
           "light stops blinking";
  if (const int cause = force_off_cause_; cause != kNoCause)
    return std::string("dhd: ") + meaning(cause);
  return {};
}

} // namespace tactus::devices::force_dimension
