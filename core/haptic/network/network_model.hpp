#pragma once

#include "core/haptic/network/network.hpp"
#include "core/haptic/servo/ring.hpp"
#include "core/haptic/servo/servo.hpp"

#include <array>
#include <atomic>
#include <memory>
#include <span>

namespace tactus::haptic {

/// One value of each pickup, the mean of one or more steps.
using NetworkSample = std::array<float, Network::kPickups>;

/// A mass-spring network that lives inside the servo, felt and heard. docs/network.md.
///   M x'' = -links(x, x') - alpha M x' + M g + handle
/// stepped by the symplectic Euler rule, v += h F(x, v)/m, x += h v, a whole number of steps in a
/// servo tick (stability.hpp says how many). A tick covers the time since the last one: the handle
/// goes straight from its last position to the present, and the hand gets the opposite of the mean
/// force that the masses got from it, so that momentum is conserved over every tick.
///
/// Passive for any numbers: the energy of masses, links and the handle's springs grows by no more
/// than what the handle's motion, plucks and edits put in. Linear links keep it to rounding; where
/// the scheme makes energy, such as at a spring pressed to no length, the velocities are scaled
/// down (network_energy.cpp).
///
/// The host publishes whole networks as it does scenes; masses that keep their key keep their
/// motion. Bounded work, no allocation; a state that is not finite is put back to rest.
class NetworkModel final : public LocalModel {
public:
  static constexpr double kMaxPosition_m = 2, kMaxSpeed_m_per_s = 1000;
  static constexpr double kMaxHandle_n = 40;  ///< the handle's spring to a mass yields beyond
  static constexpr double kMaxPluck_n = 1000; ///< longer forces are shortened

  /// A mass that appears within the sphere about the handle, or is there when a device is opened or
  /// the sphere grows, is pushed by a force that grows for this long; so does that of a spring that
  /// grabs a mass.
  static constexpr double kEmerging_s = 0.1;

  struct Action {
    enum class Kind { kPluck, kGrab, kGrabNearest, kRelease, kReset };
    Kind kind = Kind::kReset;
    std::uint64_t key = 0;
    Vec3 force_n{};        ///< of a pluck, constant
    double duration_s = 0; ///< of a pluck
  };

  NetworkModel() = default;
  ~NetworkModel() override;
  NetworkModel(const NetworkModel&) = delete;
  NetworkModel& operator=(const NetworkModel&) = delete;

  // the host's side
  /// The servo's next tick takes it; one that it has not taken yet is dropped. The network must
  /// respect its maxima and max_stable_step must be above 0.
  void publish(std::unique_ptr<const Network> network);
  /// Frees the networks that the servo has done with.
  void collect() noexcept;
  /// False when too many wait already.
  bool queue_action(const Action& action) noexcept { return actions_.push(action); }

  // the servo's side
  void begin() noexcept override;
  [[nodiscard]] Vec3 force(const Tick& tick, const State& state) noexcept override;
  /// What the pickups found in the last tick, in order.
  [[nodiscard]] std::span<const NetworkSample> samples() const noexcept {
    return {samples_.data(), sample_count_};
  }

  // while no step runs
  [[nodiscard]] Vec3 position(std::size_t mass) const noexcept;
  /// Half a step before the position.
  [[nodiscard]] Vec3 velocity(std::size_t mass) const noexcept;
  /// Force of links and handle in the last step.
  [[nodiscard]] Vec3 force_on(std::size_t mass) const noexcept;
  /// Kinetic, elastic and gravity's energy half a step before the positions, as the scheme keeps
  /// it, that of the handle's springs included.
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
  struct Pluck {
    std::uint64_t key = kNoKey;
    std::size_t mass = 0;
    Vec3 force_n{};
    double remaining_s = 0;
    Vec3 velocity_before{}; ///< of the mass, in the step under way
  };

  void take_network() noexcept;
  [[nodiscard]] double gain_after_growth(double before_m, std::size_t mass) const noexcept;
  void take_actions(const Vec3& handle) noexcept;
  void apply_action(const Action& action, const Vec3& handle) noexcept;
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
  Row touch_gain_{};            // 0..1 while a mass emerges; below 0: it has just appeared
  double step_s_ = 0;

  Vec3 handle_{}, handle_velocity_{}; // at the end of the last tick, and during it
  bool started_ = false;
  std::uint64_t grabbed_ = kNoKey;
  std::size_t grabbed_mass_ = 0;
  double grab_gain_ = 0; // 0..1 while the spring takes hold
  std::array<std::uint16_t, kPoints> candidates_{};
  std::size_t candidate_count_ = 0;
  std::array<Pluck, kMaxPlucks> plucks_{};

  double budget_j_ = 0; // energy and what it has lately lost
  bool has_budget_ = false;
  std::uint64_t energy_limited_ticks_ = 0;

  std::array<NetworkSample, kMaxSteps> samples_{};
  std::size_t sample_count_ = 0;
};

} // namespace tactus::haptic
