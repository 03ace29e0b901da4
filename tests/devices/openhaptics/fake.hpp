#pragma once

#include "core/haptic/servo/servo.hpp"
#include "devices/servo_thread.hpp"
#include "tests/devices/vendor_library.hpp"

#include <array>
#include <thread>

/// The stand-in for the vendor's library, with its hooks, and what every test does with a device.
namespace tactus {

/// The stand-in library, with its hooks.
struct Fake : VendorLibrary {
  static constexpr const char *kDriver = "openhaptics", *kPathVariable = "PHANTOM_LIBHD";
  static std::unique_ptr<haptic::Backend> make() { return devices::find_driver(kDriver)->make(); }

  explicit Fake(const char* mode = "") : VendorLibrary(kPathVariable, FAKE_HD, "FAKE_HD", mode) {
    hook<void()>("fake_hd_reset")(); // the library stays loaded, with its state
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
  Vec3 force() const {
    double f[3] = {};
    force_of(f);
    return {f[0], f[1], f[2]};
  }
  void (*fail)(unsigned) = hook<void(unsigned)>("fake_hd_fail");
  void (*press)(int) = hook<void(int)>("fake_hd_press");
  void (*counts_of)(unsigned long*) = hook<void(unsigned long*)>("fake_hd_counts");
  void (*force_of)(double*) = hook<void(double*)>("fake_hd_last_force");
  int (*torque_of)(double*) = hook<int(double*)>("fake_hd_torque");
  void (*set_position)(double, double,
                       double) = hook<void(double, double, double)>("fake_hd_set_position");
  void (*styles)(int) = hook<void(int)>("fake_hd_styles");
  void (*calibration)(int) = hook<void(int)>("fake_hd_calibration");
  void (*more_counts_of)(int*) = hook<void(int*)>("fake_hd_more_counts");
};

using Opened = OpenedOn<Fake>;

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
  void ask(const Vec3& force) {
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

inline auto make() { return Fake::make(); }

} // namespace tactus
