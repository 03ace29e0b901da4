// Blows, points and silence at their own samples.
#include "core/modal/body/timed_queue.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// Samples at which a force begins.
std::vector<std::size_t> onsets(const std::vector<float>& contact) {
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < contact.size(); ++n)
    if (contact[n] > 0 && (n == 0 || contact[n - 1] == 0))
      found.push_back(n);
  return found;
}

constexpr Striker kLight{0.001, 0.003, 206e9, 0.29, 0, 1.5, 0, 1};
constexpr Vec3 kPoint{0.05, 0.03, 0};

} // namespace

TEST_CASE("a queue gives events by time, and equal times as they came") {
  TimedQueue<int, 8> queue;
  CHECK(queue.next() == TimedQueue<int, 8>::kNever);
  for (int round = 0; round < 5; ++round) { // its ring wraps
    for (const auto& [time, event] :
         {std::pair{30, 1}, {10, 2}, {20, 3}, {10, 4}, {30, 5}, {-5, 6}, {20, 7}})
      queue.push(time, event);
    CHECK(!queue.full());
    queue.push(20, 8);
    CHECK(queue.full());
    std::vector<int> order;
    while (!queue.empty())
      order.push_back(queue.pop());
    CHECK(order == std::vector<int>{6, 2, 4, 3, 7, 8, 1, 5});
  }
  queue.push(50, 1);
  queue.expire_all();
  CHECK(queue.next() < 0);
}

TEST_CASE("scheduled strikes begin at their samples in blocks of any size, and sound the same") {
  check_same_bits(
      [](std::size_t block) {
        Rig rig;
        rig.body.set_options(rig.options);
        rig.body.set_striker(kLight);
        for (const std::int64_t sample : {5000, 350, 351, 2003, 640})
          rig.body.schedule(rig.at(kPoint, 1), sample);
        Output output = rig.run(8192, block);
        const auto begin = onsets(output.contact);
        for (const std::size_t sample : {350UL, 640UL, 2003UL, 5000UL})
          CHECK(std::count(begin.begin(), begin.end(), sample) == 1);
        append(output.left, output.contact);
        return output.left;
      },
      {1, 7, 100, 4096});
}

TEST_CASE("a scheduled strike uses the striker and the clock of its message") {
  Rig rig;
  rig.body.set_options(rig.options);
  rig.body.begin_block(1000000);
  rig.body.set_striker(kLight);
  rig.body.schedule(rig.at(kPoint, 1), 1000100);
  rig.body.set_striker({0.1, 0.003, 206e9, 0.29, 0, 1.5, 0, 1}); // of a later strike
  const Output output = rig.run(2400);
  CHECK(onsets(output.contact).front() == 100);
  CHECK(impulse(output) < 2 * 0.001);
  // Pd's first long block begins before time 0.
  rig.body.begin_block(-4000);
  rig.body.schedule(rig.at(kPoint, 1), 50);
  CHECK(onsets(rig.run(4096).contact).front() == 4050);
  // What is late happens at once.
  rig.body.schedule(rig.at(kPoint, 1), 3);
  CHECK(onsets(rig.run(2400).contact).front() == 0);
}

TEST_CASE("the point moves, and the body is silenced, at the sample that was asked for") {
  const auto play = [](std::size_t block, bool scheduled) {
    Rig rig;
    rig.set_point(kPoint);
    if (scheduled) {
      const SurfacePoint next = rig.body.model()->nearest({-0.1, 0.01, 0});
      rig.body.schedule(ForcePoint{next, next.normal}, 1234);
      CHECK(rig.body.point().position == next.position);
      rig.body.schedule(Reset{}, 3000);
    }
    return rig.run(6000, block, std::vector<float>(2000, 1.0F)).left;
  };
  check_same_bits([&](std::size_t block) { return play(block, true); }, {1, 100, 6000});
  const auto moved = play(64, true), same = play(64, false);
  CHECK(std::equal(same.begin(), same.begin() + 1234, moved.begin()));
  CHECK(!std::equal(same.begin() + 1234, same.begin() + 1300, moved.begin() + 1234));
  CHECK(loudest(std::span(moved).subspan(3100 + ModeBank::kRelease)) == 0);
}

TEST_CASE("more events than the queue holds, and an exchanged body, do no harm") {
  Rig rig;
  rig.body.set_options(rig.options);
  for (std::size_t i = 0; i < 3 * EventSchedule::kMaxScheduled; ++i)
    rig.body.schedule(rig.at(kPoint, 0.1), static_cast<std::int64_t>(i));
  // fewer triangles than the strikes were meant for
  rig.exchange(std::make_shared<const LoadedTable>(plate(0.3, 0.2, 0.005, 5000, 4, 4)));
  const Output output = rig.run(4800, 100);
  CHECK(impulse(output) > 0);
  CHECK(is_finite(output.left));
}
