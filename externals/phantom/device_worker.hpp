#pragma once

#include "devices/driver.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/driver_use.hpp"
#include "externals/phantom/servo_rig.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tactus::phantom {

/// A thread that opens, runs, closes and lists devices, since a call of a driver may take seconds
/// or never return. The host's thread waits for none of these calls: it queues tasks, which run in
/// order, and reads answers. The thread owns the objects that it uses and finishes its tasks even
/// after this object is destroyed.
class DeviceWorker {
public:
  using Device = std::shared_ptr<haptic::Backend>;

  /// A servo that runs on a device: the rig that its steps use, and the thread that steps it.
  struct Session {
    std::shared_ptr<ServoRig> rig;
    std::shared_ptr<devices::ServoThread> runner;
  };

  /// The result of a task.
  struct Answer {
    enum class Kind {
      kOpened,
      kRefused, ///< the device was not opened
      kRunning,
      kNotRunning, ///< the servo was not started
      kClosed,     ///< answer to close() only
      kTrouble,    ///< reopen() failed: the driver's sentence, when it changes
      kListed
    };
    Kind kind = Kind::kRefused;
    std::uint64_t ticket = 0; ///< the request's
    Device device{};
    std::string sentence{};              ///< the reason of a refusal
    bool released = true;                ///< of kClosed: zero force was written
    std::vector<devices::Found> found{}; ///< of kListed
    std::vector<std::pair<std::string, std::string>> problems{}; ///< drivers that cannot work
  };

  /// `ready` is called in the worker's thread after each answer, until this object is destroyed.
  explicit DeviceWorker(std::function<void()> ready);
  /// Does not wait. Pending requests to open are abandoned.
  ~DeviceWorker();
  DeviceWorker(const DeviceWorker&) = delete;
  DeviceWorker& operator=(const DeviceWorker&) = delete;

  // Each queues a task. Empty, or the reason why there is no thread to run it.
  /// Opens the device; does not try again after a refusal.
  [[nodiscard]] std::string open(const devices::Driver& driver, Device device,
                                 std::uint64_t ticket);
  /// Starts the servo on the opened device.
  [[nodiscard]] std::string run(Session session, double period_s, std::uint64_t ticket);
  /// Ends the session, if there is one, and the device's connection. The caller has paused the
  /// motors; the thread waits up to 200 ms for zero force. The driver, if given, is named in
  /// messages.
  [[nodiscard]] std::string close(const devices::Driver* driver, Session session, Device device);
  /// As close(), then tries to open the device again after 0.25, 0.5, 1, 2 and then every 4 s,
  /// until it succeeds or a newer ticket is requested.
  [[nodiscard]] std::string reopen(const devices::Driver& driver, Session session, Device device,
                                   std::uint64_t ticket);
  /// Lists the devices of all drivers.
  [[nodiscard]] std::string list();
  /// Abandons earlier requests to open; a device that is opened nevertheless is closed.
  void abandon();

  /// The next answer, if there is one.
  [[nodiscard]] std::optional<Answer> take();
  /// Whether tasks are queued or running.
  [[nodiscard]] bool busy() const;
  /// Asks the driver to cancel an abandoned opening. Call it repeatedly while busy().
  void cancel_unwanted();
  /// The driver's call that has not returned for longer than `limit_s` after it was abandoned, such
  /// as "closing the device"; empty when there is none.
  [[nodiscard]] std::string overdue(double limit_s) const;

  /// At the end of the host's program: waits until all workers' threads have finished, up to
  /// `seconds` in all, and names the calls that still hang on the standard error.
  static void join_all(double seconds) noexcept;
  /// Ends this worker: no new tasks. Whether its thread has finished all tasks within that time.
  [[nodiscard]] bool finish(double seconds) noexcept;

private:
  struct State;
  struct Task;
  [[nodiscard]] std::string enqueue(Task task);

  std::shared_ptr<State> state_; // shared with the thread
};

} // namespace tactus::phantom
