#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace tactus::fem {

/// Reports the progress of a program on stderr: a line for each stage with the completed fraction
/// and the time left. The time left is computed from the rate so far or, for a stage of unknown
/// progress, from the predicted time. On a terminal the line is rewritten twice a second; a log
/// gets a line when a stage begins and ends and one every 5 s in between. Any thread may call
/// stage(); a thread of this object prints the time while a stage makes no calls.
class ProgressLine {
public:
  /// If quiet, it prints only sentences that begin with "warning: ".
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Begins a stage with a new name or updates the present stage. `share` is 0 to 1; 1 ends the
  /// stage. `predicted_s` is the time of the whole stage, 0 if unknown.
  void stage(const std::string& name, double share, double predicted_s = 0);
  void notify(const std::string& sentence);

private:
  using Clock = std::chrono::steady_clock;
  void watch();
  void print(bool ended);
  [[nodiscard]] std::string line() const;
  [[nodiscard]] static double seconds_since(Clock::time_point);

  bool quiet_, terminal_;
  std::mutex mutex_;
  std::condition_variable change_;
  bool stop_ = false;
  std::string name_;
  double share_ = 0, predicted_s_ = 0;
  bool rewriting_ = false; ///< a terminal's line that the next one replaces
  const Clock::time_point start_ = Clock::now();
  Clock::time_point stage_start_ = start_, last_print_ = start_;
  std::thread watcher_;
};

} // namespace tactus::fem
