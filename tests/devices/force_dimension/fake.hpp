#pragma once

#include "core/haptic/device/device.hpp"
#include "devices/driver.hpp"
#include "devices/shared_library.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <utility>

/// The stand-in for the vendor's library, with its hooks, and what every test does with a device.
namespace tactus {

using haptic::State;
using haptic::Vec3;

struct Fake {
  explicit Fake(const char* mode = "") {
    setenv("TACTUS_LIBDHD", FAKE_DHD, 1);
    setenv("FAKE_DHD", mode, 1);
    const char* const name = FAKE_DHD;
    REQUIRE(library.load({&name, 1}));
    REQUIRE(library.symbol("fake_dhd_set_position", set_position));
    REQUIRE(library.symbol("fake_dhd_switch_off", switch_off));
    REQUIRE(library.symbol("fake_dhd_switch_on", switch_on));
    REQUIRE(library.symbol("fake_dhd_set", set));
    REQUIRE(library.symbol("fake_dhd_force", force_of));
    REQUIRE(library.symbol("fake_dhd_counts", counts_of));
    REQUIRE(library.symbol("fake_dhd_max_force", max_force));
    REQUIRE(library.symbol("fake_dhd_device_counts", device_counts));
    REQUIRE(library.symbol("fake_dhd_wrist", wrist_of));
    REQUIRE(library.symbol("fake_dhd_gap", gap));
    REQUIRE(library.symbol("fake_dhd_break", break_down));
    REQUIRE(library.symbol("fake_dhd_calls", calls_of));
  }
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
  devices::SharedLibrary library;
  void (*set_position)(double, double, double) = nullptr;
  void (*switch_off)(int) = nullptr;
  void (*switch_on)() = nullptr;
  void (*set)(int, int, int, unsigned) = nullptr;
  void (*force_of)(double*) = nullptr;
  void (*counts_of)(int*) = nullptr;
  double (*max_force)() = nullptr;
  int (*device_counts)() = nullptr;
  int (*wrist_of)(double*) = nullptr;
  void (*gap)(double) = nullptr;
  void (*break_down)(int) = nullptr;
  void (*calls_of)(int*) = nullptr;
};

inline std::unique_ptr<haptic::Backend> make() {
  const devices::Driver* driver = devices::find_driver("dhd");
  REQUIRE(driver != nullptr);
  return driver->make();
}

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
