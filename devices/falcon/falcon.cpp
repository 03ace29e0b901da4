#include "devices/falcon/falcon.hpp"

#include "devices/falcon/boot.hpp"
#include "files/file_bytes.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <thread>

namespace tactus::devices::falcon {
namespace {

// The radius is half of the range that CHAI3D states for this device. The limits of force,
// stiffness and damping are CHAI3D's too.
constexpr double kRadius_m = 0.040, kPeak_n = 8, kStiffness = 3000, kDamping = 20;

constexpr std::size_t kMaxFirmware = 1 << 16; // files of 7914 and 8492 bytes are known
const char* const kCancelled = "opening the Falcon was cancelled: open it again";
constexpr double kFirstAnswer_s = 1.0;
constexpr double kSilent_s = 0.005;    // longest time without an answer, or three ticks if longer
constexpr double kForceReturn_s = 0.5; // time from zero to full force after homing
constexpr double kMinHoming_s = 0.1;   // minimum time without the homing bit after "home"
constexpr double kStuck_s = 5.0;       // maximum time without a change of a count since the opening
constexpr int kMaxCountStep = 400;     // counts between two answers, about 15 m/s

// Within this distance of the centre no arm can lean against a stop. At a stop the counts do not
// change, whatever the force.
constexpr double kStops_m = 0.025;

std::shared_ptr<UsbLibrary> library(std::string& problem) {
  auto usb = std::make_shared<UsbLibrary>();
  problem = usb->load();
  return usb;
}

// Rejects solutions of the closure equations that the arms cannot reach: far outside, or with an
// arm folded the other way.
bool reachable(const Vec3& position, const Angles& angles) noexcept {
  constexpr double kReach_m = 0.1; // from the centre: a corner of +-2 inches is at 88 mm
  constexpr double kSame_rad = 1e-6;
  if (!(norm(position - kCentre) <= kReach_m))
    return false;
  const std::optional<Angles> back = inverse(position);
  return back && std::equal(angles.begin(), angles.end(), back->begin(),
                            [](double a, double b) { return std::abs(a - b) < kSame_rad; });
}

bool is_open(const std::string& path) { return devices::is_open("falcon", path); }

bool exceeds_max_step(const Counts& from, const Counts& to) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(to[i] - from[i]) > kMaxCountStep)
      return true;
  return false;
}

std::string read_firmware(const std::string& file, std::vector<std::uint8_t>& bytes) {
  std::ifstream in = files::open_file(file);
  if (!in)
    return "the firmware file " + file + " cannot be read: check its path";
  bytes.assign(std::istreambuf_iterator<char>(in), {});
  if (bytes.empty() || bytes.size() > kMaxFirmware)
    return "the firmware file " + file + " has " + std::to_string(bytes.size()) +
           " bytes: expected 1.." + std::to_string(kMaxFirmware);
  return {};
}

} // namespace

std::string Falcon::open() {
  close();
  cancelled_ = false;
  Settings settings;
  {
    const std::scoped_lock lock(mutex_);
    settings = settings_;
  }
  std::string problem;
  auto usb = library(problem);
  if (!problem.empty())
    return problem;
  link_ = std::make_unique<Link>(std::move(usb), &cancelled_);
  problem = link_->open(settings.device, is_open);
  if (problem.empty())
    problem = boot(settings);
  if (problem.empty())
    problem = start_stream();
  if (!problem.empty()) {
    stream_.reset();
    link_.reset();
    return problem;
  }
  {
    const std::scoped_lock lock(mutex_);
    port_ = link_->port();
    settings_.reload = false;
  }
  open_.set("falcon", 0, identity(), port_.path);
  condition_ = Condition::kHoming;
  return {};
}

std::string Falcon::boot(const Settings& settings) {
  // A boot loader receives a request at 1.5 Mbaud as noise. So ask only if firmware is known to run
  // or nothing else can be done.
  const bool ask =
      settings.probe || settings.firmware.empty() || loaded_path_ == link_->port().path;
  if (!settings.reload && ask && firmware_runs(*link_))
    return {};
  loaded_path_.clear();
  if (cancelled_)
    return kCancelled;
  if (settings.firmware.empty())
    return "the Falcon has no firmware: send firmware FILE with the file from the manufacturer's "
           "software (tactus may not include it; docs/devices/falcon.md)";
  std::vector<std::uint8_t> firmware;
  std::string problem = read_firmware(settings.firmware, firmware);
  if (problem.empty())
    problem = upload(*link_, firmware);
  if (problem.empty())
    loaded_path_ = link_->port().path;
  return problem;
}

std::string Falcon::start_stream() {
  estimator_.reset();
  estimator_.set_bound(position_error_m());
  frame_ = {};
  flags_ = 0;
  encoders_ = {};
  answered_ = false;
  rejected_.reset();
  position_ = kCentre;
  velocity_ = {};
  frozen_detector_.reset();
  commanded_n_ = {};
  homed_ = homing_ = unreachable_ = changed_ = false;
  stuck_ = home_requested_ = moved_ = false;
  time_s_ = last_frame_s_ = open_s_ = homed_s_ = homing_s_ = 0;

  stream_ = std::make_unique<Stream>(*link_);
  if (std::string problem = stream_->start(); !problem.empty())
    return problem;
  bool answers = !stream_->lost();
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kFirstAnswer_s);
  while (answers && !stream_->receive()) {
    if (cancelled_)
      return kCancelled;
    answers = !stream_->lost() && std::chrono::steady_clock::now() < end;
    stream_->send(kNoForce);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (!answers)
    return "the Falcon stopped answering: plug it in again and open it again";
  frame_ = stream_->latest();
  flags_ = frame_.response.flags;
  return {};
}

void Falcon::close() noexcept {
  const Condition last = condition_.exchange(Condition::kClosed);
  if (last == Condition::kLost || last == Condition::kSilent)
    loaded_path_.clear(); // the device may have lost its power
  // The encoders do not change: start with the boot loader at the next opening.
  if (last == Condition::kFrozen || last == Condition::kAtStop || last == Condition::kUnreachable ||
      (last == Condition::kHoming && stuck_)) {
    const std::scoped_lock lock(mutex_);
    settings_.reload = !settings_.firmware.empty();
  }
  stream_.reset(); // first sends a command without force
  link_.reset();
  open_.clear();
}

haptic::Caps Falcon::caps() const noexcept {
  haptic::Caps caps;
  caps.peak_force_n = kPeak_n;
  caps.stiffness_limit_n_per_m = kStiffness;
  caps.damping_limit_n_s_per_m = kDamping;
  caps.workspace_min = {-kRadius_m, -kRadius_m, -kRadius_m};
  caps.workspace_max = {kRadius_m, kRadius_m, kRadius_m};
  caps.position_noise_m = position_error_m();
  // The device answers a command with its current position. Command and answer each wait for a USB
  // frame of 1 ms, and an answer of less than 62 bytes also for the serial chip's latency timer, at
  // least 1 ms (FTDI, AN232B-04). So a tick reads the answer to the command of two ticks before.
  caps.latency_ticks = 2;
  caps.has_velocity = true; // estimated here, because this code has the times of the answers
  caps.has_buttons = true;
  caps.needs_home = true;
  return caps;
}

// Returns false if the answer is implausible.
bool Falcon::process(const Frame& frame) noexcept {
  const Counts& counts = frame.response.encoders;
  flags_ = frame.response.flags; // the flags are valid even if the angles are not
  if (answered_ && encoders_ != counts)
    changed_ = moved_ = true;
  answered_ = true;
  encoders_ = counts;
  const bool jumped = frame_.number > 0 && exceeds_max_step(frame_.response.encoders, counts);
  const Forward found = forward(motor_angles(counts), jumped ? kCentre : position_);
  unreachable_ = !found.found || !reachable(found.position, motor_angles(counts));
  if (unreachable_)
    return false;
  // An arm that passes its mark restarts its count, in the same answer that sets its flag.
  const bool marked = ((flags_ ^ frame_.response.flags) & Response::kHomed) != 0;
  if (jumped && !marked && (!rejected_ || exceeds_max_step(*rejected_, counts))) {
    rejected_ = counts; // accepted if the next answer is close to it
    return false;
  }
  rejected_.reset();
  if (jumped)
    estimator_.reset(); // the jump was not a motion
  position_ = found.position;
  velocity_ = estimator_.update(position_, frame.time_s);
  frame_ = frame;
  return true;
}

bool Falcon::read(const haptic::Tick& tick, haptic::State& state) noexcept {
  if (!stream_)
    return false;
  period_s_ = std::clamp(tick.time_s - time_s_, 0.0, 0.1);
  time_s_ = tick.time_s;
  changed_ = false;
  const bool answered = stream_->receive();
  const bool sensible = answered && process(stream_->latest());
  home();
  update_condition(tick, sensible || (answered && unreachable_));
  state.position = position_ - kCentre;
  state.velocity = velocity_;
  state.buttons = flags_ & Response::kButtons;
  state.flags = homed_ ? haptic::State::kHomed : 0u;
  if (unreachable_)
    state.flags |= haptic::State::kUnreachable;
  const Condition condition = condition_.load(std::memory_order_relaxed);
  if (condition == Condition::kFrozen)
    state.flags |= haptic::State::kFault;
  return condition != Condition::kLost && condition != Condition::kSilent;
}

// The device reports a flag for each arm that has passed its mark.
void Falcon::home() noexcept {
  open_s_ += period_s_;
  stuck_.store(!moved_ && open_s_ > kStuck_s, std::memory_order_relaxed);
  if (home_requested_.exchange(false)) {
    homing_ = true;
    homing_s_ = 0;
  }
  const bool marked = (flags_ & Response::kHomed) == Response::kHomed;
  homing_s_ += homing_ ? period_s_ : 0;
  if (homing_ && homing_s_ > kMinHoming_s && marked)
    homing_ = false;
  const bool homed = marked && !homing_;
  homed_s_ = homed && homed_ ? homed_s_ + period_s_ : 0;
  homed_ = homed;
}

void Falcon::update_condition(const haptic::Tick& tick, bool new_frame) noexcept {
  if (new_frame || last_frame_s_ == 0)
    last_frame_s_ = tick.time_s;
  const bool silent = tick.time_s - last_frame_s_ > std::max(kSilent_s, 3 * tick.period_s);
  frozen_detector_.update(changed_, commanded_n_, period_s_, homed_ && !silent && !unreachable_);
  Condition condition = Condition::kOk;
  if (stream_->lost())
    condition = Condition::kLost;
  else if (silent)
    condition = Condition::kSilent;
  else if (!homed_) // the angles are undefined before homing
    condition = Condition::kHoming;
  else if (unreachable_)
    condition = Condition::kUnreachable;
  else if (frozen_detector_.frozen())
    condition = norm(position_ - kCentre) < kStops_m ? Condition::kFrozen : Condition::kAtStop;
  condition_.store(condition, std::memory_order_relaxed);
}

bool Falcon::write(const Vec3& force_n) noexcept {
  if (!stream_ || stream_->lost())
    return false;
  commanded_n_ = {};
  Command command;
  // Each packet must keep the homing bit set; "home" drops it first, so that the device clears its
  // marks.
  command.flags = lights(homed_);
  if (!homing_ || homing_s_ >= kMinHoming_s)
    command.flags |= Command::kHoming;
  if (homed_ && !unreachable_) {
    commanded_n_ = force_n * std::min(homed_s_ / kForceReturn_s, 1.0);
    command.motors = motor_counts(torques(position_, commanded_n_ * frozen_detector_.gain()),
                                  counts_per_n_m_.load(std::memory_order_relaxed));
  }
  stream_->send(command);
  return true;
}

std::uint8_t Falcon::lights(bool homed) const noexcept {
  const int asked = lights_.load(std::memory_order_relaxed);
  if (!homed)
    return Command::kRed;
  return asked < 0 ? std::uint8_t{Command::kGreen} : static_cast<std::uint8_t>(asked);
}

haptic::Identity Falcon::identity() const {
  const std::scoped_lock lock(mutex_);
  return {"Novint", "Falcon", port_.serial.empty() ? port_.path : port_.serial};
}

std::string Falcon::trouble() const {
  switch (condition_.load(std::memory_order_relaxed)) {
  case Condition::kLost:
    return "the Falcon was unplugged: plug it in and open it again";
  case Condition::kSilent:
    return "the Falcon does not answer: check its power, then close and open it";
  case Condition::kUnreachable:
    return "the Falcon reports impossible arm angles: home it; if that does not help, close and "
           "open it, which loads the firmware again";
  case Condition::kAtStop:
    return "the Falcon's force is off: its encoders do not change near a stop; pull the grip to "
           "the centre; if that does not help, close and open it, which loads the firmware again";
  case Condition::kFrozen:
    return "the Falcon's encoders do not change under force: close and open it, which loads the "
           "firmware again";
  case Condition::kHoming:
    return moved_
               ? "the Falcon is not homed: pull the grip out as far as it goes, then push it in"
               : "the Falcon is not homed: pull the grip out as far as it goes, then push it in; "
                 "if that does not help, close and open it, which loads the firmware again";
  case Condition::kClosed:
  case Condition::kOk:
    break;
  }
  return {};
}

} // namespace tactus::devices::falcon
