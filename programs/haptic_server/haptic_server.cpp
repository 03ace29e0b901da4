// haptic_server: serves a haptic device over the network. docs/formats/haptic_protocol.md describes
// the protocol.
#include "externals/phantom/output/trace.hpp"
#include "programs/device_options/interrupt.hpp"
#include "programs/haptic_server/station.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>

#include <unistd.h>

namespace {

using namespace tactus;
using namespace tactus::haptic_server;

std::atomic<haptic::MotorControl*> motors{nullptr};
static_assert(std::atomic<haptic::MotorControl*>::is_always_lock_free); // so that signal handlers
                                                                        // may use it

constexpr auto kPollInterval = std::chrono::milliseconds(5);
constexpr int kPollsPerTroubleCheck = 100;

void listen_for_signals() noexcept {
  programs::listen_for_interrupts(
      "haptic_server: a call of the device's driver does not return; the "
      "program ends without it. Switch the device off and on\n");
  struct sigaction action {};
  action.sa_flags = SA_RESTART;
  action.sa_handler = [](int) {
    if (haptic::MotorControl* control = motors)
      control->emergency_stop();
  };
  sigaction(SIGUSR1, &action, nullptr);
  action.sa_handler = [](int) {
    if (haptic::MotorControl* control = motors)
      control->enable();
  };
  sigaction(SIGUSR2, &action, nullptr);
  action.sa_handler = SIG_IGN; // a write to a client that has closed its socket must not end the
                               // program
  sigaction(SIGPIPE, &action, nullptr);
}

/// Local time as a text, such as "2026-11-28 14:05:09 ".
std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char text[32];
  return std::string(text, std::strftime(text, sizeof text, "%F %T ", &local));
}

void say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

int serve(Station& station, const Options& options, phantom::Trace& trace) {
  const auto drain = [&] {
    haptic::Report report;
    while (station.exchange().trace.pop(report))
      trace.write(report, report.tick.time_s * 1e3);
  };
  std::string trouble;
  for (int looks = 0; !programs::interrupted() && !(options.once && station.all_clients_left());
       ++looks) {
    drain();
    for (const std::string& line : station.take_notices())
      say(time_of_day() + line);
    if (looks % kPollsPerTroubleCheck == 0)
      if (std::string now = station.trouble(); now != trouble) {
        trouble = std::move(now);
        if (!trouble.empty())
          std::fprintf(stderr, "%shaptic_server: %s\n", time_of_day().c_str(), trouble.c_str());
      }
    std::this_thread::sleep_for(kPollInterval);
  }
  motors = nullptr;
  programs::limit_time_to_end();
  station.close();
  drain();
  for (const std::string& line : station.take_notices())
    say(time_of_day() + line);
  if (station.exchange().trace.dropped() > 0)
    std::fprintf(stderr, "haptic_server: %llu ticks are missing in the trace\n",
                 static_cast<unsigned long long>(station.exchange().trace.dropped()));
  if (const std::string failure = trace.close(); !failure.empty())
    return std::fprintf(stderr, "haptic_server: %s: %s\n", options.trace.c_str(), failure.c_str()),
           1;
  say(time_of_day() + "haptic_server: ended, force off");
  return 0;
}

} // namespace

int main(int count, char** words) {
  const ParsedOptions parsed = parse_options(count, words);
  if (!parsed.error.empty())
    return std::fprintf(stderr, "haptic_server: %s\n", parsed.error.c_str()), 2;
  const Options& options = parsed.options;
  if (options.help)
    return std::printf("%s", usage()), 0;
  phantom::Trace trace;
  if (!options.trace.empty())
    if (const std::string failure = trace.open(options.trace); !failure.empty())
      return std::fprintf(stderr, "haptic_server: cannot write %s: %s\n", options.trace.c_str(),
                          failure.c_str()),
             1;
  listen_for_signals();
  Station station;
  if (const std::string error = station.open(options); !error.empty())
    return std::fprintf(stderr, "haptic_server: %s\n", error.c_str()), 1;
  motors = &station.exchange().motors;
  say("haptic_server: " + station.description());
  return serve(station, options, trace);
}
