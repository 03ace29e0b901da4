#include "externals/phantom/device/device_worker.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

// DeviceWorker, whose thread opens and closes devices, with drivers that the tests control. They
// are the list that tactus::devices::drivers() gives, so this file cannot be combined with others
// into a namespace of its own.

using namespace tactus;
using phantom::DeviceJob;
using phantom::DeviceLister;
using phantom::DeviceWorker;
using phantom::DriverCalls;
using Answer = DeviceJob::Answer;
using Kind = Answer::Kind;

namespace {

/// Blocks calls of the driver while it is shut.
struct Gate {
  std::atomic<bool> shut{false};
  std::atomic<int> waiting{0};
  void pass() {
    ++waiting;
    while (shut)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --waiting;
  }
};

struct Plan {
  std::atomic<int> failures{0}; ///< openings that fail before one succeeds
  std::atomic<int> opened{0}, closed{0}, busy_ms{0}, lists{0}, problems{0}, cancelled{0};
  std::atomic<bool> open{false}, twice{false}, cancels{false};
  Gate opening, closing, reading, listing;
  std::atomic<double> newest_force_n{0};
} plan;

class Planned final : public haptic::Backend {
public:
  std::string open() override {
    if (plan.open.exchange(true))
      plan.twice = true;
    plan.opening.pass();
    std::this_thread::sleep_for(std::chrono::milliseconds(plan.busy_ms.load()));
    if (plan.failures.fetch_sub(1) > 0) {
      plan.open = false;
      return "planned: not this time";
    }
    ++plan.opened;
    return {};
  }
  void cancel() noexcept override {
    ++plan.cancelled;
    if (plan.cancels)
      plan.opening.shut = false;
  }
  void close() noexcept override {
    plan.closing.pass();
    plan.open = false;
    ++plan.closed;
  }
  haptic::Caps caps() const noexcept override { return {}; }
  bool read(const haptic::Tick&, haptic::State&) noexcept override {
    plan.reading.pass();
    return true;
  }
  bool write(const Vec3& force) noexcept override {
    plan.newest_force_n = force.x;
    return true;
  }
  haptic::Identity identity() const override { return {"maker", "model", "7"}; }
};

const devices::Driver kPlanned{
    "planned", "a test's", [] { return ++plan.problems, std::string(); },
    [] {
      ++plan.lists;
      plan.listing.pass();
      return std::vector<devices::Found>{{"planned", 0, {"maker", "model", "7"}, "ready"}};
    },
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<Planned>(); }};
const devices::Driver kHindered{"hindered", "a test's",
                                [] { return std::string("hindered: install it"); },
                                [] { return std::vector<devices::Found>{}; },
                                [] { return std::unique_ptr<haptic::Backend>(); }};

/// Waits for a condition, 20 s at most.
template <class True> void until(True&& true_now) {
  for (int n = 0; n < 20000 && !true_now(); ++n)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(true_now());
}

/// The next answer of a worker.
template <class AnyWorker> auto wait(AnyWorker& worker) {
  auto taken = worker.take();
  until([&] { return taken.answer || (taken = worker.take()).answer; });
  REQUIRE(taken.answer);
  return std::move(*taken.answer);
}

struct Rig {
  std::atomic<int> called{0};
  std::unique_ptr<DeviceWorker> worker = std::make_unique<DeviceWorker>([this] { ++called; });
  DeviceLister lister{[] {}};
  std::shared_ptr<haptic::Backend> device = kPlanned.make();
  std::uint64_t ticket = 0;

  Rig() {
    plan.failures = plan.opened = plan.closed = plan.busy_ms = plan.lists = plan.problems = 0;
    plan.open = plan.twice = plan.cancels = false;
    plan.cancelled = 0;
    for (Gate* gate : {&plan.opening, &plan.closing, &plan.reading, &plan.listing})
      gate->shut = false;
  }
  void want_open(bool persists = false) {
    CHECK(worker->request({++ticket, &kPlanned, device, persists}) == "");
  }
  void want_closed() { CHECK(worker->request({++ticket}) == ""); }
  Answer wait() const { return ::wait(*worker); }
  void open() {
    want_open();
    CHECK(wait().kind == Kind::kOpened);
  }
  void close() {
    want_closed();
    until([this] { return !worker->busy(); });
  }
  /// Whether all threads end within that time, once the worker has gone.
  bool finish(double seconds = 20) {
    worker.reset();
    return DriverCalls::join_all(seconds);
  }
  /// A servo on the opened device.
  DeviceJob::Session start() {
    DeviceJob::Session session{std::make_shared<phantom::ServoRig>(),
                               std::make_shared<devices::ServoThread>()};
    session.rig->device = device;
    session.rig->servo.attach(*device);
    haptic::Command push;
    push.force_n = {1, 0, 0};
    push.number = 1;
    push.heartbeat_s = devices::ServoThread::now_s() + 1e6;
    session.rig->servo.exchange().commands.write(push);
    CHECK(worker->request({ticket, &kPlanned, device, false, session, 1e-3}) == "");
    CHECK(wait().kind == Kind::kRunning);
    return session;
  }
};

} // namespace

namespace tactus::devices {
std::span<const Driver* const> drivers() noexcept {
  static const Driver* const all[] = {&kPlanned, &kHindered};
  return all;
}
} // namespace tactus::devices

TEST_CASE("a device is opened in the worker's thread; success and refusal are one answer each") {
  Rig rig;
  plan.failures = 1;
  rig.want_open();
  const Answer refused = rig.wait();
  CHECK(refused.kind == Kind::kRefused);
  CHECK(refused.sentence == "planned: not this time");
  rig.open();
  CHECK(rig.called == 2);
  rig.close();
  CHECK(rig.finish());
  CHECK(plan.closed == 1);
  CHECK_FALSE(plan.twice);
}

TEST_CASE("a lost device is opened again until that succeeds; the same trouble is reported once") {
  Rig rig;
  rig.open();
  plan.failures = 3;
  rig.want_open(true); // closes it first
  const Answer trouble = rig.wait();
  CHECK(trouble.kind == Kind::kTrouble);
  CHECK(trouble.sentence == "planned: not this time");
  CHECK(rig.wait().kind == Kind::kOpened);
  CHECK(plan.closed == 1);
  CHECK_FALSE(plan.twice);
  rig.close();
}

TEST_CASE("a list calls the drivers that are not in use; of others it lists the open devices") {
  Rig rig;
  const auto listed = [&](const char* state, int calls) {
    CHECK(rig.lister.request({}) == "");
    const auto answer = wait(rig.lister);
    REQUIRE(answer.found.size() == 1);
    CHECK(answer.found[0].identity.serial == "7");
    CHECK(answer.found[0].state == state);
    REQUIRE(answer.problems.size() == 1);
    CHECK(answer.problems[0].second == "hindered: install it");
    CHECK(plan.lists == calls);
  };
  listed("ready", 1);
  rig.open();
  const int asked = plan.problems;
  listed("open", 1); // the driver was not called
  CHECK(plan.problems == asked);
  rig.close();
  listed("ready", 2);
}

TEST_CASE("an opening waits for a list of the same driver") {
  Rig rig;
  plan.listing.shut = true;
  CHECK(rig.lister.request({}) == "");
  until([] { return plan.listing.waiting > 0; });
  rig.want_open();
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  CHECK_FALSE(plan.open);
  plan.listing.shut = false;
  CHECK(rig.wait().kind == Kind::kOpened);
}

TEST_CASE("a device that is not wanted any more is closed again, whenever that is said") {
  for (int wait_ms = 0; wait_ms < 12; ++wait_ms) {
    {
      Rig rig;
      plan.busy_ms = 5;
      rig.want_open();
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
      if (wait_ms % 2 == 0)
        rig.want_closed();
      rig.want_open();
      Answer answer = rig.wait();
      while (answer.ticket != rig.ticket)
        answer = rig.wait();
      CHECK(answer.kind == Kind::kOpened);
      CHECK(plan.open);
      CHECK_FALSE(plan.twice);
      CHECK(rig.finish());
    }
    CHECK_FALSE(plan.open);
  }
}

TEST_CASE("a worker that goes leaves nothing open") {
  for (int wait_ms = 0; wait_ms < 8; ++wait_ms) {
    Rig rig;
    plan.busy_ms = 3;
    plan.failures = wait_ms % 2;
    rig.want_open(wait_ms % 3 == 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    CHECK(rig.finish());
    CHECK_FALSE(plan.open);
  }
}

TEST_CASE("closing a session writes zero force last, on request and when its worker goes") {
  for (const auto& [slews, requested] : {std::pair(true, true), {true, false}, {false, true}}) {
    const bool falls = slews, asked = requested; // a binding cannot be captured
    CAPTURE(falls);
    CAPTURE(asked);
    Rig rig;
    rig.open();
    const DeviceJob::Session session = rig.start();
    until([] { return plan.newest_force_n > 0.9; });
    if (!falls) { // in time, by its slew
      haptic::ServoSettings slow;
      slow.chain.slew_n_per_s = 1e-3;
      session.rig->servo.exchange().settings.write(slow);
    }
    session.rig->servo.exchange().motors.pause(true);
    if (asked) {
      rig.close();
      CHECK(rig.worker->take().sentences.empty()); // it took the force
      CHECK_FALSE(plan.open);
    }
    CHECK(rig.finish());
    CHECK(plan.newest_force_n == 0.0);
    CHECK_FALSE(plan.open);
  }
}

TEST_CASE(
    "a hanging call is reported, keeps its rig and device alive, and closes when it returns") {
  Gate* gate = nullptr;
  SUBCASE("in a step of the servo") { gate = &plan.reading; }
  SUBCASE("in closing") { gate = &plan.closing; }
  REQUIRE(gate);
  std::weak_ptr<phantom::ServoRig> watched;
  std::weak_ptr<haptic::Backend> device;
  {
    Rig rig;
    rig.open();
    DeviceJob::Session session = rig.start();
    watched = session.rig;
    device = rig.device;
    gate->shut = true;
    if (gate == &plan.reading)
      until([&] { return gate->waiting > 0; });
    session.rig->servo.exchange().motors.pause(true);
    session = {};
    rig.want_closed();
    until([&] { return gate->waiting > 0; });
    until([&] { return rig.worker->overdue(0.05) == "planned: closing the device"; });
    CHECK(rig.worker->overdue(1e6) == "");
    // Another object that opens a device of this driver is refused after a while.
    DeviceWorker other{[] {}};
    CHECK(other.request({1, &kPlanned, kPlanned.make()}) == "");
    const Answer refused = wait(other);
    CHECK(refused.kind == Kind::kRefused);
    CHECK(refused.sentence.find("an earlier call of this driver has not returned") !=
          std::string::npos);
    rig.device.reset();
    CHECK_FALSE(rig.finish(0.05)); // and nobody has waited
  }
  CHECK_FALSE(watched.expired());
  CHECK_FALSE(device.expired());
  CHECK(plan.open);
  gate->shut = false;
  until([&] { return watched.expired() && device.expired(); });
  CHECK_FALSE(plan.open);
  CHECK(plan.closed > 0);
}

TEST_CASE("an opening that is not wanted any more is cancelled until it ends") {
  Rig rig;
  plan.opening.shut = plan.cancels = true;
  rig.want_open();
  until([] { return plan.opening.waiting > 0; });
  CHECK(rig.worker->overdue(0) == ""); // still wanted
  rig.worker->cancel_unwanted();
  CHECK(plan.cancelled == 0);
  SUBCASE("by its worker") {
    rig.want_closed();
    until([&] {
      rig.worker->cancel_unwanted();
      return !rig.worker->busy();
    });
    CHECK_FALSE(plan.open);
  }
  SUBCASE("by the end of the program") {}
  CHECK(rig.finish());
  CHECK(plan.cancelled > 0);
  CHECK_FALSE(plan.open);
}

TEST_CASE("the end of the program waits for all workers together, not for each") {
  Rig rig;
  plan.opening.shut = true;
  std::vector<std::unique_ptr<DeviceWorker>> workers;
  for (int i = 0; i < 5; ++i) {
    workers.push_back(std::make_unique<DeviceWorker>([] {}));
    CHECK(workers.back()->request({1, &kPlanned, kPlanned.make()}) == "");
  }
  until([] { return plan.opening.waiting == 5; });
  workers.clear();
  const auto begun = std::chrono::steady_clock::now();
  CHECK_FALSE(DriverCalls::join_all(2));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  CHECK(took.count() >= 2);
  CHECK(took.count() < 8); // each on its own: 10 s
  plan.opening.shut = false;
  CHECK(DriverCalls::join_all(20));
  CHECK_FALSE(plan.open);
}
