#include "core/haptic/servo/servo.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace tactus::haptic;

namespace {

/// A device whose reading the test says, and which keeps what it was sent.
struct ScriptedDevice final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return {}; }
  bool read(const Tick&, State& state) noexcept override {
    state.position = position;
    reject_unreachable(caps(), state, last_good);
    return true;
  }
  bool write(const Vec3& force_n) noexcept override {
    force = force_n;
    return true;
  }
  Vec3 position{}, last_good{}, force{};
};

} // namespace

TEST_CASE("an unreachable position becomes the last good one and is flagged") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Caps caps; // 50 mm either way: 87 mm to a corner
  Vec3 last_good{};
  const auto flags = [&](const Vec3& position) {
    State state;
    state.position = position;
    state.velocity = {1, 1, 1};
    reject_unreachable(caps, state, last_good);
    CHECK(state.position == last_good);
    return state.flags;
  };
  CHECK(flags({0.01, 0.02, 0.03}) == State::kHomed);
  CHECK(flags({0.34, 0, 0}) == State::kHomed); // outside of the box, within reach
  for (const Vec3& wrong : {Vec3{kNaN, 0, 0}, Vec3{0, kInfinite, 0}, Vec3{0, 0, -kInfinite},
                            Vec3{0.36, 0, 0}, Vec3{1e300, 1e300, 1e300}}) {
    CHECK(flags(wrong) == (State::kHomed | State::kUnreachable));
    CHECK(last_good == Vec3{0.34, 0, 0});
  }
}

TEST_CASE(
    "an unreachable reading takes the force away at that tick; it returns over the enable time") {
  ScriptedDevice device;
  Servo servo;
  servo.attach(device);
  ServoSettings settings;
  settings.chain.passivity = false;
  servo.exchange().settings.write(settings);
  std::uint64_t index = 0;
  const auto tick = [&](int count) {
    for (int i = 0; i < count; ++i, ++index) {
      Command command;
      command.force_n = {2, 0, 0};
      command.number = index + 1;
      command.heartbeat_s = 1e-3 * static_cast<double>(index);
      servo.exchange().commands.write(command);
      servo.step({index, 1e-3 * static_cast<double>(index), 1e-3});
    }
  };
  tick(1000);
  CHECK(device.force.x == doctest::Approx(2));
  device.position = {NAN, 0, 0};
  tick(1);
  CHECK(device.force == Vec3{});
  tick(10);
  CHECK(device.force == Vec3{});
  device.position = {};
  tick(1);
  CHECK(device.force.x < 0.05);
  tick(250);
  CHECK(device.force.x == doctest::Approx(1).epsilon(0.02));
  tick(300);
  CHECK(device.force.x == doctest::Approx(2));
}
