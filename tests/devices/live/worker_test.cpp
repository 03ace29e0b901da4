#include "externals/phantom/device_worker.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

// The thread that opens and closes devices, with drivers that do as the tests say.

using namespace tactus;
using phantom::DeviceWorker;
using Answer = DeviceWorker::Answer;

namespace {

struct Plan {
  std::atomic<int> failures{0}; ///< openings that fail before one succeeds
  std::atomic<int> opened{0}, closed{0}, busy_ms{0};
  std::atomic<bool> open{false}, twice{false};
} plan;

class Planned final : public haptic::Backend {
public:
  std::string open() override {
    if (plan.open.exchange(true))
      plan.twice = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(plan.busy_ms.load()));
    if (plan.failures.fetch_sub(1) > 0) {
      plan.open = false;
      return "planned: not this time";
    }
    ++plan.opened;
    return {};
  }
  void close() noexcept override {
    plan.open = false;
    ++plan.closed;
  }
  haptic::Caps caps() const noexcept override { return {}; }
  bool read(const haptic::Tick&, haptic::State&) noexcept override { return true; }
  bool write(const haptic::Vec3&) noexcept override { return true; }
};

const devices::Driver kPlanned{
    "planned", "a test's", [] { return std::string(); },
    [] {
      return std::vector<devices::Found>{{"planned", 0, {"maker", "model", "7"}, "ready"}};
    },
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<Planned>(); }};
const devices::Driver kHindered{"hindered", "a test's",
                                [] { return std::string("hindered: install it"); },
                                [] { return std::vector<devices::Found>{}; },
                                [] { return std::unique_ptr<haptic::Backend>(); }};

struct Rig {
  std::atomic<int> called{0};
  DeviceWorker worker{[this] { ++called; }};
  std::shared_ptr<haptic::Backend> device = kPlanned.make();

  Rig() {
    plan.failures = plan.opened = plan.closed = plan.busy_ms = 0;
    plan.open = plan.twice = false;
  }
  Answer wait() {
    for (int n = 0; n < 20000; ++n) {
      if (auto answer = worker.take())
        return std::move(*answer);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    FAIL("no answer");
    return {};
  }
};

} // namespace

namespace tactus::devices {
std::span<const Driver* const> drivers() noexcept {
  static const Driver* const all[] = {&kPlanned, &kHindered};
  return all;
}
} // namespace tactus::devices

TEST_CASE("a device is opened beside, and a refusal is one answer") {
  Rig rig;
  plan.failures = 1;
  rig.worker.open(kPlanned, rig.device, 1);
  const Answer refused = rig.wait();
  CHECK(refused.kind == Answer::Kind::kRefused);
  CHECK(refused.refusal == "planned: not this time");
  rig.worker.open(kPlanned, rig.device, 2);
  const Answer opened = rig.wait();
  CHECK(opened.kind == Answer::Kind::kOpened);
  CHECK(opened.ticket == 2);
  CHECK(rig.called == 2);
  rig.worker.close(opened.device);
  rig.worker.finish();
  CHECK(plan.closed == 1);
  CHECK_FALSE(plan.twice);
}

TEST_CASE("a lost device is tried again until it returns, and lists are answered meanwhile") {
  Rig rig;
  plan.failures = 2;
  plan.open = true; // it was
  rig.worker.reopen(kPlanned, rig.device, 1);
  rig.worker.list();
  const Answer listed = rig.wait();
  CHECK(listed.kind == Answer::Kind::kListed);
  REQUIRE(listed.found.size() == 1);
  CHECK(listed.found[0].identity.serial == "7");
  REQUIRE(listed.obstacles.size() == 1);
  CHECK(listed.obstacles[0].second == "hindered: install it");
  CHECK(rig.wait().kind == Answer::Kind::kOpened);
  CHECK_FALSE(plan.twice);
}

TEST_CASE("who is not wanted any more is closed again, whenever that is said") {
  for (int wait_ms = 0; wait_ms < 12; ++wait_ms) {
    {
      Rig rig;
      plan.busy_ms = 5;
      rig.worker.open(kPlanned, rig.device, 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
      rig.worker.forget();
      while (const auto answer = rig.worker.take())
        if (answer->kind == Answer::Kind::kOpened)
          rig.worker.close(answer->device);
      rig.worker.open(kPlanned, rig.device, 2);
      CHECK(rig.wait().ticket == 2);
      CHECK(plan.open);
      CHECK_FALSE(plan.twice);
      rig.worker.close(rig.device);
    }
    CHECK_FALSE(plan.open);
  }
}

TEST_CASE("ending leaves nothing open") {
  for (int wait_ms = 0; wait_ms < 8; ++wait_ms) {
    {
      Rig rig;
      plan.busy_ms = 3;
      plan.failures = wait_ms % 2;
      if (wait_ms % 3 == 0)
        rig.worker.reopen(kPlanned, rig.device, 1);
      else
        rig.worker.open(kPlanned, rig.device, 1);
      rig.worker.list();
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    }
    CHECK_FALSE(plan.open);
  }
}
