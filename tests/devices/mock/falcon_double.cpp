#include "tests/devices/mock/falcon_double.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace tactus::mock {
namespace {

constexpr int kGreetingDivisor = 0x4138, kBootDivisor = 0x15, kRunDivisor = 0x2;
constexpr double kFrame_s = 1e-3;

} // namespace

int FalconDouble::control(std::span<const std::uint8_t, 8> setup, std::span<std::uint8_t>) {
  const std::scoped_lock lock(mutex_);
  const int request = setup[1], value = setup[2] | setup[3] << 8;
  if ((setup[0] & 0x60) != 0x40)
    return setup[0] & 0x80 ? -EPIPE : 0;
  switch (request) {
  case 0:
    if (value != 2) // 0: both, 1: what is on its way to the host
      to_host_.clear();
    return 0;
  case 1:
    if (value & 0x100) {
      const bool ready = (value & 1) != 0;
      if (ready && !terminal_ready_) // the edge restarts the boot loader
        greeted_ = acknowledged_ = false, restarted_ = Clock::now();
      terminal_ready_ = ready;
    }
    return 0;
  case 3:
    divisor_ = value;
    filled_ = 0;
    if (divisor_ == kRunDivisor && acknowledged_ && firmware_bytes_ > 0) {
      loaded_ = true;
      acknowledged_ = false;
    }
    return 0;
  case 9:
    latency_ms_ = value;
    return 0;
  default:
    return 0;
  }
}

int FalconDouble::out(std::uint8_t, std::span<const std::uint8_t> payload) {
  const std::scoped_lock lock(mutex_);
  if (divisor_ == kRunDivisor)
    for (const std::uint8_t byte : payload)
      run(byte);
  else
    boot(payload);
  return static_cast<int>(payload.size());
}

void FalconDouble::boot(std::span<const std::uint8_t> payload) {
  if (divisor_ == kGreetingDivisor) {
    for (const std::uint8_t byte : payload) {
      greeting_.push_back(byte);
      if (greeting_.size() > 3)
        greeting_.pop_front();
      if (!terminal_ready_ || greeting_ != std::deque<std::uint8_t>{0x0a, 0x43, 0x0d})
        continue;
      if (Clock::now() - restarted_ < std::chrono::milliseconds(boot_ms_))
        continue;
      if (deaf_ > 0 || confused_) {
        deaf_ -= deaf_ > 0;
        continue;
      }
      loaded_ = false;
      greeted_ = true;
      unhome();
      for (const int reply : {0x0a, 0x44, 0x2c, 0x0d})
        to_host_.push_back(static_cast<std::uint8_t>(reply));
    }
    return;
  }
  if (divisor_ != kBootDivisor || !greeted_)
    return;
  for (const std::uint8_t byte : payload) {
    std::uint8_t echo = byte;
    if (!acknowledged_) {
      if (byte != 0x41)
        continue;
      acknowledged_ = true;
      firmware_bytes_ = 0;
      ++uploads_;
    } else if (++firmware_bytes_ == 100 && wrong_echoes_ > 0) {
      --wrong_echoes_;
      echo ^= 0x20;
    }
    to_host_.push_back(echo);
  }
}

void FalconDouble::run(std::uint8_t byte) {
  if (!loaded_) {
    confused_ = shy_;
    return;
  }
  if (filled_ == 0 && byte != '<') {
    ++broken_;
    return;
  }
  packet_[filled_++] = byte;
  if (filled_ < packet_.size())
    return;
  filled_ = 0;
  if (byte != '>') {
    ++broken_;
    return;
  }
  for (std::size_t motor = 0; motor < 3; ++motor) {
    int value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value += (packet_[1 + 4 * motor + i] - 'A') << 4 * i;
    motors_[motor] = value >= 32768 ? value - 65536 : value;
  }
  flags_ = packet_[13] - 'A';
  frame();
}

// Arms of 3.6e-4 kg m^2 in a hand of 0.72 N m/rad and 0.0072 N m s/rad: 0.1 kg, 200 N/m and 2 N s/m
// at the end of 60 mm. A motor count is 0.1 mN m and turns the arm against the encoder.
void FalconDouble::move() {
  constexpr double kInertia = 3.6e-4, kSpring = 0.72, kDamper = 0.0072, kTorque = 1e-4;
  constexpr double kRadians = 0.0364347 * 3.14159265358979324 / 180;
  const double time_s = static_cast<double>(frames_) * kFrame_s;
  for (std::size_t arm = 0; arm < 3; ++arm) {
    const double phase = 2 * 3.14159265358979324 * 0.5 * time_s + 2.1 * static_cast<double>(arm);
    const double hand = still_ ? -500 : -500 + 150 * std::sin(phase);
    const double torque =
        -kTorque * motors_[arm] / kRadians + kSpring * (hand - angle_[arm]) - kDamper * speed_[arm];
    speed_[arm] += kFrame_s * torque / kInertia;
    angle_[arm] = std::clamp(angle_[arm] + kFrame_s * speed_[arm], -1500.0, 1500.0);
    if (!frozen_)
      sent_[arm] = static_cast<int>(std::lround(angle_[arm]));
  }
}

void FalconDouble::frame() {
  ++frames_;
  if (flags_ & 1) { // homing: each arm passes its mark in turn
    ++homing_frames_;
    homed_ = homing_frames_ > 60 ? 7 : homing_frames_ > 40 ? 3 : homing_frames_ > 20 ? 1 : homed_;
  } else {
    unhome();
  }
  move();
  std::array<std::uint8_t, 16> answer{};
  answer[0] = bad_ > 0 ? '!' : '<';
  for (std::size_t arm = 0; arm < 3; ++arm) {
    int counts = homed_ & 1 << arm ? sent_[arm] : sent_[arm] + 700; // no mark passed yet
    counts = posed_ ? pose_[arm] : counts + (wild_ > 0 && arm == 0 ? 1000 : 0);
    for (std::size_t i = 0; i < 4; ++i)
      answer[1 + 4 * arm + i] = static_cast<std::uint8_t>('A' + (counts >> 4 * i & 15));
  }
  answer[13] = static_cast<std::uint8_t>('A' + (buttons_ & 15) + 16 * homed_);
  answer[14] = 'A';
  answer[15] = '>';
  for (; garbage_ > 0; --garbage_) {
    noise_ = noise_ * 1664525 + 1013904223;
    to_host_.push_back(static_cast<std::uint8_t>(noise_ >> 24));
  }
  for (std::size_t i = 0; i < answer.size(); ++i)
    if (lose_ == 0 || i != 4)
      to_host_.push_back(answer[i]);
  bad_ = std::max(bad_ - 1, 0L);
  lose_ = std::max(lose_ - 1, 0L);
  wild_ = std::max(wild_ - 1, 0L);
}

int FalconDouble::in(std::uint8_t, std::span<std::uint8_t> payload) {
  const std::scoped_lock lock(mutex_);
  const auto now = Clock::now();
  if (payload.size() < 2)
    return -EOVERFLOW;
  if (now < stalled_until_)
    return -EAGAIN;
  if (static_cast<int>(to_host_.size()) < split_ &&
      now - last_in_ < std::chrono::milliseconds(latency_ms_))
    return -EAGAIN;
  last_in_ = now;
  payload[0] = static_cast<std::uint8_t>(0x01 | (divisor_ == kBootDivisor ? 0x10 : 0));
  payload[1] = 0x60;
  std::size_t length = 2;
  const std::size_t most =
      std::min<std::size_t>(payload.size(), static_cast<std::size_t>(2 + split_));
  for (; length < most && !to_host_.empty(); ++length) {
    payload[length] = to_host_.front();
    to_host_.pop_front();
  }
  return static_cast<int>(length);
}

std::string FalconDouble::command(const std::string& line) {
  const std::scoped_lock lock(mutex_);
  std::istringstream words(line);
  std::string name;
  int value = 0;
  words >> name >> value;
  if (name == "state")
    return state();
  if (name == "stall")
    stalled_until_ = Clock::now() + std::chrono::milliseconds(value);
  else if (name == "split")
    split_ = std::clamp(value, 1, 62);
  else if (name == "garbage")
    garbage_ = value;
  else if (name == "bad")
    bad_ = value;
  else if (name == "lose")
    lose_ = value;
  else if (name == "freeze")
    frozen_ = value != 0;
  else if (name == "wild")
    wild_ = value;
  else if (name == "pose") {
    posed_ = !words.fail();
    pose_[0] = value;
    words >> pose_[1] >> pose_[2];
  } else if (name == "unhome")
    unhome();
  else if (name == "shy")
    shy_ = value != 0;
  else if (name == "echo")
    wrong_echoes_ = value;
  else if (name == "boot")
    boot_ms_ = value;
  else if (name == "deaf")
    deaf_ = value;
  else if (name == "still")
    still_ = true;
  else if (name == "buttons")
    buttons_ = value;
  else if (name == "forget")
    loaded_ = greeted_ = acknowledged_ = confused_ = false, firmware_bytes_ = 0, unhome();
  else
    return "?";
  return "ok";
}

std::string FalconDouble::state() const {
  std::ostringstream text;
  text << "frames=" << frames_ << " broken=" << broken_ << " loaded=" << loaded_
       << " uploads=" << uploads_ << " firmware=" << firmware_bytes_ << " homed=" << homed_
       << " flags=" << flags_;
  for (std::size_t motor = 0; motor < 3; ++motor)
    text << " motor" << motor << "=" << motors_[motor] << " count" << motor << "=" << sent_[motor];
  text << " latency=" << latency_ms_ << " divisor=" << divisor_;
  return text.str();
}

UsbDescription falcon_description() {
  UsbDescription d;
  d.name = "1-1";
  d.vendor = 0x0403;
  d.product = 0xcb48;
  d.release = 0x0600;
  d.manufacturer = "FTDI";
  d.model = "FALCON HAPTIC";
  d.serial = "DOUBLE01";
  d.configuration = {9,    2, 32, 0, 1,    1, 0,  0x80, 45, 9, 4, 0,    0, 2,  0xff, 0xff,
                     0xff, 2, 7,  5, 0x81, 2, 64, 0,    0,  7, 5, 0x02, 2, 64, 0,    0};
  return d;
}

void FalconDouble::report(const std::string& file) {
  if (file.empty())
    return;
  std::string state = command("state");
  std::replace(state.begin(), state.end(), ' ', '\n');
  const std::string fresh = file + ".new";
  {
    std::ofstream stream(fresh);
    stream << state << "\n";
  }
  static_cast<void>(std::rename(fresh.c_str(), file.c_str())); // readers never see half a report
}

} // namespace tactus::mock
