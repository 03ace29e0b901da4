#pragma once

#include "devices/driver.hpp"
#include "devices/hid/hid.hpp"
#include "tests/devices/mock/control.hpp"

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

/// The HID driver in front of the double that this program runs in, stepped in real time.
struct Rig {
  tactus::mock::Control control;
  tactus::devices::hid::Hid device;
  tactus::haptic::State state{};
  tactus::haptic::Tick tick{};

  Rig() {
    if (!control.present())
      return;
    control.ask("plug");
    static_cast<void>(set({"transport", world("TRANSPORT")}));
  }

  static std::string world(const char* what) {
    const char* value = std::getenv((std::string("TACTUS_DOUBLE_") + what).c_str());
    return value ? value : "";
  }
  static bool is(const char* kind) { return world("KIND") == kind; }
  std::string set(std::vector<std::string> words) { return device.configure(words); }

  bool step(const tactus::Vec3& force = {}) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++tick.index;
    tick.time_s = static_cast<double>(tick.index) * 1e-3;
    const bool well = device.read(tick, state);
    return device.write(force) && well;
  }
  /// Steps until the condition holds; false when it does not within so many ticks.
  template <class Condition> bool until(Condition condition, int ticks = 30000) {
    for (int i = 0; i < ticks; ++i) {
      step();
      if (condition())
        return true;
    }
    return false;
  }
  bool reaches(const tactus::Vec3& position_mm, int ticks = 30000) {
    return until([&] { return norm(state.position * 1e3 - position_mm) < 1e-6; }, ticks);
  }
  /// Sends reports until the condition holds: on a busy machine the double may lose one.
  template <class Condition>
  bool sent(const std::vector<std::string>& reports, Condition condition) {
    for (int tries = 0; tries < 10; ++tries) {
      for (const std::string& report : reports)
        control.ask(report.c_str());
      if (until(condition, 300))
        return true;
    }
    return false;
  }
  bool moves_to(const tactus::Vec3& position_mm, const std::string& report) {
    return sent({report}, [&] { return norm(state.position * 1e3 - position_mm) < 1e-6; });
  }
};
