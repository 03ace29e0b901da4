#include "devices/haply/connection.hpp"

#include "core/text.hpp"
#include "devices/haply/socket.hpp"
#include "devices/real_time.hpp"
#include "devices/servo_thread.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <limits>
#include <system_error>

namespace tactus::devices::haply {
namespace {

using haptic::State;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double kConnect_s = 2, kAnswer_s = 0.5, kSetUp_s = 0.5;
constexpr double kFirstPause_s = 0.05, kMaxPause_s = 2;
constexpr double kTimeout_s = 4, kPoll_s = 0.02; // for open()
constexpr int kTriesBeforeRefusal = 4;
constexpr int kMaxBadMessages = 50;

} // namespace

Address default_address() {
  const char* text = std::getenv("TACTUS_HAPLY");
  const std::string wanted = text ? text : "";
  const auto colon = wanted.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == wanted.size())
    return {};
  return {wanted.substr(0, colon), wanted.substr(colon + 1)};
}

std::string Connection::open(const Settings& settings) {
  close();
  settings_ = settings;
  sample_ = {};
  samples_.write({});
  forces_.reset();
  phase_ = Phase::kSearching;
  trouble_.clear();
  stop_ = leaving_ = cancelled_ = false;
  try {
    thread_ = std::thread([this] { serve(); });
  } catch (const std::system_error&) {
    return "cannot start a thread for the connection: close other programs";
  }
  std::string sentence;
  {
    std::unique_lock lock(mutex_);
    const auto until =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(kTimeout_s));
    while (phase_ == Phase::kSearching && !cancelled_ && Clock::now() < until)
      changed_.wait_for(lock, Seconds(kPoll_s));
    if (phase_ == Phase::kRunning)
      return {};
    sentence = cancelled_         ? "opening was cancelled: open the device again"
               : trouble_.empty() ? "Haply's service on " + settings_.address.host + ":" +
                                        settings_.address.port + " does not answer"
                                  : trouble_;
  }
  close();
  return sentence;
}

void Connection::close() noexcept {
  if (!thread_.joinable())
    return;
  leaving_ = true;
  // Waits until zero force is sent and answered; if the service hangs, the wait ends after 100 ms.
  for (int waited_ms = 0; waited_ms < 100 && leaving_; ++waited_ms)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stop_ = true;
  thread_.join();
}

std::string Connection::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

DeviceState Connection::device_state() const {
  const std::lock_guard lock(mutex_);
  return device_state_;
}

void Connection::set_trouble(Phase phase, const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  phase_ = phase;
  trouble_ = trouble;
  changed_.notify_all();
}

void Connection::serve() noexcept {
  raise_thread_priority(kDeviceThreadPriority); // every delay of this thread delays the force
  try {
    run_connection();
  } catch (const std::exception& error) {
    set_trouble(Phase::kRefused, std::string("the connection to Haply's service ended: ") +
                                     error.what() + "; open the device again");
  }
  leaving_ = false;
}

void Connection::run_connection() {
  const std::string endpoint = settings_.address.host + ":" + settings_.address.port;
  double pause_s = kFirstPause_s;
  for (int failures = 0; !stop_ && !leaving_;) {
    Socket socket(stop_);
    std::string failure =
        socket.connect(settings_.address.host, settings_.address.port, kConnect_s);
    if (failure.empty()) {
      const double began_s = ServoThread::now_s();
      failure = run_session(socket);
      socket.close();
      if (ServoThread::now_s() - began_s > 1) { // the session worked: reconnect soon
        failures = 0;
        pause_s = kFirstPause_s;
      }
    } else {
      failure = "Haply's service does not answer on " + endpoint + " (" + failure +
                "): start Haply Hub, or run systemctl start haply-inverse-service";
    }
    if (stop_ || leaving_)
      break;
    ++failures;
    set_trouble(failures >= kTriesBeforeRefusal ? Phase::kRefused : Phase::kSearching, failure);
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(pause_s));
    while (!stop_ && !leaving_ && Clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    pause_s = std::min(2 * pause_s, kMaxPause_s);
  }
}

/// Selects the requested device. Returns an empty text, or what to do.
std::string Connection::choose(const Message& inventory) {
  const auto& devices = inventory.devices;
  if (devices.empty())
    return "Haply's service runs but finds no Inverse3: check the device's cable and power";
  std::size_t index = 0;
  if (!settings_.device.empty()) {
    const auto by_id = std::find_if(devices.begin(), devices.end(), [this](const DeviceState& one) {
      return one.id == settings_.device;
    });
    index = by_id != devices.end()
                ? static_cast<std::size_t>(by_id - devices.begin())
                : to_number<std::size_t>(settings_.device).value_or(devices.size());
    if (index >= devices.size())
      return "device " + settings_.device + ": not found by Haply's service; its first device is " +
             devices.front().id + ": send device 0, or its device_id";
  }
  device_id_ = devices[index].id;
  const std::lock_guard lock(mutex_);
  device_state_ = devices[index];
  return {};
}

/// Stores the device's state from the message; false if the message does not contain the device.
bool Connection::take(const Message& message) {
  const auto found = std::find_if(message.devices.begin(), message.devices.end(),
                                  [this](const DeviceState& one) { return one.id == device_id_; });
  if (found == message.devices.end())
    return false;
  if (found->workspace)
    workspace_ = *found->workspace;
  if (found->mount)
    mount_ = *found->mount;
  // Undoes the workspace transform and the mount's scale, but keeps the mount's rotation and
  // origin.
  Transform mount_scale;
  mount_scale.scale = mount_.scale;
  const bool valid = workspace_.valid() && mount_.valid();
  const Vec3 nowhere = Vec3{1, 1, 1} * std::numeric_limits<double>::quiet_NaN();
  if (found->position)
    sample_.state.position =
        valid ? mount_scale.point(workspace_.point(*found->position)) : nowhere;
  if (found->velocity)
    sample_.state.velocity =
        valid ? mount_scale.motion(workspace_.motion(*found->velocity)) : Vec3{};
  if (found->calibrated)
    sample_.calibrated = *found->calibrated;
  if (message.buttons)
    sample_.state.buttons = *message.buttons;
  if (message.rotation)
    sample_.state.rotation = *message.rotation;
  sample_.state.flags = sample_.calibrated ? State::kHomed : 0u;
  return true;
}

Vec3 Connection::next_force() noexcept {
  const Vec3 force_n = forces_.read();
  if (!sample_.calibrated || leaving_ || !is_finite(force_n) || !workspace_.valid())
    return {};
  return workspace_.rotated(force_n * forces_.gain());
}

/// Requests the preset and the axes and waits until the service's configuration shows both. A
/// service without presets leaves the origin in the device's base. Such a service is an older
/// version, which expects the force under another key.
std::string Connection::set_up(Socket& socket) {
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(kSetUp_s));
  is_centred_ = false;
  std::string text;
  for (int round = 0; !stop_ && !leaving_ && Clock::now() < until; ++round) {
    const std::string message =
        round == 0 ? first_message(device_id_) : status_request(device_id_, round == 1);
    std::string failure = socket.send(message, kAnswer_s);
    if (failure.empty())
      failure = socket.receive(text, kAnswer_s);
    if (!failure.empty())
      return failure;
    const auto answer = parse(text);
    if (!answer || !take(*answer))
      continue;
    const auto found =
        std::find_if(answer->devices.begin(), answer->devices.end(),
                     [this](const DeviceState& one) { return one.id == device_id_; });
    is_centred_ = found->preset == kPreset;
    if (round > 1 && is_centred_ && (found->basis.empty() || found->basis == kBasis))
      return {};
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return {};
}

std::string Connection::run_session(Socket& socket) {
  std::string text;
  if (std::string failure = socket.receive(text, kConnect_s); !failure.empty())
    return "Haply's service sent no list of devices (" + failure + "): restart it";
  const auto inventory = parse(text);
  if (!inventory)
    return "the program on port " + settings_.address.port +
           " is not Haply's service: it does not send JSON; send service HOST PORT";
  if (std::string sentence = choose(*inventory); !sentence.empty())
    return sentence;
  workspace_ = mount_ = {};
  static_cast<void>(take(*inventory)); // later states omit unchanged fields
  if (std::string failure = set_up(socket); !failure.empty())
    return "lost Haply's service (" + failure + "): trying to reconnect";
  const ForceKey key = is_centred_ ? ForceKey::kVector : ForceKey::kBoth;
  const auto period = std::chrono::duration_cast<Clock::duration>(Seconds(1 / settings_.rate_hz));
  auto next = Clock::now();
  bool reported = false;
  for (int garbage = 0; !stop_;) {
    const bool last = leaving_;
    std::string failure = socket.send(force_message(device_id_, next_force(), key), kAnswer_s);
    if (failure.empty())
      failure = socket.receive(text, kAnswer_s);
    if (last)
      return {};
    if (!failure.empty())
      return "lost Haply's service (" + failure + "): trying to reconnect";
    const auto message = parse(text);
    garbage = message ? 0 : garbage + 1;
    if (garbage >= kMaxBadMessages)
      return "Haply's service has stopped sending JSON: restart it";
    if (message && take(*message)) { // without one, the servo reports that the sample is too old
      if (!reported)
        set_trouble(Phase::kRunning, "");
      reported = true;
      sample_.time_s = ServoThread::now_s();
      samples_.write(sample_);
    }
    next = std::max(next + period, Clock::now() - period);
    std::this_thread::sleep_until(next);
  }
  return {};
}

} // namespace tactus::devices::haply
