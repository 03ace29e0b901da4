#include "externals/phantom/device/driver_calls.hpp"

#include "devices/scoped_signal_mask.hpp"
#include "devices/servo_thread.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace tactus::phantom {
namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(5);

/// The DriverCalls that have a thread. Never destroyed, since threads that hang in a driver may
/// still use this table.
struct Table {
  std::mutex mutex;
  std::vector<std::shared_ptr<DriverCalls>> running;
};
Table& table() {
  static auto* const made = new Table;
  return *made;
}

} // namespace

DriverCalls::Call::Call(DriverCalls& calls, std::string what, Device opened, std::uint64_t ticket)
    : calls_(calls) {
  const std::scoped_lock lock(calls_.mutex_);
  calls_.since_s_ = opened && ticket == calls_.wanted_ ? 0 : devices::ServoThread::now_s();
  calls_.call_ = std::move(what);
  calls_.called_ = std::move(opened);
  calls_.call_ticket_ = ticket;
}

DriverCalls::Call::~Call() {
  const std::scoped_lock lock(calls_.mutex_);
  calls_.call_.clear();
  calls_.called_.reset();
  calls_.since_s_ = 0;
}

void DriverCalls::set_use(std::unique_ptr<DriverUse> use) {
  const std::scoped_lock lock(mutex_);
  use_ = std::move(use);
}

void DriverCalls::opened(haptic::Identity identity) {
  const std::scoped_lock lock(mutex_);
  use_->opened(std::move(identity));
}

void DriverCalls::leave() {
  const std::scoped_lock lock(mutex_);
  if (use_)
    use_->leave();
}

void DriverCalls::want(std::uint64_t ticket) { abandon(ticket, false); }
void DriverCalls::want_none() { abandon(~std::uint64_t{0}, true); }

void DriverCalls::abandon(std::uint64_t wanted, bool for_good) {
  const std::scoped_lock lock(mutex_);
  wanted_ = wanted;
  const bool abandoned = called_ && call_ticket_ != wanted;
  if (abandoned && since_s_ == 0)
    since_s_ = devices::ServoThread::now_s();
  if (use_ && (abandoned || for_good))
    use_->leave();
}

void DriverCalls::cancel_unwanted() {
  Device opened;
  {
    const std::scoped_lock lock(mutex_);
    if (since_s_ > 0)
      opened = called_;
  }
  if (opened)
    opened->cancel();
}

std::string DriverCalls::overdue(double limit_s) const {
  const std::scoped_lock lock(mutex_);
  const bool late = since_s_ > 0 && devices::ServoThread::now_s() - since_s_ > limit_s;
  return late ? call_ : std::string();
}

void DriverCalls::set_running(const std::shared_ptr<DriverCalls>& calls, bool running) {
  const std::scoped_lock lock(table().mutex);
  std::erase(table().running, calls);
  if (running)
    table().running.push_back(calls);
}

bool DriverCalls::join_all(double seconds) noexcept {
  const double end_s = devices::ServoThread::now_s() + seconds;
  for (;;) {
    std::vector<std::shared_ptr<DriverCalls>> running;
    {
      const std::scoped_lock lock(table().mutex);
      running = table().running;
    }
    if (running.empty())
      return true;
    const bool late = devices::ServoThread::now_s() > end_s;
    for (const auto& calls : running) {
      if (!late) {
        calls->cancel_unwanted();
        continue;
      }
      const std::scoped_lock lock(calls->mutex_);
      std::fprintf(stderr, "phantom: %s has not returned; the program ends without it\n",
                   calls->call_.empty() ? "a device's driver" : calls->call_.c_str());
    }
    if (late)
      return false;
    std::this_thread::sleep_for(kPollInterval);
  }
}

DriverThread::~DriverThread() {
  if (state_)
    state_->end();
}

std::string DriverThread::start(std::shared_ptr<BackgroundState> state) {
  const devices::ScopedSignalMask mask; // the drivers' threads, which this thread starts, inherit
                                        // the mask
  try {
    std::thread([state] { state->work(); }).detach();
  } catch (const std::system_error& error) {
    return std::string("cannot start the thread for devices (") + error.what() +
           "): close other programs or raise the limit on threads";
  }
  state_ = std::move(state);
  return {};
}

} // namespace tactus::phantom
