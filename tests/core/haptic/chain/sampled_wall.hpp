#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/servo/servo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

/// A handle of 0.1 kg and 0.5 N s/m at a sampled wall, the textbook case in which a hold creates
/// energy, with the faults of real devices: an encoder's step, a velocity that is estimated or
/// noisy, and latency. Shared by the tests and by bench/haptic_passivity.
namespace tactus::haptic::test {

/// F = -K x in x > 0.
struct SampledWall final : LocalModel {
  explicit SampledWall(double k) : stiffness(k) {}
  Vec3 force(const Tick&, const State& state) noexcept override {
    return {state.position.x > 0 ? -stiffness * state.position.x : 0.0, 0, 0};
  }
  double stiffness;
};

struct WallCase {
  enum class Velocity {
    kIdeal,      ///< the device's own, exact
    kEstimated,  ///< none: the servo estimates it
    kNoisy,      ///< exact plus white noise within 20 mm/s
    kDifference, ///< of the last two readings
  };
  enum class Scene {
    kFlight, ///< a free handle flies into the wall, at `value` m/s 50 ms before it
    kPush,   ///< a free handle, pushed with `value` N
    kSpring, ///< held by a spring that rests `value` m behind the wall's face
    kPerson, ///< the same with tremor
    kStroke, ///< held by a spring that goes `value` m in and out of the wall, twice a second
  };
  double stiffness_n_per_m = 500, rate_hz = 1000, encoder_m = 0;
  int latency_ticks = 0;
  bool declared = false; ///< the device says its latency; else one tick is assumed
  Velocity velocity = Velocity::kIdeal;
  Scene scene = Scene::kPush;
  double value = 1, hand_n_per_m = 200, hand_n_s_per_m = 2;
  double slew_n_per_s = 2000, force_limit_n = 8, tank_j = 5e-3, damping_n_s_per_m = 0;
  double allowance_w = 0;
  bool by_patch = false; ///< the wall is rendered by commands, a tick later
};

struct WallResult {
  double force_rms_n = 0;   ///< about its mean, last quarter
  double earlier_rms_n = 0; ///< the same in the quarter before
  double motion_m = 0;      ///< peak to peak, last quarter
  double middle_m = 0;      ///< of that
  double exit_energy = 0;   ///< of a flight: kinetic energy on leaving the wall over that on entry
  double max_slew = 0;      ///< largest change of force over what the slew allows
  double max_force_n = 0;
  double max_pull_n = 0; ///< largest force into the wall, or outside it beyond what the slew leaves
  bool left = false;     ///< of a flight

  /// What settles, as far as a held or pushed handle can: no growth, and no bouncing.
  [[nodiscard]] bool stable() const noexcept {
    return force_rms_n <= 1.05 * earlier_rms_n + 1e-3 && motion_m < 2e-3;
  }
};

class WallRig final : public Backend {
public:
  explicit WallRig(const WallCase& c, bool passivity) : case_(c), wall_(c.stiffness_n_per_m) {
    using Hold = HandSettings::Hold;
    SimulatedDevice::Settings s;
    s.stops = false;
    using Scene = WallCase::Scene;
    s.hand.hold = c.scene == Scene::kSpring || c.scene == Scene::kStroke ? Hold::kSpring
                  : c.scene == Scene::kPerson                            ? Hold::kPerson
                                                                         : Hold::kFree;
    s.hand.stiffness_n_per_m = c.hand_n_per_m;
    s.hand.damping_n_s_per_m = c.hand_n_s_per_m;
    s.hand.wander_m = s.hand.yield_s = 0; // both would take the hand away from the wall
    device_.set(s);
    const double end = c.scene == Scene::kStroke ? -c.value : c.value;
    device_.set_path(LinePath{{c.value, 0, 0}, {end, 0, 0}, 0.5});
    if (c.scene == WallCase::Scene::kFlight)
      device_.set_state({-0.05 * c.value, 0, 0}, {c.value, 0, 0});
    else
      device_.set_state({c.scene == WallCase::Scene::kPerson ? 0 : -0.002, 0, 0}, {});
    if (c.scene == WallCase::Scene::kPush)
      push_ = {c.value, 0, 0};
    ServoSettings settings;
    settings.chain.passivity = passivity;
    settings.chain.slew_n_per_s = c.slew_n_per_s;
    settings.chain.force_limit_n = c.force_limit_n;
    settings.chain.tank_j = c.tank_j;
    settings.chain.damping_n_s_per_m = c.damping_n_s_per_m;
    settings.chain.allowance_w = c.allowance_w;
    servo_.exchange().settings.write(settings);
    servo_.attach(*this, c.by_patch ? nullptr : &wall_);
  }

  [[nodiscard]] WallResult measure(double seconds) {
    return case_.scene == WallCase::Scene::kFlight ? fly(seconds) : stay(seconds);
  }

  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override {
    Caps caps = device_.caps();
    caps.has_velocity = case_.velocity != WallCase::Velocity::kEstimated;
    caps.position_noise_m = 0.5 * case_.encoder_m;
    caps.latency_ticks = case_.declared ? case_.latency_ticks : Caps{}.latency_ticks;
    return caps;
  }
  bool read(const Tick& tick, State& state) noexcept override {
    using Velocity = WallCase::Velocity;
    State now;
    if (!device_.read(tick, now))
      return false;
    double x = now.position.x;
    if (case_.encoder_m > 0)
      x = case_.encoder_m * std::floor(x / case_.encoder_m + 0.5);
    if (case_.velocity == Velocity::kNoisy)
      now.velocity.x += 0.02 * (2.0 * noise_.uniform() - 1.0);
    if (case_.velocity == Velocity::kDifference)
      now.velocity.x = reads_ > 0 ? (x - previous_x_) / tick.period_s : 0;
    previous_x_ = x;
    now.position = {x, 0, 0};
    states_[reads_ % states_.size()] = now;
    const auto late = std::min(reads_, static_cast<std::size_t>(case_.latency_ticks));
    state = states_[(reads_ - late) % states_.size()];
    last_x_ = state.position.x;
    ++reads_;
    return true;
  }
  bool write(const Vec3& force) noexcept override { return device_.write(force + push_); }

  void tick() noexcept {
    const double period_s = 1 / case_.rate_hz;
    const Tick tick{index_, static_cast<double>(index_) * period_s, period_s};
    ++index_;
    if (case_.by_patch) {
      State state;
      state.position = device_.position();
      servo_.exchange().commands.write({wall_.force(tick, state), index_, 0, false, tick.time_s});
    }
    servo_.step(tick);
    const Vec3 force = servo_.chain().written;
    result_.max_slew =
        std::max(result_.max_slew, norm(force - force_) / (case_.slew_n_per_s * period_s));
    result_.max_force_n = std::max(result_.max_force_n, norm(force));
    const double falling = std::max(-force_.x - case_.slew_n_per_s * period_s, 0.0);
    result_.max_pull_n =
        std::max({result_.max_pull_n, force.x, last_x_ <= 0 ? -force.x - falling : 0.0});
    force_ = force;
  }
  [[nodiscard]] double x() const noexcept { return device_.position().x; }
  [[nodiscard]] double v() const noexcept { return device_.velocity().x; }
  [[nodiscard]] const ChainState& chain() const noexcept { return servo_.chain(); }

private:
  WallResult fly(double seconds) {
    double arrival = 0;
    bool inside = false;
    for (int n = 0; n < static_cast<int>(seconds * case_.rate_hz) && !result_.left; ++n) {
      const double before = v();
      tick();
      if (!inside && x() > 0) {
        inside = true;
        arrival = before;
      } else if (inside && x() <= 0) {
        result_.exit_energy = v() * v() / (arrival * arrival);
        result_.left = true;
      }
    }
    return result_;
  }
  WallResult stay(double seconds) {
    const int ticks = static_cast<int>(seconds * case_.rate_hz), quarter = ticks / 4;
    double low = 1, high = -1;
    std::array<double, 2> sum{}, squares{};
    for (int n = 0; n < 4 * quarter; ++n) {
      tick();
      if (n < 2 * quarter)
        continue;
      const std::size_t half = n < 3 * quarter ? 0 : 1;
      sum[half] += force_.x;
      squares[half] += force_.x * force_.x;
      if (half == 1) {
        low = std::min(low, x());
        high = std::max(high, x());
      }
    }
    const auto rms = [quarter](double s, double q) {
      const double mean = s / quarter;
      return std::sqrt(std::max(q / quarter - mean * mean, 0.0));
    };
    result_.earlier_rms_n = rms(sum[0], squares[0]);
    result_.force_rms_n = rms(sum[1], squares[1]);
    result_.motion_m = high - low;
    result_.middle_m = 0.5 * (high + low);
    return result_;
  }

  WallCase case_;
  SampledWall wall_;
  SimulatedDevice device_;
  Servo servo_;
  Vec3 push_{}, force_{};
  Random noise_{7};
  std::array<State, 16> states_{};
  std::size_t reads_ = 0;
  double previous_x_ = 0, last_x_ = 0; // read without latency, and given
  std::uint64_t index_ = 0;
  WallResult result_{};
};

inline WallResult run_wall(const WallCase& c, bool passivity, double seconds = 2) {
  return WallRig(c, passivity).measure(seconds);
}

} // namespace tactus::haptic::test
