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

/// Opens, runs, closes, looks for and lists devices in a thread of its own, since a call of a
/// driver may take seconds or never return. The host's thread waits for none of them: it gives
/// tasks, which are carried out in their order, and takes answers. What the thread works on lives
/// as long as the thread, also when this is destroyed: it then finishes its tasks by itself.
class DeviceWorker {
public:
  using Device = std::shared_ptr<haptic::Backend>;

  /// A servo that runs on a device: what its steps touch, and who takes them.
  struct Session {
    std::shared_ptr<ServoRig> rig;
    std::shared_ptr<devices::ServoThread> runner;
  };

  struct Answer {
    enum class Kind {
      kOpened,
      kRefused, ///< the device was not opened
      kRunning,
      kNotRunning, ///< the servo was not started
      kClosed,     ///< by close(), not when a task replaced another
      kTrouble,    ///< a lost device is still away: the driver's sentence, once each
      kListed
    };
    Kind kind = Kind::kRefused;
    std::uint64_t ticket = 0; ///< the request's
    Device device{};
    std::string sentence{};                                      ///< why not
    bool released = true;                                        ///< of kClosed: zero force taken
    std::vector<devices::Found> found{};                         ///< of kListed
    std::vector<std::pair<std::string, std::string>> problems{}; ///< drivers that cannot work
  };

  /// `ready` is called in the worker's thread whenever an answer waits, until this is destroyed.
  explicit DeviceWorker(std::function<void()> ready);
  /// Without waiting: what was asked to be opened is not wanted any more.
  ~DeviceWorker();
  DeviceWorker(const DeviceWorker&) = delete;
  DeviceWorker& operator=(const DeviceWorker&) = delete;

  // Each gives the thread a task; empty, or why there is no thread to carry it out.
  /// Opens the device once; one refusal is an answer.
  [[nodiscard]] std::string open(const devices::Driver& driver, Device device,
                                 std::uint64_t ticket);
  /// Starts the servo on the opened device.
  [[nodiscard]] std::string run(Session session, double period_s, std::uint64_t ticket);
  /// Ends the session, if there is one, and the device's connection. The caller has paused the
  /// motors: it is waited 200 ms for their zero force. The driver, if given, is for the messages.
  [[nodiscard]] std::string close(const devices::Driver* driver, Session session, Device device);
  /// The same, then tries to open it again after 0.25, 0.5, 1, 2 and then every 4 s, until it
  /// succeeds or another ticket is asked for.
  [[nodiscard]] std::string reopen(const devices::Driver& driver, Session session, Device device,
                                   std::uint64_t ticket);
  [[nodiscard]] std::string list();
  /// What was asked to be opened before is not wanted any more; it is closed when it opens.
  void abandon();

  [[nodiscard]] std::optional<Answer> take();
  [[nodiscard]] bool busy() const;
  /// Asks an opening that is not wanted any more to end; to be repeated while busy().
  void cancel_unwanted();
  /// What has not returned for longer than `limit_s` though nobody waits for a device any more,
  /// such as "closing the device"; empty when all is well.
  [[nodiscard]] std::string overdue(double limit_s) const;

  /// For the end of the host's program: waits until every worker's thread has finished, `seconds`
  /// at most in all. What still hangs then is said on the standard error.
  static void join_all(double seconds) noexcept;
  /// This one's thread has ended all tasks, or not within that time. Nothing more can be asked for.
  [[nodiscard]] bool finish(double seconds) noexcept;

private:
  struct State;
  struct Task;
  [[nodiscard]] std::string enqueue(Task task);

  std::shared_ptr<State> state_; // shared with the thread
};

} // namespace tactus::phantom
