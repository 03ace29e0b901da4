// What a remote device reads: its position at every tick of a servo, with the time of the reading.
//
//   bench_position_age HOST PORT TCP|UDP SECONDS [TOKEN_FILE]
//
// One row a millisecond, `s mm`: the clock of the servo (CLOCK_MONOTONIC) and x.
// bench/position_age.py runs it against a haptic_server whose handle moves along a known path, and
// makes ages of the rows.
#include "core/haptic/device/force_timeout.hpp"
#include "net/remote_device.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

using namespace tactus;

int main(int count, char** words) {
  const std::string transport = count > 3 ? words[3] : "";
  const double seconds = count > 4 ? std::atof(words[4]) : 0;
  if ((transport != "TCP" && transport != "UDP") || !(seconds > 0 && seconds <= 600))
    return std::fprintf(stderr, "usage: %s HOST PORT TCP|UDP SECONDS [TOKEN_FILE]\n", words[0]), 2;
  net::RemoteDevice device;
  std::vector<std::vector<std::string>> settings{
      {words[1], words[2], "udp", transport == "UDP" ? "1" : "0"}};
  if (count > 5)
    settings.push_back({"token", words[5]});
  for (const auto& setting : settings)
    if (const std::string refusal = device.configure(setting); !refusal.empty())
      return std::fprintf(stderr, "bench_position_age: %s\n", refusal.c_str()), 1;
  if (const std::string refusal = device.open(); !refusal.empty())
    return std::fprintf(stderr, "bench_position_age: %s\n", refusal.c_str()), 1;
  struct Row {
    double time_s, x_mm;
  };
  std::vector<Row> rows;
  const auto ticks = static_cast<std::size_t>(seconds * 1e3);
  rows.reserve(ticks);
  int unanswered = 0;
  auto due = std::chrono::steady_clock::now();
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
    haptic::State state;
    unanswered += device.read({}, state) ? 0 : 1;
    rows.push_back({haptic::ForceTimeout::now_s(), 1e3 * state.position.x});
  }
  const std::string trouble = device.trouble();
  device.close();
  if (!trouble.empty())
    std::fprintf(stderr, "bench_position_age: %s\n", trouble.c_str());
  if (unanswered > 0)
    std::fprintf(stderr, "bench_position_age: no position for %d ticks\n", unanswered);
  for (const Row& row : rows)
    std::printf("%.6f %.7g\n", row.time_s, row.x_mm);
  return 0;
}
