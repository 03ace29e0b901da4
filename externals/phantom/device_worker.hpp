#pragma once

#include "devices/driver.hpp"

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace tactus::phantom {

/// Opens, closes, looks for and lists devices in a thread of its own, since each may take seconds.
/// The thread begins with the first task. Answers are taken by the host's thread.
class DeviceWorker {
public:
  using Device = std::shared_ptr<haptic::Backend>;

  struct Answer {
    enum class Kind { kOpened, kRefused, kListed };
    Kind kind = Kind::kRefused;
    std::uint64_t ticket = 0; ///< the request's
    Device device;
    std::string refusal;                                          ///< one sentence
    std::vector<devices::Found> found;                            ///< of kListed
    std::vector<std::pair<std::string, std::string>> obstacles{}; ///< drivers that cannot work
  };

  /// `ready` is called in the worker's thread whenever an answer waits.
  explicit DeviceWorker(std::function<void()> ready) : ready_(std::move(ready)) {}
  ~DeviceWorker() { finish(); }
  DeviceWorker(const DeviceWorker&) = delete;
  DeviceWorker& operator=(const DeviceWorker&) = delete;

  /// Opens it once; one refusal is an answer.
  void open(const devices::Driver& driver, Device device, std::uint64_t ticket);
  /// Closes it and tries to open it again after 0.25, 0.5, 1, 2 and then every 4 s, until it
  /// succeeds or another ticket is asked for.
  void reopen(const devices::Driver& driver, Device device, std::uint64_t ticket);
  /// What was asked for before is not wanted any more.
  void forget();
  void close(Device device);
  void list();
  [[nodiscard]] std::optional<Answer> take();
  /// Ends the thread after the task under way; the devices that wait to be closed are closed.
  void finish() noexcept;

private:
  struct Task {
    enum class Kind { kOpen, kReopen, kClose, kList };
    Kind kind;
    const devices::Driver* driver = nullptr;
    Device device;
    std::uint64_t ticket = 0;
  };
  void give(Task task);
  void answer(Answer answer);
  void work();
  void carry_out(const Task& task);
  void announce(const Task& task);
  void open_once(const Task& task);
  void open_in_time(const Task& task);
  [[nodiscard]] bool wanted(std::uint64_t ticket);
  [[nodiscard]] static std::string opened(const Task& task);

  std::function<void()> ready_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Task> tasks_;
  std::deque<Answer> answers_;
  std::uint64_t ticket_ = 0; // the newest that was asked for
  bool ending_ = false;
  std::thread thread_;
};

} // namespace tactus::phantom
