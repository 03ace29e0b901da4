// Sends messages from two threads while a third performs, for the sanitizers.
#include "max/stub/stub.hpp"

#include <stdexcept>
#include <thread>

namespace tactus::stub {
namespace {
constexpr int kMinRounds = 10; // minimum rounds of each thread's messages
using Calls = std::vector<std::function<void()>>;
} // namespace

void run_threads(std::uint64_t vectors, std::span<const std::vector<std::string>> lines) {
  Calls of_main,
      of_scheduler; // prepared, so that only the external synchronises the threads
  for (const auto& line : lines)
    (line[0] == "main" ? of_main : of_scheduler)
        .push_back(prepare(line.at(1), Words(line).subspan(2)));
  std::atomic<int> rounds_of_main{0}, rounds_of_scheduler{0};
  std::atomic<bool> done{false};
  std::vector<std::string> from_main, from_scheduler, from_audio;
  const auto send = [&](Role role, const Calls& calls, std::vector<std::string>& lines_of_thread,
                        std::atomic<int>& rounds) {
    set_role(role);
    collect_lines(&lines_of_thread);
    while (!done.load(std::memory_order_relaxed)) {
      for (const auto& call : calls)
        call();
      role == kMain ? run_low_priority() : advance_clocks(audio_ms());
      rounds.fetch_add(1, std::memory_order_relaxed);
      std::this_thread::yield();
    }
  };
  std::thread performing([&] {
    collect_lines(&from_audio);
    for (std::uint64_t i = 0;
         i < vectors || rounds_of_main.load(std::memory_order_relaxed) < kMinRounds ||
         rounds_of_scheduler.load(std::memory_order_relaxed) < kMinRounds;
         ++i) {
      perform_vector();
      std::this_thread::yield();
    }
    done.store(true, std::memory_order_relaxed);
  });
  std::thread scheduling(
      [&] { send(kScheduler, of_scheduler, from_scheduler, rounds_of_scheduler); });
  send(kMain, of_main, from_main, rounds_of_main);
  performing.join();
  scheduling.join();
  collect_lines(nullptr);
  for (const auto* collected : {&from_main, &from_scheduler, &from_audio})
    for (const std::string& line : *collected)
      print_line(line);
}

} // namespace tactus::stub
