#pragma once

#include "core/haptic/servo/servo.hpp"
#include "tests/approx.hpp"

#include <vector>

namespace tactus::haptic::test {

using tactus::test::approx;

/// A device that reads what the test says and keeps what it is sent.
struct Recorder final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return given; }
  bool read(const Tick& tick, State& state) noexcept override {
    ticks.push_back(tick);
    state = reading;
    return readable;
  }
  bool write(const Vec3& force_n) noexcept override {
    forces.push_back(force_n);
    wrist = next_wrist_;
    next_wrist_ = {};
    return writable;
  }
  void set_wrist(const WristCommand& command) noexcept override {
    next_wrist_ = command;
    ++wrist_requests;
  }
  Caps given{};
  State reading{};
  bool readable = true, writable = true;
  std::vector<Tick> ticks;
  std::vector<Vec3> forces;
  WristCommand wrist{}; ///< of the last write
  int wrist_requests = 0;

private:
  WristCommand next_wrist_{};
};

inline ChainSettings without_passivity() {
  ChainSettings settings;
  settings.passivity = false;
  return settings;
}

/// A servo at 1 kHz under a host that beats, and asks for a force, at every tick.
template <class Device> struct HostedServo {
  Device device;
  Servo servo;
  std::uint64_t tick = 0, number = 0;

  explicit HostedServo(const ChainSettings& chain = {}) { set(chain); }
  void set(const ChainSettings& chain) { servo.exchange().settings.write({chain, {}}); }
  void attach(LocalModel* model = nullptr) { servo.attach(device, model); }
  void step(const Vec3& force_n) {
    const double now_s = static_cast<double>(tick) * 1e-3;
    servo.exchange().commands.write({force_n, ++number, 0, false, now_s});
    servo.step({tick++, now_s, 1e-3});
  }
  void run(int ticks, const Vec3& force_n) {
    for (; ticks > 0; --ticks)
      step(force_n);
  }
  const Report& report() {
    servo.exchange().reports.read();
    return servo.exchange().reports.latest();
  }
};

} // namespace tactus::haptic::test
