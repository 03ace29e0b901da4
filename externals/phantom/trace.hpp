#pragma once

#include "core/haptic/servo/servo.hpp"

#include <cstdio>
#include <memory>
#include <string>

namespace tactus::phantom {

/// A CSV file with one row per servo tick: position (mm), velocity (m/s) and written force (N).
class Trace {
public:
  /// Empty on success, else why the file cannot be written.
  [[nodiscard]] std::string open(const std::string& path);
  /// Empty when every row has reached the file.
  std::string close();
  [[nodiscard]] bool is_open() const noexcept { return file_ != nullptr; }
  void write(const haptic::Report& report);

private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

} // namespace tactus::phantom
