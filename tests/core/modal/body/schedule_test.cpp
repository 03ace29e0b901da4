// Blows, points and silence at their own samples.
#include "core/modal/body/timed_queue.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;

namespace {

Hit at(const Rig& rig, Vec3 position, double speed = 1) {
  const SurfacePoint point = rig.body.model()->nearest(position);
  return {point, point.normal, speed};
}

/// Samples at which a force begins.
std::vector<std::size_t> onsets(const std::vector<float>& contact) {
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < contact.size(); ++n)
    if (contact[n] > 0 && (n == 0 || contact[n - 1] == 0))
      found.push_back(n);
  return found;
}

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
  const auto play = [](std::size_t block) {
    Rig rig;
    rig.body.set_options(rig.options);
    rig.body.set_striker({0.001, 0.003, 206e9, 0.29, 0, 1.5, 0, 1});
    for (const std::int64_t sample : {5000, 350, 351, 2003, 640})
      rig.body.schedule_hit(at(rig, {0.05, 0.03, 0}), sample);
    return rig.run(8192, block);
  };
  const Output reference = play(64);
  const auto start_sample = onsets(reference.contact);
  for (const std::size_t sample : {350UL, 640UL, 2003UL, 5000UL})
    CHECK(std::count(start_sample.begin(), start_sample.end(), sample) == 1);
  for (const std::size_t block : {1UL, 7UL, 100UL, 4096UL}) {
    const Output other = play(block);
    CHECK(other.left == reference.left);
    CHECK(other.contact == reference.contact);
  }
}

TEST_CASE("a scheduled strike uses the striker and the clock of its message") {
  Rig rig;
  rig.body.set_options(rig.options);
  rig.body.begin_block(1000000);
  rig.body.set_striker({0.001, 0.003, 206e9, 0.29, 0, 1.5, 0, 1});
  rig.body.schedule_hit(at(rig, {0.05, 0.03, 0}), 1000100);
  rig.body.set_striker({0.1, 0.003, 206e9, 0.29, 0, 1.5, 0, 1}); // of a later strike
  const Output output = rig.run(2400);
  CHECK(onsets(output.contact).front() == 100);
  CHECK(impulse(output, 48000) < 2 * 0.001);
  // Pd's first long block begins before time 0.
  rig.body.begin_block(-4000);
  rig.body.schedule_hit(at(rig, {0.05, 0.03, 0}), 50);
  CHECK(onsets(rig.run(4096).contact).front() == 4050);
  // What is late happens at once.
  rig.body.schedule_hit(at(rig, {0.05, 0.03, 0}), 3);
  CHECK(onsets(rig.run(2400).contact).front() == 0);
}

TEST_CASE("the point moves, and the body is silenced, at the sample that was asked for") {
  const auto play = [](std::size_t block) {
    Rig rig;
    const SurfacePoint a = rig.body.model()->nearest({0.05, 0.03, 0}),
                       b = rig.body.model()->nearest({-0.1, 0.01, 0});
    rig.body.set_point(a, a.normal);
    rig.body.schedule_point(b, b.normal, 1234);
    CHECK(rig.body.point().position == b.position);
    rig.body.schedule_reset(3000);
    return rig.run(6000, block, std::vector<float>(2000, 1.0F)).left;
  };
  const auto reference = play(64);
  for (const std::size_t block : {1UL, 100UL, 6000UL})
    CHECK(play(block) == reference);
  Rig still;
  const SurfacePoint a = still.body.model()->nearest({0.05, 0.03, 0});
  still.body.set_point(a, a.normal);
  const auto same = still.run(6000, 64, std::vector<float>(2000, 1.0F)).left;
  CHECK(std::equal(same.begin(), same.begin() + 1234, reference.begin()));
  CHECK(!std::equal(same.begin() + 1234, same.begin() + 1300, reference.begin() + 1234));
  const auto silent = 3000 + static_cast<std::ptrdiff_t>(ModeBank::kRelease);
  CHECK(std::all_of(reference.begin() + silent + 100, reference.end(),
                    [](float x) { return x == 0; }));
}

TEST_CASE("more events than the queue holds, and an exchanged body, do no harm") {
  Rig rig;
  rig.body.set_options(rig.options);
  for (std::size_t i = 0; i < 3 * StruckBody::kMaxScheduled; ++i)
    rig.body.schedule_hit(at(rig, {0.05, 0.03, 0}, 0.1), static_cast<std::int64_t>(i));
  rig.loaded = std::make_shared<const LoadedTable>(plate(0.3, 0.2, 0.005, 5000, 4, 4));
  rig.rebuild(false); // fewer triangles than the strikes were meant for
  const Output output = rig.run(4800, 100);
  CHECK(impulse(output, 48000) > 0);
  for (const float x : output.left)
    CHECK(std::isfinite(x));
}

TEST_CASE("a pulse under way goes on when a listener moves") {
  const auto play = [](bool moves) {
    Rig rig;
    rig.options.coupled = false;
    rig.body.set_striker({0.05, 0.02, 1e6, 0.49, 1e5, 1.5, 0, 1}); // milliseconds long
    rig.hit({0.05, 0.03, 0}, 0.5);
    Output output = rig.run(64);
    if (moves) {
      rig.settings.listener[1] = {0, 0, 0.3};
      rig.rebuild();
    }
    const Output rest = rig.run(4800);
    output.left.insert(output.left.end(), rest.left.begin(), rest.left.end());
    return output.left;
  };
  const auto a = play(false), b = play(true);
  float loudest = 0, difference = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    loudest = std::max(loudest, std::abs(a[n]));
    difference = std::max(difference, std::abs(a[n] - b[n]));
  }
  CHECK(difference < 1e-4F * loudest);
}

TEST_CASE("many strikes at once on a large body are one contact and pulses") {
  ModalTable table;
  table.free = false;
  table.material = {"", 70e9, 0.3, 2700};
  for (std::size_t k = 0; k < 10000; ++k) {
    table.frequency_hz.push_back(50 + 2 * static_cast<double>(k));
    table.decay_rate.push_back(5);
  }
  const auto play = [&](std::size_t strikes, std::size_t block) {
    Rig rig(48000, table);
    rig.body.set_striker({1e-5, 0.002, 1e7, 0.3, 0, 1.5, 0, 1}); // light and soft
    for (std::size_t i = 0; i < strikes; ++i)
      rig.hit({}, 0.1);
    const Output output = rig.run(960, block);
    CHECK(rig.body.contacts() == 0);
    return output;
  };
  const Output one = play(1, 64), two = play(2, 64);
  // The second is struck as on a body at rest: twice the impulse and the sound, as the light
  // striker gives way so little.
  CHECK(std::abs(impulse(two, 48000) / impulse(one, 48000) - 2) < 0.06);
  double a = 0, b = 0;
  for (std::size_t n = 200; n < 960; ++n) {
    a += std::pow(static_cast<double>(one.left[n]), 2);
    b += std::pow(static_cast<double>(two.left[n]), 2);
  }
  CHECK(10 * std::log10(b / a) == approx(6.02).epsilon(0.05));
  for (const std::size_t block : {1UL, 50UL, 960UL})
    CHECK(play(2, block).left == two.left);
}
