#pragma once

#include "core/haptic/servo/servo.hpp"
#include "devices/driver.hpp"
#include "devices/servo_thread.hpp"
#include "devices/shared_library.hpp"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <thread>

/// The stand-in for the vendor's library, with its hooks, and what every test does with a device.
namespace tactus {

/// The stand-in library, with its hooks; loaded beside the driver, so it is the same one.
struct Fake {
  explicit Fake(const char* mode = "") {
    setenv("PHANTOM_LIBHD", FAKE_HD, 1);
    setenv("FAKE_HD", mode, 1);
    const char* const name = FAKE_HD;
    REQUIRE(library.load({&name, 1}));
    REQUIRE(library.symbol("fake_hd_fail", fail));
    REQUIRE(library.symbol("fake_hd_press", press));
    REQUIRE(library.symbol("fake_hd_counts", counts_of));
    REQUIRE(library.symbol("fake_hd_last_force", force_of));
    REQUIRE(library.symbol("fake_hd_torque", torque_of));
    REQUIRE(library.symbol("fake_hd_set_position", set_position));
    REQUIRE(library.symbol("fake_hd_calibration", calibration));
    REQUIRE(library.symbol("fake_hd_more_counts", more_counts_of));
    void (*reset)() = nullptr;
    REQUIRE(library.symbol("fake_hd_reset", reset));
    reset(); // the library stays loaded, with its state
  }
  std::array<unsigned long, 6> counts() const {
    std::array<unsigned long, 6> all{};
    counts_of(all.data());
    return all;
  }
  struct More {
    int ramping, rate_hz, openings, calibration_checks, calibration_style;
  };
  More more() const {
    int all[5] = {};
    more_counts_of(all);
    return {all[0], all[1], all[2], all[3], all[4]};
  }
  haptic::Vec3 force() const {
    double f[3] = {};
    force_of(f);
    return {f[0], f[1], f[2]};
  }
  devices::SharedLibrary library;
  void (*fail)(unsigned) = nullptr;
  void (*press)(int) = nullptr;
  void (*counts_of)(unsigned long*) = nullptr;
  void (*force_of)(double*) = nullptr;
  int (*torque_of)(double*) = nullptr;
  void (*set_position)(double, double, double) = nullptr;
  void (*calibration)(int) = nullptr;
  void (*more_counts_of)(int*) = nullptr;
};

/// The servo as the host hangs it into the device's own thread.
struct Session {
  explicit Session(haptic::Backend& backend) : device(backend) {
    servo.attach(device);
    haptic::ServoSettings settings;
    settings.chain.enable_s = 0;
    settings.chain.passivity = false;
    servo.exchange().settings.write(settings);
    REQUIRE(device.run(
        [](void* self) {
          auto& session = *static_cast<Session*>(self);
          session.servo.step({session.ticks, 1e-3 * static_cast<double>(session.ticks), 1e-3});
          ++session.ticks;
        },
        this));
  }
  ~Session() { device.halt(); }
  void ask(const haptic::Vec3& force) {
    haptic::Command command;
    command.force_n = force;
    command.number = ++number;
    command.heartbeat_s = 1e9; // tests of the watchdog are elsewhere
    servo.exchange().commands.write(command);
  }
  /// Waits for so many ticks of the device's thread, a minute at most.
  haptic::Report after(unsigned long more) {
    servo.exchange().reports.read();
    const auto until = servo.exchange().reports.latest().tick.index + more;
    for (int i = 0; i < 60000; ++i) {
      servo.exchange().reports.read();
      if (servo.exchange().reports.latest().tick.index >= until)
        break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return servo.exchange().reports.latest();
  }
  haptic::Backend& device;
  haptic::Servo servo;
  std::uint64_t ticks = 0, number = 0;
};

inline std::unique_ptr<haptic::Backend> make() {
  const devices::Driver* driver = devices::find_driver("openhaptics");
  REQUIRE(driver != nullptr);
  return driver->make();
}

} // namespace tactus
