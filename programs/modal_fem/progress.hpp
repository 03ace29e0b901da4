#pragma once
#include <chrono>
#include <string>

namespace tactus::fem {

/// Lines on stderr: a stage, its share in tenths, seconds since the start.
class ProgressLine {
public:
  explicit ProgressLine(bool quiet) : quiet_(quiet) {}
  void stage(const std::string& name, double share);
  void say(const std::string& sentence);

private:
  bool quiet_;
  std::string last_;
  int tenth_ = -1;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace tactus::fem
