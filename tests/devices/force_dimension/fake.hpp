#pragma once

#include "core/haptic/device/device.hpp"
#include "tests/devices/vendor_library.hpp"

#include <array>
#include <utility>

/// The stand-in for the vendor's library, with its hooks, and what every test does with a device.
namespace tactus {

using haptic::State;

struct Fake : VendorLibrary {
  static constexpr const char *kDriver = "dhd", *kPathVariable = "TACTUS_LIBDHD";
  static std::unique_ptr<haptic::Backend> make() { return devices::find_driver(kDriver)->make(); }

  explicit Fake(const char* mode = "", const char* path = FAKE_DHD)
      : VendorLibrary(kPathVariable, path, "FAKE_DHD", mode) {}
  Vec3 force() const {
    double f[3] = {};
    force_of(f);
    return {f[0], f[1], f[2]};
  }
  /// Torque, gripper force; how many calls had them.
  std::pair<std::array<double, 4>, int> wrist() const {
    std::array<double, 4> all{};
    const int calls = wrist_of(all.data());
    return {all, calls};
  }
  std::array<int, 4> counts() const {
    std::array<int, 4> all{};
    counts_of(all.data());
    return all;
  }
  /// Calls of dhdOpenID and of dhdGetStatus so far.
  std::array<int, 2> calls() const {
    std::array<int, 2> all{};
    calls_of(all.data());
    return all;
  }
  void (*set_position)(double, double,
                       double) = hook<void(double, double, double)>("fake_dhd_set_position");
  void (*switch_off)(int) = hook<void(int)>("fake_dhd_switch_off");
  void (*switch_on)() = hook<void()>("fake_dhd_switch_on");
  void (*set)(int, int, int, unsigned) = hook<void(int, int, int, unsigned)>("fake_dhd_set");
  void (*force_of)(double*) = hook<void(double*)>("fake_dhd_force");
  void (*counts_of)(int*) = hook<void(int*)>("fake_dhd_counts");
  double (*max_force)() = hook<double()>("fake_dhd_max_force");
  int (*device_counts)() = hook<int()>("fake_dhd_device_counts");
  int (*wrist_of)(double*) = hook<int(double*)>("fake_dhd_wrist");
  void (*gap)(double) = hook<void(double)>("fake_dhd_gap");
  void (*break_down)(int) = hook<void(int)>("fake_dhd_break");
  void (*calls_of)(int*) = hook<void(int*)>("fake_dhd_calls");
};

using Opened = OpenedOn<Fake>;

inline auto make() { return Fake::make(); }

/// Ticks of a servo that always asks for this force.
inline State drive(haptic::Backend& device, const Vec3& force, int ticks) {
  State state;
  for (int i = 0; i < ticks; ++i) {
    const auto index = static_cast<std::uint64_t>(i);
    CHECK(device.read({index, 1e-3 * i, 1e-3}, state));
    static_cast<void>(device.write(force));
  }
  return state;
}

} // namespace tactus
