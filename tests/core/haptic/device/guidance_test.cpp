#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/servo/servo.hpp"

#include "tests/core/haptic/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <utility>

using namespace tactus::haptic;

namespace {

/// A patch pulls a person's hand towards a goal 20 mm away, with stiffness k; returns how far from
/// the goal the handle still is after that time, and the RMS of its last second.
std::pair<double, double> distance_after(double seconds, double k, HandSettings hand) {
  SimulatedDevice device;
  SimulatedDevice::Settings simulation;
  hand.hold = HandSettings::Hold::kPerson;
  simulation.hand = hand;
  device.set(simulation);
  Servo servo;
  ServoSettings settings;
  settings.chain.allowance_w = 0.05;
  servo.exchange().settings.write(settings);
  servo.attach(device);
  const Vec3 goal{0.02, 0, 0};
  double square = 0;
  const auto ticks = static_cast<std::uint64_t>(seconds * 1e3);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const double now = static_cast<double>(tick) * 1e-3;
    Command command;
    command.force_n = (goal - device.position()) * k;
    command.number = tick + 1;
    command.heartbeat_s = now;
    servo.exchange().commands.write(command);
    servo.step({tick, now, 1e-3});
    const Vec3 off = device.position() - goal;
    if (tick + 1000 >= ticks)
      square += dot(off, off) * 1e-3;
  }
  return {norm(device.position() - goal), std::sqrt(square)};
}

} // namespace

TEST_CASE("a steady hand is guided to the goal at the rate of its yielding") {
  // In balance K (x - x_h) = k (goal - x), and the intention moves at (x - x_h)/tau: the distance
  // falls as exp(-t k/((K + k) tau)), here exp(-t/6 s), from 20 K/(K + k) = 16.7 mm on.
  HandSettings steady;
  steady.tremor_m = steady.wander_m = 0;
  const double at_6 = distance_after(6, 40, steady).first;
  const double at_12 = distance_after(12, 40, steady).first;
  MESSAGE("distance after 6 and 12 s: " << at_6 * 1e3 << ", " << at_12 * 1e3 << " mm");
  CHECK(at_6 == test::approx(0.02 * 200 / 240 * std::exp(-1.0)).epsilon(0.03));
  CHECK(at_12 / at_6 == doctest::Approx(std::exp(-1.0)).epsilon(0.01));
}

TEST_CASE("a hand with tremor and wander is guided there too, and stays away without a force") {
  const HandSettings person;
  const double guided_distance = distance_after(30, 40, person).second;
  const double alone = distance_after(30, 0, person).second;
  MESSAGE("last second of 30, RMS distance from the goal: led "
          << guided_distance * 1e3 << ", alone " << alone * 1e3 << " mm");
  CHECK(guided_distance < 4e-3);
  CHECK(alone > 15e-3);
}
