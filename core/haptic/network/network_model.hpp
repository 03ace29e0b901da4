#pragma once

#include "core/dsp/ring.hpp"
#include "core/haptic/network/network.hpp"
#include "core/haptic/servo/servo.hpp"

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <variant>

namespace tactus::haptic {

/// One value of each pickup: the mean over one or more steps.
using NetworkSample = std::array<float, Network::kPickups>;

/// Simulates a mass-spring network inside the servo, both felt and heard. docs/theory/network.md
/// has the model.
///   M x'' = f_links(x, x') - alpha M x' + M g + f_handle + f_pluck
/// by the symplectic Euler rule, v += h F(x, v)/m, x += h v, with a whole number of steps in a
/// servo tick (stability.hpp). A tick simulates the time since the last one: the handle moves
/// linearly from its last position to the present one. The hand gets the negative mean of the
/// handle's force on the masses, so that momentum is conserved over every tick.
///
/// Passive for any parameters: the energy of masses, links and the handle's springs grows by no
/// more than the work of the handle, of plucks and of edits. For linear links the scheme conserves
/// it up to rounding. If the scheme creates energy, for example when a spring is compressed to zero
/// length, the velocities are scaled down (network_energy.cpp).
///
/// The host publishes whole networks; a mass that keeps its key keeps its motion. Bounded work, no
/// allocation; a state that is not finite is reset.
class NetworkModel final : public LocalModel {
public:
  static constexpr double kMaxPosition_m = 2, kMaxSpeed_m_per_s = 1000;
  static constexpr double kMaxHandle_n = 40;  ///< limit of the force between handle and one mass
  static constexpr double kMaxPluck_n = 1000; ///< limit of a pluck's force

  /// Ramp of the handle's force on a mass that is inside the sphere when the mass appears, when a
  /// device is opened or when the sphere grows. The force of the spring to a grabbed mass has the
  /// same ramp.
  static constexpr double kContactRamp_s = 0.1;

  /// Actions of the hand on the mass with a key or on the nearest mass, and a reset.
  struct Pluck {
    std::uint64_t key = 0;
    Vec3 force_n{}; ///< constant
    double duration_s = 0;
  };
  struct Grab {
    std::uint64_t key = 0;
  };
  struct GrabNearest {};
  struct Release {};
  struct Reset {};
  using Action = std::variant<Reset, Pluck, Grab, GrabNearest, Release>;

  NetworkModel() = default;
  ~NetworkModel() override;
  NetworkModel(const NetworkModel&) = delete;
  NetworkModel& operator=(const NetworkModel&) = delete;

  // the host's side
  /// Replaces the network at the servo's next tick; a network that the servo has not taken yet is
  /// dropped. The network must respect the maxima of Network, and max_stable_step() must be
  /// positive.
  void publish(std::unique_ptr<const Network> network);
  /// Frees the networks that the servo has returned.
  void collect() noexcept;
  /// False when the queue is full.
  bool queue_action(const Action& action) noexcept { return actions_.push(action); }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;
  /// The pickups of the last tick, in order of time.
  [[nodiscard]] std::span<const NetworkSample> samples() const noexcept {
    return {samples_.data(), sample_count_};
  }

  // while no step runs
  [[nodiscard]] Vec3 position(std::size_t mass) const noexcept;
  /// m/s, half a step before the time of position().
  [[nodiscard]] Vec3 velocity(std::size_t mass) const noexcept;
  /// Force of links, handle and plucks in the last step, N.
  [[nodiscard]] Vec3 force_on(std::size_t mass) const noexcept;
  /// Kinetic, elastic and potential energy half a step before the positions, as the scheme
  /// conserves it, including the handle's springs.
  [[nodiscard]] double energy_j() const noexcept;
  /// Ticks in which velocities were scaled down.
  [[nodiscard]] std::uint64_t energy_limited_ticks() const noexcept {
    return energy_limited_ticks_;
  }
  [[nodiscard]] double step_s() const noexcept { return step_s_; }

private:
  static constexpr std::size_t kPoints = Network::kMaxPoints;
  static constexpr std::size_t kMaxSteps = 1024, kMaxPlucks = 16;
  static constexpr std::uint64_t kNoKey = 0;
  using Row = std::array<double, kPoints>;
  struct Published {
    std::unique_ptr<const Network> network;
    double max_step_s;
  };
  struct RunningPluck {
    std::uint64_t key = kNoKey;
    std::size_t mass = 0;
    Vec3 force_n{};
    double remaining_s = 0;
    Vec3 velocity_before{}; ///< velocity of the mass, in the step under way
  };

  void take_network() noexcept;
  [[nodiscard]] double gain_after_growth(double before_m, std::size_t mass) const noexcept;
  void take_actions(const Vec3& handle) noexcept;
  void begin(const Pluck& pluck) noexcept;
  void grab(std::size_t mass) noexcept;
  [[nodiscard]] std::size_t nearest_movable(const Vec3& position_m) const noexcept;
  [[nodiscard]] bool movable(std::size_t mass) const noexcept {
    return mass < count_ && inverse_mass_[mass] > 0;
  }
  [[nodiscard]] std::size_t find(std::uint64_t key) const noexcept;
  void reset() noexcept;
  void find_candidates(const Vec3& from, const Vec3& to, double period_s) noexcept;
  void raise_gains(double period_s) noexcept;
  void apply_links() noexcept;
  [[nodiscard]] Vec3 apply_handle(const Vec3& handle, const Vec3& velocity) noexcept;
  void apply_plucks() noexcept;
  void end_plucks() noexcept;
  void integrate() noexcept;
  void add_force(std::size_t mass, const Vec3& force) noexcept;
  [[nodiscard]] NetworkSample read_pickups() const noexcept;
  void clamp_state() noexcept;
  [[nodiscard]] double handle_energy_j() const noexcept;
  [[nodiscard]] static double saturated_spring_energy_j(double stiffness, double product,
                                                        double extent) noexcept;
  [[nodiscard]] double work_of_plucks() const noexcept;
  void limit_energy(double work_j, double period_s) noexcept;

  std::atomic<const Published*> pending_{nullptr};
  Ring<const Published*, 64> retired_;
  Ring<Action, 64> actions_;

  const Published* published_ = nullptr;
  const Network* network_ = nullptr;
  std::size_t count_ = 0;
  std::array<std::uint64_t, kPoints> keys_{};
  Row x_{}, y_{}, z_{}, vx_{}, vy_{}, vz_{}, fx_{}, fy_{}, fz_{};
  Row mass_{}, inverse_mass_{}; // inverse 0: an anchor
  Row touch_gain_{};            // 0..1 over kContactRamp_s; below 0: the mass is new
  double step_s_ = 0;

  Vec3 handle_{}, handle_velocity_{}; // position at the end of the last tick, and velocity during
                                      // it
  bool started_ = false;
  std::uint64_t grabbed_ = kNoKey;
  std::size_t grabbed_mass_ = 0;
  double grab_gain_ = 0; // 0..1 over kContactRamp_s
  std::array<std::uint16_t, kPoints> candidates_{};
  std::size_t candidate_count_ = 0;
  std::array<RunningPluck, kMaxPlucks> plucks_{};

  double budget_j_ = 0; // energy, and losses of the last kBudgetTimeConstant_s
  bool has_budget_ = false;
  std::uint64_t energy_limited_ticks_ = 0;

  std::array<NetworkSample, kMaxSteps> samples_{};
  std::size_t sample_count_ = 0;
};

} // namespace tactus::haptic
