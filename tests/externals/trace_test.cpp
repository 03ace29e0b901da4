#include "externals/phantom/trace.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <unistd.h>

using namespace tactus;

TEST_CASE("a trace counts on where the servo begins again, and tells a microsecond after weeks") {
  const auto path =
      std::filesystem::temp_directory_path() / ("tactus_trace_" + std::to_string(getpid()));
  phantom::Trace trace;
  REQUIRE(trace.open(path.string()).empty());
  haptic::Report report;
  const std::uint64_t indices[] = {500, 501, 0, 1, 2, 0};
  double ms = 2.4e9 + 0.001; // four weeks
  for (const std::uint64_t index : indices) {
    report.tick.index = index;
    trace.write(report, ms);
    ms += 1.001;
  }
  REQUIRE(trace.close().empty());
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  for (int row = 0; std::getline(file, line); ++row) {
    std::istringstream words(line);
    std::string tick, time;
    std::getline(words, tick, ',');
    std::getline(words, time, ',');
    CHECK(tick == std::to_string(500 + row));
    CHECK(std::stod(time) - 2.4e9 == doctest::Approx(0.001 + 1.001 * row).epsilon(1e-3));
  }
  std::filesystem::remove(path);
}
