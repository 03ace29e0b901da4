#include "devices/real_time.hpp"
#include "externals/modal_impact~/table_worker.hpp"
#include "externals/playability_map/map_worker.hpp"
#include "files/background_thread.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

// Threads that wait are woken and end, whenever that is asked for. A wake-up that is lost shows as
// a test that does not end (docs/cross_build.md, "What Windows loses").

using namespace tactus;

namespace {
constexpr int kRounds = 2000;
} // namespace

TEST_CASE("a worker ends whether it waits, works or has not begun") {
  std::atomic<int> ready{0};
  modal::TableJob::Request request;
  request.body = {"no-such-file", "no-such-file", 1};
  for (int i = 0; i < kRounds; ++i) {
    modal::TableWorker worker;
    worker.on_ready([&] { ++ready; });
    for (int requests = i % 4; requests-- > 0; ++request.body.number)
      REQUIRE(worker.request(request).empty());
    if (i % 3 == 0)
      std::this_thread::yield();
  }
  CHECK(ready > 0);
}

TEST_CASE("work in the background is not waited for, and tells nobody once its owner has gone") {
  struct Slow : BackgroundState {
    std::atomic<bool> at_work{false}, released{false};
    void work() override {
      at_work = true;
      while (!released)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard lock(mutex);
      if (ready)
        ready();
    }
  };
  auto state = std::make_shared<Slow>();
  const std::weak_ptr<Slow> held = state;
  std::atomic<int> reported{0};
  state->ready = [&reported] { ++reported; };
  {
    BackgroundThread thread;
    REQUIRE(thread.start(state).empty());
    while (!state->at_work)
      std::this_thread::yield();
  }
  CHECK(state->stop);
  state->released = true;
  state = nullptr;
  while (!held.expired()) // it holds what it uses, and no longer
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(reported == 0);
}

TEST_CASE("a map that takes the place of another, or is deleted, does not wait for a portion") {
  const auto released = std::make_shared<std::atomic<bool>>(false);
  const auto portions = std::make_shared<std::atomic<int>>(0);
  const auto held = [released, portions](std::vector<double>& nodes, std::size_t first) {
    ++*portions;
    while (!*released)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    nodes[first] = 1;
    return first + 1;
  };
  {
    reed::MapWorker worker;
    REQUIRE(worker.start(4, held).empty());
    while (*portions == 0)
      std::this_thread::yield();
    REQUIRE(worker.start(2, [](std::vector<double>& nodes, std::size_t) { return nodes.size(); })
                .empty());
    CHECK(worker.size() == 2);
    CHECK(worker.done() == 0);
    *released = true;
    while (!worker.finished())
      std::this_thread::yield();
    CHECK(*portions == 1); // stopped after it
    *released = false;
    REQUIRE(worker.start(4, held).empty());
    while (*portions == 1)
      std::this_thread::yield();
  }
  CHECK(!*released);
  *released = true;
  while (portions.use_count() > 2) // this function's two
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(*portions == 2);
}

TEST_CASE("no wake-up is lost between two threads that wait for each other") {
  devices::WakeCount there, back;
  constexpr int kTurns = 50000;
  std::thread other([&] {
    for (int seen = 0; seen < kTurns;) {
      seen = there.wait(seen);
      back.wake();
    }
  });
  for (int turn = 0; turn < kTurns;) {
    there.wake();
    turn = back.wait(turn);
  }
  other.join();
}
