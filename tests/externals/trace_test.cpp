#include "externals/phantom/output/trace.hpp"
#include "externals/phantom/phantom.hpp"
#include "tests/externals/by_name.hpp"
#include "tests/externals/recording_host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

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

TEST_CASE("on the wall clock hits and the trace agree on when the hand met the wall") {
  const auto path =
      std::filesystem::temp_directory_path() / ("tactus_hits_" + std::to_string(getpid()));
  test::RecordingHost host({}, true);
  Phantom phantom;
  const auto send = [&](std::string_view message, const std::vector<Atom>& words) {
    test::send(phantom, message, std::span<const Atom>(words), host);
  };
  send("hand", {"rigid"});
  send("path", {"line", 0., 0., 5., 0., 0., -5., 100.});
  send("scene", {"add", "wall", "plane", 0., 0., 1., 0.});
  send("clock", {"wall"});
  phantom.created(host);
  send("trace", {std::string_view(path.native())});
  const auto hits = [&] {
    return std::count_if(host.infos.begin(), host.infos.end(),
                         [](const std::string& line) { return line.starts_with("hit"); });
  };
  const auto begun = std::chrono::steady_clock::now();
  while (hits() < 6 && std::chrono::steady_clock::now() < begun + std::chrono::seconds(30)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::chrono::duration<double, std::milli> passed =
        std::chrono::steady_clock::now() - begun;
    host.time_ms = 1.333 * std::floor(1.0001 * passed.count() / 1.333); // its card is 100 ppm fast
    for (std::size_t timer = 0; timer < Phantom::timers; ++timer)
      phantom.tick(timer, host);
  }
  send("trace", {"stop"});
  REQUIRE(hits() >= 6);
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<double> entries; // ms of the first row inside the wall
  for (double before = 0; std::getline(file, line);) {
    std::istringstream words(line);
    double tick = 0, ms = 0, x = 0, y = 0, z = 0;
    char comma = 0;
    words >> tick >> comma >> ms >> comma >> x >> comma >> y >> comma >> z;
    if (z <= 0 && before > 0)
      entries.push_back(ms);
    before = z;
  }
  for (const std::string& said : host.infos)
    if (said.starts_with("hit")) {
      const double ms = std::stod(said.substr(4));
      CHECK(std::any_of(entries.begin(), entries.end(),
                        [ms](double entry) { return std::abs(entry - ms) < 1; }));
    }
  std::filesystem::remove(path);
}
