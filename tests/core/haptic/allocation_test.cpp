#include "core/haptic/servo.hpp"
#include "core/haptic/simulated_device.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1))
    return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace tactus::haptic;

TEST_CASE("ten thousand servo ticks allocate nothing, whatever hand and orders") {
  const long none = allocations;
  CHECK(std::make_unique<int>(1) != nullptr);
  CHECK(allocations == none + 1); // the counter counts

  SimulatedDevice device;
  SimulatedDevice::Settings simulation;
  simulation.noise_m = 1e-5;
  Servo servo;
  device.set(simulation);
  servo.attach(device);
  servo.exchange().tracing = true;
  for (const auto hold : {HandSettings::Hold::kFree, HandSettings::Hold::kRigid,
                          HandSettings::Hold::kSpring, HandSettings::Hold::kPerson}) {
    simulation.hand.hold = hold;
    device.set(simulation);
    const long before = allocations;
    for (std::uint64_t k = 0; k < 2500; ++k) {
      Command command;
      command.force_n = {1, 2, 3};
      command.number = k + 1;
      command.heartbeat_s = static_cast<double>(k) * 1e-3;
      servo.exchange().commands.write(command);
      servo.exchange().settings.write({});
      servo.exchange().actions.push(k % 2 ? Action::kMotorsOn : Action::kEmergencyStop);
      device.press(1, k % 3 == 0);
      servo.step({k, command.heartbeat_s, 1e-3});
    }
    CHECK(allocations == before);
  }
}
