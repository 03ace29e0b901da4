#pragma once

#include "devices/driver.hpp"
#include "devices/falcon/falcon.hpp"
#include "tests/devices/mock/control.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

/// A Falcon of our driver in front of the double, stepped in real time.
struct Rig {
  tactus::mock::Control control;
  tactus::devices::falcon::Falcon falcon;
  tactus::haptic::State state{};
  tactus::haptic::Tick tick{};
  int failed_reads = 0, failed_writes = 0;
  double gap_s = 0; ///< since the last read that went well

  Rig() {
    if (control.present())
      control.ask("plug");
  }
  ~Rig() {
    falcon.close();
    std::remove(file.c_str());
  }

  std::string set(std::vector<std::string> words) { return falcon.configure(words); }

  /// Opens with a firmware of so many arbitrary bytes.
  std::string open(std::size_t bytes = 500) {
    std::ofstream out(file, std::ios::binary);
    for (std::size_t i = 0; i < bytes; ++i)
      out.put(static_cast<char>(i * i * 7 + i));
    out.close();
    static_cast<void>(set({"firmware", file}));
    return falcon.open();
  }

  /// One servo tick: read, then write.
  bool step(const tactus::Vec3& force = {}) {
    using Clock = std::chrono::steady_clock;
    next =
        std::max(next + std::chrono::milliseconds(1), Clock::now() - std::chrono::milliseconds(3));
    std::this_thread::sleep_until(next);
    ++tick.index;
    tick.time_s = now_s();
    const bool well = falcon.read(tick, state);
    well_s = well ? tick.time_s : well_s;
    gap_s = tick.time_s - well_s;
    failed_reads += !well;
    failed_writes += !falcon.write(force);
    return well;
  }
  [[nodiscard]] static double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  void run(int ticks, const tactus::Vec3& force = {}) {
    for (int i = 0; i < ticks; ++i)
      step(force);
  }
  /// Steps until the condition holds; false when it does not within so many ticks, of which a busy
  /// machine may give the double few.
  template <class Condition>
  bool until(Condition condition, int ticks = 30000, const tactus::Vec3& force = {}) {
    for (int i = 0; i < ticks; ++i) {
      step(force);
      if (condition())
        return true;
    }
    return false;
  }
  /// Steps until the hand has moved less than 0.1 mm in 200 ticks.
  bool settle(const tactus::Vec3& force = {}) {
    return until(
        [this, last = state.position, held = 0]() mutable {
          if (norm(state.position - last) > 1e-4) {
            last = state.position;
            held = 0;
          }
          return ++held > 200;
        },
        30000, force);
  }
  [[nodiscard]] bool homed() const { return (state.flags & tactus::haptic::State::kHomed) != 0; }
  bool home() {
    return until([this] { return homed(); });
  }
  /// Opened and homed; with `still` the hand's intention stands at the centre.
  void ready(bool still = false) {
    if (still)
      control.ask("still");
    REQUIRE(open() == "");
    REQUIRE(home());
  }
  [[nodiscard]] bool unreachable() const {
    return (state.flags & tactus::haptic::State::kUnreachable) != 0;
  }
  /// No motor has force, soon, though nobody reads or writes any more.
  [[nodiscard]] bool falls_still() const {
    for (int i = 0; i < 500; ++i) {
      if (saw("motor0=0") && saw("motor1=0") && saw("motor2=0"))
        return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  /// The double's state holds this "name=value".
  [[nodiscard]] bool saw(const std::string& pair) const {
    return (" " + control.ask("state") + " ").find(" " + pair + " ") != std::string::npos;
  }
  [[nodiscard]] bool says(const std::string& word) const {
    return falcon.trouble().find(word) != std::string::npos;
  }

private:
  std::string file = "falcon_firmware_" + std::to_string(getpid()) + ".bin";
  std::chrono::steady_clock::time_point next = std::chrono::steady_clock::now();
  double well_s = 0;
};
