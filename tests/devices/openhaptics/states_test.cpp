#include "devices/openhaptics/hd_library.hpp"
#include "tests/devices/openhaptics/fake.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

// What the library reports, tick by tick, and what the driver does about it.

using namespace tactus;
using namespace tactus::devices::openhaptics;
using haptic::State;

namespace {

/// Ticks in the device's own thread: what `each` says of a tick's number happens between read and
/// write, and is the force.
struct ScriptedRun {
  ScriptedRun(const Fake& of, haptic::Backend& backend, int count, std::function<Vec3(int)> each)
      : fake(of), device(backend), act(std::move(each)), left(count) {
    REQUIRE(device.run([](void* self) { static_cast<ScriptedRun*>(self)->tick(); }, this));
    for (int i = 0; i < 60000 && left > 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    REQUIRE(left == 0);
    device.halt();
  }
  void tick() {
    if (left == 0)
      return;
    State state;
    answered.push_back(device.read({}, state));
    states.push_back(state);
    sent.push_back(fake.force()); // of the tick before
    const Vec3 force = act(static_cast<int>(states.size()) - 1);
    taken.push_back(device.write(force));
    --left;
  }
  /// Ticks whose state has this flag: first, last and how many.
  struct Span {
    int first, last, count;
  };
  [[nodiscard]] Span with(std::uint32_t flag) const {
    Span span{-1, -1, 0};
    for (int i = 0; i < static_cast<int>(states.size()); ++i)
      if (states[static_cast<std::size_t>(i)].flags & flag) {
        span.first = span.first < 0 ? i : span.first;
        span.last = i;
        ++span.count;
      }
    return span;
  }
  const Fake& fake;
  haptic::Backend& device;
  std::function<Vec3(int)> act;
  std::atomic<int> left;
  std::vector<State> states;
  std::vector<bool> answered, taken;
  std::vector<Vec3> sent;
};

} // namespace

TEST_CASE("a velocity is the position's change, and a position out of reach is the last good one") {
  const Fake fake("quick");
  const auto device = make();
  REQUIRE(device->open() == "");
  const ScriptedRun r(fake, *device, 300, [&](int tick) {
    if (tick == 250)
      fake.set_position(0, 5000, 0);
    return tick > 100 ? Vec3{0, 0, 0.3} : Vec3{};
  });
  const double change_m = r.states[201].position.z - r.states[200].position.z;
  CHECK(r.states[200].velocity.z == doctest::Approx(change_m / 1e-3).epsilon(0.05));
  CHECK(r.states[200].velocity.z > 0.05);
  CHECK(norm(r.states[299].position - r.states[250].position) < 1e-2);
  const auto lost = r.with(State::kUnreachable);
  CHECK(lost.first == 251);
  CHECK(lost.last == 299);
}

TEST_CASE(
    "the calibration is looked at in the first tick and every 256, and asked for in its style") {
  const Fake fake("quick");
  const auto device = make();
  REQUIRE(device->open() == "");
  std::vector<int> checks;
  const ScriptedRun r(fake, *device, 520, [&](int) {
    checks.push_back(fake.more().calibration_checks);
    return Vec3{1, 0, 0};
  });
  CHECK(checks[0] == 2); // it needed an update and was looked at again
  CHECK(checks[255] == 2);
  CHECK(checks[256] == 3);
  CHECK(checks[512] == 4);
  CHECK(fake.counts()[5] == 1);
  CHECK(fake.more().calibration_style == 2);
  CHECK(r.with(State::kHomed).count == 520);
}

TEST_CASE("no force while the calibration needs the library or the hand, each with its sentence") {
  std::set<std::string> sentences;
  for (const int answer : {0x5001, 0x5002}) {
    const Fake fake("quick");
    const auto device = make();
    REQUIRE(device->open() == "");
    fake.calibration(answer);
    CHECK(device->trouble() == ""); // not yet looked at
    std::string sentence;
    const ScriptedRun r(fake, *device, 20, [&](int tick) {
      if (tick == 10)
        sentence = device->trouble();
      return Vec3{1, 0, 0};
    });
    CHECK(sentences.insert(sentence).second);
    CHECK(sentence.find(answer == 0x5001 ? "calibrating itself" : "inkwell") != std::string::npos);
    CHECK(r.with(State::kHomed).count == 0);
    CHECK(fake.force() == Vec3{});
    CHECK(device->trouble() == ""); // halted
  }
}

TEST_CASE("the calibration is updated in one style: automatic, else the inkwell, else by hand") {
  for (const auto& [known, chosen] : {std::pair{7, 2}, {6, 2}, {5, 4}, {4, 4}, {3, 2}, {1, -1}}) {
    const int styles = known; // a binding is not captured
    CAPTURE(styles);
    const Fake fake("quick");
    const auto device = make();
    REQUIRE(device->open() == "");
    fake.styles(styles);
    if (chosen < 0)
      fake.calibration(0x5001);
    std::string sentence;
    const ScriptedRun r(fake, *device, 20, [&](int tick) {
      if (tick == 10)
        sentence = device->trouble();
      return Vec3{};
    });
    CHECK(fake.more().calibration_style == chosen);
    CHECK(sentence.find(chosen < 0 ? "reset position and send home" : "") != std::string::npos);
    if (chosen >= 0)
      continue;
    const std::vector<std::string> home{"home"}; // the encoders, when the user says so
    REQUIRE(device->configure(home) == "");
    const ScriptedRun again(fake, *device, 5, [](int) { return Vec3{}; });
    CHECK(fake.more().calibration_style == 1);
  }
}

TEST_CASE("a calibration that is asked for takes the force away for a tick, and velocity for 50") {
  const Fake fake("quick");
  const auto device = make();
  REQUIRE(device->open() == "");
  const std::vector<std::string> home{"home"};
  const ScriptedRun r(fake, *device, 300, [&](int tick) {
    if (tick == 150)
      REQUIRE(device->configure(home) == "");
    return Vec3{0, 0, 0.2};
  });
  CHECK(r.with(State::kHomed).count == 299);
  CHECK((r.states[151].flags & State::kHomed) == 0);
  CHECK(r.sent[152] == Vec3{});
  CHECK(r.states[150].velocity.z > 0);
  CHECK(r.states[200].velocity == Vec3{});
  CHECK(r.states[202].velocity.z > 0);
}

TEST_CASE("half a second of warm motors lowers the limit of the force by a ramp") {
  const auto [fake, device] = Opened("held");
  Session session(*device);
  haptic::ServoSettings settings;
  settings.chain.enable_s = 0;
  settings.chain.force_limit_n = device->caps().peak_force_n; // 3.4, and 0.9 continuous
  settings.chain.passivity = false;
  session.servo.exchange().settings.write(settings);
  session.ask({3.4, 0, 0});
  session.after(50);
  fake.fail(kWarmMotors);
  double least = 3.4, largest_fall = 0, last = 3.4;
  for (int i = 0; i < 600; ++i) {
    const double force = norm(session.after(1).force_n);
    largest_fall = std::max(largest_fall, last - force);
    least = std::min(least, force);
    last = force;
  }
  CHECK(least == doctest::Approx(3.4 + 0.5 * (0.45 - 3.4)).epsilon(0.05));
  CHECK(largest_fall < 0.3); // of some ticks, where the machine stalls
}

TEST_CASE("too much force and warm motors are told for 500 ticks, and force goes on") {
  for (const auto& [answer, expected] :
       {std::pair{kTooMuchForce, State::kForceLimited}, {kWarmMotors, State::kMotorsHot}}) {
    const Code code = answer;
    CAPTURE(code);
    const Fake fake("quick");
    const auto device = make();
    REQUIRE(device->open() == "");
    std::string during, after;
    const ScriptedRun r(fake, *device, 700, [&](int tick) {
      if (tick == 50)
        fake.fail(code);
      if (tick == 500)
        during = device->trouble();
      if (tick == 600)
        after = device->trouble();
      return Vec3{0.1, 0, 0};
    });
    const auto reported = r.with(expected);
    CHECK(reported.first == 51);
    CHECK(reported.count == 500);
    CHECK(reported.last == 550);
    CHECK(during != "");
    CHECK(after == "");
    CHECK(r.with(State::kFault).count == 0);
    CHECK(r.sent[300] == Vec3{0.1, 0, 0});
  }
}

TEST_CASE("what switches force off keeps it off until none was asked for during 200 ticks") {
  for (const Code code :
       {kTooMuchImpulse, kTooMuchVelocity, kForceError, kDeviceFault, kNoAnswer}) {
    CAPTURE(code);
    const Fake fake("quick");
    const auto device = make();
    REQUIRE(device->open() == "");
    const ScriptedRun r(fake, *device, 500, [&](int tick) {
      if (tick == 20)
        fake.fail(code);
      return tick < 100 || tick > 400 ? Vec3{0.1, 0, 0} : Vec3{};
    });
    const auto off = r.with(State::kFault);
    CHECK(off.first == 21);
    CHECK(off.last == 299); // zero in ticks 100 to 299
    CHECK(off.count == 279);
    CHECK(r.sent[20] == Vec3{0.1, 0, 0});
    CHECK(r.sent[22] == Vec3{});
    CHECK(r.taken[20]);
    CHECK_FALSE(r.taken[50]);
    CHECK(r.taken[150]); // none is always taken
    CHECK(r.sent[450] == Vec3{0.1, 0, 0});
    CHECK(r.answered[50] == (code != kNoAnswer));
    CHECK(r.answered[350]);
    CHECK(fake.counts()[3] == 1);
  }
}

TEST_CASE("no more than the peak is sent, in the same direction, and no number is no force") {
  const auto [fake, device] = Opened();
  const double peak = device->caps().peak_force_n;
  const ScriptedRun r(fake, *device, 30, [](int tick) {
    return tick < 10 ? Vec3{30, 0, 40} : tick < 20 ? Vec3{0, NAN, 0} : Vec3{0, 1, 0};
  });
  CHECK(norm(r.sent[5] - Vec3{0.6, 0, 0.8} * peak) < 1e-12);
  CHECK(r.sent[15] == Vec3{});
  CHECK(r.sent[25] == Vec3{0, 1, 0});
}

TEST_CASE("every error has its own sentence, and one that nobody knows has its number") {
  std::set<std::string> sentences;
  for (const Code code :
       {Code(kWarmMotors), Code(kTooMuchForce), Code(kTooMuchImpulse), Code(kTooMuchVelocity),
        Code(kForceError), Code(kDeviceFault), Code(kAlreadyOpen), Code(kNoAnswer),
        Code(kWrongPort), Code(kTimerError), Code(kFrameError), Code(kNoLicence), Code(0x1A2B)}) {
    const Fake fake("quick");
    const auto device = make();
    REQUIRE(device->open() == "");
    std::string sentence;
    const ScriptedRun r(fake, *device, 5, [&](int tick) {
      if (tick == 1)
        fake.fail(code);
      if (tick == 3)
        sentence = device->trouble();
      return Vec3{};
    });
    CHECK(sentence.substr(0, 13) == "openhaptics: ");
    CHECK((sentence.find("0x1A2B") != std::string::npos) == (code == 0x1A2B));
    CHECK(sentences.insert(sentence).second);
  }
}

TEST_CASE("a name that is given and not there is no other device") {
  const Fake fake("second"); // opens as Default PHANToM alone
  const auto device = make();
  const std::vector<std::string> name{"device", "Left", "Device"};
  REQUIRE(device->configure(name) == "");
  const std::string sentence = device->open();
  CHECK(sentence.find("of the name Left Device:") != std::string::npos);
  CHECK(fake.more().openings == 3);
}

TEST_CASE("an opening tries every name three times, without a licence once") {
  for (const auto& [mode, openings] : {std::pair{"dead", 9}, {"licence", 3}}) {
    const Fake fake(mode);
    CHECK(make()->open() != "");
    CHECK(fake.more().openings == openings);
  }
}

TEST_CASE("a halt waits for the last call, which takes the force away, up to a tenth of a second") {
  bool taken = false; // 40 ms later at most, but where the machine stalls
  for (int attempt = 0; attempt < 20 && !taken; ++attempt) {
    const Fake fake("slow");
    const auto device = make();
    REQUIRE(device->open() == "");
    const ScriptedRun r(fake, *device, 3, [](int) { return Vec3{1, 0, 0}; });
    CHECK(r.sent[2] == Vec3{1, 0, 0});
    taken = fake.force() == Vec3{};
  }
  CHECK(taken);
}

TEST_CASE("a device runs once at a time, and only while it is open") {
  const Fake fake;
  const auto device = make();
  CHECK_FALSE(device->run([](void*) {}, nullptr));
  REQUIRE(device->open() == "");
  REQUIRE(device->run([](void*) {}, nullptr));
  CHECK_FALSE(device->run([](void*) {}, nullptr));
  device->halt();
  device->halt(); // is nothing new
  REQUIRE(device->run([](void*) {}, nullptr));
  device->close();
  CHECK_FALSE(device->run([](void*) {}, nullptr));
}
