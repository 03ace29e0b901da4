#include "devices/openhaptics/device.hpp"

#include "devices/openhaptics/limits.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

namespace tactus::devices::openhaptics {
namespace {

using haptic::State;
using Milliseconds = std::chrono::milliseconds;

constexpr int kCalibrationCheck_ticks = 256;
constexpr int kErrorHold_ticks = 500;
constexpr int kSettling_ticks = 50; // time until the velocity settles after a calibration;
                                    // estimated
constexpr int kErrorFree_ticks = 200;
constexpr std::array<int, 3> kPausesBetweenTries_ms{0, 100, 400};
constexpr int kPoll_ms = 20; // interval at which a cancelled opening is detected

// The vendor has one scheduler for all of its devices.
std::mutex scheduler_guard;
int scheduler_users = 0;

std::string meaning(Code error) {
  switch (error) {
  case kWarmMotors:
    return "the motors are warm: let go and wait some minutes, then use less force";
  case kTooMuchForce:
    return "the force exceeds the device's peak force: lower forcemax";
  case kTooMuchImpulse:
    return "the force changed too fast and the device switched it off: lower slew";
  case kTooMuchVelocity:
    return "the handle moved too fast and the device switched the force off: hold it, then send "
           "motors 1";
  case kForceError:
    return "the device refused a force: hold the handle, then send motors 1";
  case kDeviceFault:
    return "the device reports a fault: switch it off and on and open it again";
  case kAlreadyOpen:
    return "another program uses the device: close that program and open it again";
  case kNoAnswer:
    return "the device does not answer: check its cable and power, then open it again";
  case kWrongPort:
    return "the device has moved to another port since the vendor's set-up tool ran: run it again";
  case kTimerError:
    return "the vendor's scheduler lost its timer: close and open the device";
  case kFrameError:
    return "another program writes to the device at the same time: close it";
  case kNoLicence:
    return "the vendor's licence is missing or not valid: install it with the vendor's licence "
           "tool";
  default: {
    char text[64];
    std::snprintf(text, sizeof text, "error 0x%04X of the vendor's library", error);
    return std::string(text) + ": run the vendor's diagnostic tool, then open the device again";
  }
  }
}

bool switches_force_off(Code error) noexcept {
  return error != kSuccess && error != kTooMuchForce && error != kWarmMotors;
}

} // namespace

std::string Device::configure(std::span<const std::string> words) {
  if (words.size() == 1 && (words[0] == "home" || words[0] == "calibrate")) {
    calibration_requested_ = true;
    return {};
  }
  if (words.empty() || words[0] != "device")
    return "openhaptics: setting " + (words.empty() ? std::string("nothing") : words[0]) +
           ": expected device NAME, as in the vendor's set-up tool, or home";
  if (words.size() < 2)
    return "openhaptics: device: expected the name that the vendor's set-up tool shows, such as "
           "Default Device";
  std::string name = words[1]; // names have blanks; a patch gives them as several words
  for (std::size_t i = 2; i < words.size(); ++i)
    name += " " + words[i];
  const std::lock_guard lock(settings_mutex_);
  requested_name_ = name == "0" ? "" : name;
  return {};
}

std::string Device::try_names(const std::string& requested) {
  std::vector<const char*> names{"Default Device", "Default PHANToM", nullptr};
  if (!requested.empty()) // never opens another device instead
    names = {requested.c_str()};
  Code error = kSuccess;
  for (const int pause_ms : kPausesBetweenTries_ms) {
    for (int waited_ms = 0; waited_ms < pause_ms && !cancelled_; waited_ms += kPoll_ms)
      std::this_thread::sleep_for(Milliseconds(kPoll_ms));
    for (const char* name : names) {
      if (cancelled_)
        return "openhaptics: opening was cancelled: open the device again";
      static_cast<void>(library_.take_errors());
      handle_ = library_.init_device(name);
      error = library_.take_errors();
      if (handle_ != kNoDevice && is_open("openhaptics", std::to_string(handle_))) {
        handle_ = kNoDevice; // another object owns the device and keeps it open
        return "openhaptics: the device is already open in this program: close it there";
      }
      if (handle_ != kNoDevice && error == kSuccess)
        return {};
      if (handle_ != kNoDevice)
        library_.disable_device(handle_);
      handle_ = kNoDevice;
    }
    if (error == kNoLicence)
      break; // waiting does not help
  }
  std::string tried;
  for (const char* name : names)
    tried += std::string(tried.empty() ? "" : ", ") + (name ? name : "no name");
  return "openhaptics: cannot open a device of the name" +
         std::string(names.size() > 1 ? "s " : " ") + tried + ": " +
         (error == kSuccess
              ? "check its cable and power, that your account may use the port, and that "
                "the vendor's set-up tool lists the device"
              : meaning(error));
}

std::string Device::open() {
  close();
  cancelled_ = false;
  if (std::string sentence = library_.load(); !sentence.empty())
    return "openhaptics: " + sentence;
  std::string requested;
  {
    const std::lock_guard lock(settings_mutex_);
    requested = requested_name_;
  }
  if (std::string sentence = try_names(requested); !sentence.empty())
    return sentence;
  library_.make_current_device(handle_);
  const auto text = [&](Code value) {
    const char* answer = library_.get_string(value);
    return std::string(answer ? answer : "");
  };
  identity_ = {text(kVendor), text(kModelType), text(kSerialNumber)};
  open_.set("openhaptics", static_cast<int>(open_devices("openhaptics").size()), identity_,
            std::to_string(handle_));
  caps_ = device_caps(library_, identity_.model);
  library_.enable(kForceOutput);
  library_.enable(kMaxForceClamping);
  library_.enable(kForceRamping);
  if (library_.set_scheduler_rate)
    library_.set_scheduler_rate(1000);
  static_cast<void>(library_.take_errors()); // ramping and the rate are optional
  calibration_ = kCalibrationNeedsUpdate;
  needs_reset_position_ = false;
  calibrated_ticks_ = until_calibration_check_ = error_ticks_left_ = warm_ticks_left_ =
      error_free_ticks_ = 0;
  force_off_ = false;
  last_position_ = torque_n_m_ = {};
  torque_driven_ = false;
  error_ = kSuccess;
  return {};
}

void Device::close() noexcept {
  halt();
  if (handle_ != kNoDevice) {
    library_.make_current_device(handle_);
    library_.disable(kForceOutput);
    library_.disable_device(handle_);
    handle_ = kNoDevice;
  }
  open_.clear();
}

bool Device::run(void (*step)(void*), void* context) {
  if (handle_ == kNoDevice || running_)
    return false;
  step_ = step;
  context_ = context;
  stopping_ = finished_ = false;
  const std::lock_guard lock(scheduler_guard);
  scheduled_ = library_.schedule(&Device::on_tick, this, kHighestPriority);
  if (scheduler_users == 0)
    library_.start_scheduler();
  if (library_.take_errors() != kSuccess) {
    library_.unschedule(scheduled_);
    return false;
  }
  ++scheduler_users;
  running_ = true;
  return true;
}

void Device::halt() noexcept {
  if (!running_)
    return;
  stopping_ = true;
  // The scheduler's last call sends zero force. A scheduler that has died never makes that call, so
  // the wait for it is limited. The wait for a step in progress needs no limit, because a step's
  // time is bounded.
  for (int waited_ms = 0; waited_ms < 100 && !finished_; ++waited_ms)
    std::this_thread::sleep_for(Milliseconds(1));
  while (stepping_)
    std::this_thread::sleep_for(Milliseconds(1));
  const std::lock_guard lock(scheduler_guard);
  if (--scheduler_users == 0)
    library_.stop_scheduler();
  library_.unschedule(scheduled_);
  static_cast<void>(library_.take_errors());
  running_ = false;
}

unsigned int Device::on_tick(void* self) noexcept {
  Device& device = *static_cast<Device*>(self);
  device.library_.begin_frame(device.handle_);
  const bool more = device.tick();
  if (!more)
    device.send({}, {});
  device.library_.end_frame(device.handle_);
  bool warm = false;
  const Code error = device.library_.take_errors(&warm);
  device.check_error(error, warm);
  if (!more)
    device.finished_ = true;
  return more ? kCallbackContinue : kCallbackDone;
}

/// Returns false after the last step.
bool Device::tick() noexcept {
  update_calibration_status();
  stepping_ = true; // before reading stopping_: halt() accesses them in the reverse order
  const bool more = !stopping_;
  if (more)
    step_(context_);
  stepping_ = false;
  return more;
}

void Device::update_calibration_status() noexcept {
  const bool requested = calibration_requested_.exchange(false);
  if (--until_calibration_check_ > 0 && !requested)
    return;
  until_calibration_check_ = kCalibrationCheck_ticks;
  const bool was_calibrated = calibration_ == kCalibrated;
  calibration_ = library_.check_calibration();
  if (calibration_ == kCalibrationNeedsUpdate || requested) {
    update_calibration(requested);
    calibration_ = library_.check_calibration();
    if (requested && was_calibrated && calibration_ == kCalibrated) {
      calibration_ = kCalibrationNeedsUpdate; // for one tick, since the origin may have changed
      until_calibration_check_ = 1;
    }
  }
  calibration_status_ = calibration_;
}

/// Uses the best style that the device has, chosen as in the vendor's examples. Encoders are reset
/// only when the user, who holds the arm in its reset position, requests it.
void Device::update_calibration(bool requested) noexcept {
  int styles = 0;
  library_.get_integers(kCalibrationStyle, &styles);
  const auto has = [&](Code style) { return (static_cast<Code>(styles) & style) != 0; };
  needs_reset_position_ = !has(kAutomatic) && !has(kInkwell) && has(kResetEncoders);
  if (!library_.update_calibration || (needs_reset_position_ && !requested))
    return;
  for (const Code style : {kAutomatic, kInkwell, kResetEncoders})
    if (has(style))
      return library_.update_calibration(style);
}

void Device::check_error(Code error, bool warm) noexcept {
  warm_ticks_left_ = warm ? kErrorHold_ticks : std::max(warm_ticks_left_ - 1, 0);
  if (error != kSuccess) {
    error_ = error;
    error_ticks_left_ = kErrorHold_ticks;
    force_off_ = force_off_ || switches_force_off(error);
    error_free_ticks_ = 0;
  } else if (error_ticks_left_ > 0 && --error_ticks_left_ == 0 && !force_off_) {
    error_ = kSuccess;
  }
  if (force_off_ && error_free_ticks_ >= kErrorFree_ticks) {
    library_.enable(kForceOutput);
    force_off_ = false;
    error_ = kSuccess;
  }
}

bool Device::read(const haptic::Tick& /*tick*/, State& state) noexcept {
  double position_mm[3] = {}, velocity_mm_per_s[3] = {}, gimbal[3] = {};
  int buttons = 0;
  library_.get_doubles(kPosition, position_mm);
  library_.get_doubles(kVelocity, velocity_mm_per_s);
  library_.get_doubles(kGimbalAngles, gimbal);
  library_.get_integers(kButtons, &buttons);
  state.position = Vec3{position_mm[0], position_mm[1], position_mm[2]} * 1e-3;
  state.velocity = Vec3{velocity_mm_per_s[0], velocity_mm_per_s[1], velocity_mm_per_s[2]} * 1e-3;
  // For some ticks the library's velocity still contains the jump of the calibration.
  calibrated_ticks_ =
      calibration_ == kCalibrated ? std::min(calibrated_ticks_ + 1, kSettling_ticks) : 0;
  if (calibrated_ticks_ < kSettling_ticks)
    state.velocity = {};
  // The vendor counts turns to the right, down and clockwise as positive. Each is a negative turn
  // in our frame.
  state.rotation = -Vec3{gimbal[1], gimbal[0], gimbal[2]};
  state.buttons = static_cast<std::uint32_t>(buttons);
  state.flags = calibration_ == kCalibrated ? State::kHomed : 0u;
  haptic::reject_unreachable(caps_, state, last_position_);
  const Code error = error_;
  if (force_off_)
    state.flags |= State::kFault;
  if (warm_ticks_left_ > 0) // set even while a worse error is reported
    state.flags |= State::kMotorsHot;
  if (error == kTooMuchForce)
    state.flags |= State::kForceLimited;
  return error != kNoAnswer;
}

bool Device::write(const Vec3& force_n) noexcept {
  error_free_ticks_ = force_n == Vec3{} ? std::min(error_free_ticks_ + 1, kErrorFree_ticks) : 0;
  const bool allowed = calibration_ == kCalibrated && !force_off_ && is_finite(force_n);
  const Vec3 torque_n_m = std::exchange(torque_n_m_, {});
  send(allowed ? limited(force_n, caps_.peak_force_n) : Vec3{},
       allowed ? limited(torque_n_m, caps_.peak_torque_n_m) : Vec3{});
  return !force_off_ || force_n == Vec3{};
}

void Device::set_wrist(const haptic::WristCommand& command) noexcept {
  if (caps_.peak_torque_n_m <= 0)
    return;
  torque_n_m_ = command.torque_n_m;
  torque_driven_ = true;
}

void Device::send(const Vec3& force_n, const Vec3& torque_n_m) noexcept {
  const double force[3] = {force_n.x, force_n.y, force_n.z};
  library_.set_doubles(kForce, force);
  if (!torque_driven_)
    return;
  const double torque[3] = {1e3 * torque_n_m.x, 1e3 * torque_n_m.y, 1e3 * torque_n_m.z};
  library_.set_doubles(kTorque, torque);
}

std::string Device::trouble() const {
  if (const Code error = error_; error != kSuccess)
    return "openhaptics: " + meaning(error);
  if (running_ && calibration_status_ == kCalibrationNeedsHand)
    return "openhaptics: the device is not calibrated: put the stylus into the inkwell, or the arm "
           "into its rest, until the light stops blinking";
  if (running_ && calibration_status_ != kCalibrated && needs_reset_position_)
    return "openhaptics: the device is not calibrated: hold the arm in its reset position and send "
           "home";
  if (running_ && calibration_status_ != kCalibrated)
    return "openhaptics: the device is calibrating itself: wait, and do not hold it";
  return {};
}

} // namespace tactus::devices::openhaptics
