#pragma once

#include "core/haptic/servo/servo.hpp"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

namespace tactus::phantom {

/// A CSV file with one row per servo tick: position (mm), velocity (m/s) and written force (N).
class Trace {
public:
  /// Returns an empty text, or the reason why the file cannot be written.
  [[nodiscard]] std::string open(const std::string& path);
  /// Returns an empty text if every row has reached the file.
  std::string close();
  [[nodiscard]] bool is_open() const noexcept { return file_ != nullptr; }
  /// ms: the tick's time, for the file's time column. Row numbers continue if the servo restarts.
  void write(const haptic::Report& report, double ms);

private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t next_index_ = 0;                // next index of the servo's ticks
  std::uint64_t number_ = 0, first_number_ = 0; // row numbers of the next row and of the servo's
                                                // first tick
};

} // namespace tactus::phantom
