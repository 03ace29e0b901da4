#pragma once

#include "devices/force_dimension/dhd_library.hpp"
#include "files/background_thread.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace tactus::devices::force_dimension {

/// The vendor's automatic initialisation: for some seconds the motors move the handle to known
/// positions. It runs in a separate thread; the servo does not call the library meanwhile.
class AutoInit {
public:
  /// Result of turn(), which the servo calls once per tick before it calls the library.
  enum class Turn {
    kServo,   ///< the servo uses the device
    kBegins,  ///< initialisation was requested: the servo's force must end with this tick
    kRunning, ///< initialisation uses the device
    kEnded    ///< initialisation has just ended, see failed()
  };

  /// Call it at each opening, before the servo starts. Returns whether the library and this device
  /// support the initialisation. The caller serialises all functions but turn() with one lock.
  [[nodiscard]] bool prepare(const DhdLibrary& library, char id) {
    shared_ = std::make_shared<Shared>(library, id);
    return library.auto_init && library.robot_stop && library.robot_supported &&
           library.robot_supported(id);
  }
  /// Returns an empty text, or the reason why the initialisation cannot begin. The host's thread
  /// calls it, after prepare().
  [[nodiscard]] std::string start() {
    Stage none = Stage::kNone;
    if (!shared_->stage.compare_exchange_strong(none, Stage::kAsked))
      return "the device is already being initialised";
    shared_->over = false;
    shared_->failed = false;
    std::string reason = thread_.start(std::make_shared<Work>(shared_));
    if (!reason.empty())
      shared_->stage = Stage::kNone;
    return reason;
  }
  /// True if the last initialisation failed; why() returns the library's reason.
  [[nodiscard]] bool failed() const noexcept { return shared_ && shared_->failed; }
  [[nodiscard]] const char* why() const noexcept { return shared_->reason; }

  [[nodiscard]] Turn turn() noexcept {
    Stage stage = Stage::kAsked;
    if (shared_->stage.compare_exchange_strong(stage, Stage::kRunning))
      return Turn::kBegins;
    if (stage == Stage::kRunning)
      return Turn::kRunning;
    stage = Stage::kEnded;
    return shared_->stage.compare_exchange_strong(stage, Stage::kNone) ? Turn::kEnded
                                                                       : Turn::kServo;
  }
  /// Call it while no servo runs. If the initialisation runs, this function ends it, leaves the
  /// closing of the device to its thread, waits at most about 20 ms for that thread and returns
  /// true. If it returns false, the caller closes the device.
  [[nodiscard]] bool stop_and_close() noexcept {
    Shared& s = *shared_;
    std::unique_lock lock(s.closing);
    s.close_it = s.stage == Stage::kRunning && !s.over;
    const bool left = s.close_it;
    // Repeated, because a call that comes before the library has begun has no effect.
    for (int tries = 0; left && !s.over && tries < kMaxStops; ++tries) {
      static_cast<void>(s.robot_stop(false, s.id));
      lock.unlock();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      lock.lock();
    }
    thread_.end(); // also if the work has not begun
    return left;
  }

private:
  enum class Stage { kNone, kAsked, kRunning, kEnded };
  static constexpr int kMaxStops = 20;

  struct Shared {
    Shared(const DhdLibrary& library, char device)
        : auto_init(library.auto_init), robot_stop(library.robot_stop), close(library.close),
          last_error(library.last_error), id(device) {}
    int (*auto_init)(char id);
    int (*robot_stop)(bool motors_on, char id);
    int (*close)(char id);
    const char* (*last_error)();
    char id;
    std::atomic<Stage> stage{Stage::kNone};
    std::atomic<bool> failed{false};
    std::atomic<const char*> reason{""};
    std::mutex closing;
    bool over = false, close_it = false; // guarded by `closing`
  };
  struct Work : BackgroundState {
    explicit Work(std::shared_ptr<Shared> with) : shared(std::move(with)) {}
    void work() override {
      Shared& s = *shared;
      while (s.stage == Stage::kAsked && !stop)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (s.stage != Stage::kRunning)
        return;
      s.failed = s.auto_init(s.id) < 0;
      if (s.failed)
        s.reason = s.last_error();
      const std::lock_guard lock(s.closing);
      static_cast<void>(s.robot_stop(!s.close_it, s.id)); // ends the library's position control
      s.over = true;
      s.stage = Stage::kEnded;
      if (s.close_it)
        s.close(s.id);
    }
    std::shared_ptr<Shared> shared;
  };
  std::shared_ptr<Shared> shared_;
  BackgroundThread thread_;
};

} // namespace tactus::devices::force_dimension
