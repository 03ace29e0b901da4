#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// Settings of the passivity controller, SI.
struct PassivitySettings {
  double period_s = 1e-3;
  double slew_n_per_s = 2000; ///< largest rate of change of the force
  double tank_j = 5e-3;       ///< largest positive energy that the observer stores
  double allowance_w = 0;     ///< power that the hold of commands may create
  bool active = true;         ///< false: observed only
  // of the device
  double damping_limit_n_s_per_m = 5; ///< largest damping it renders stably at 1 kHz
  double position_noise_m = 0;        ///< largest error of one reading
  int latency_ticks = 0;              ///< delay, as Caps::latency_ticks
};

/// Passivity observer and controller in the time domain, after Hannaford & Ryu, IEEE Transactions
/// on Robotics and Automation 18, 2002. docs/theory/passivity.md has the equations,
/// docs/results/passivity.md the sweep over walls, rates, encoders, latencies and hands.
///
/// A force that is a function of the position is held over a tick of length T and felt L ticks
/// late. A spring K then creates the power K T (1/2 + L) u^2 at the speed u; a constant force
/// creates none. Two parts of the force are observed, each along its own direction: the force of
/// the models in the servo (the contact), and the force of the commands, which the host computes a
/// tick later.
///
/// 1. The damper -b u removes the energy D, J, that has been created and is not yet removed, with
///      b = min(D/(T u^2), (3.5 + L) K T, b_device)   (4.5 for commands)
///    K is the regression of changes of force on changes of position. u is the velocity reading, at
///    most d/T, if the displacement d over the last 2 ms confirms its sign.
/// 2. A contact of at most 0.1 s that throws the handle back is reduced if it would give the handle
///    more energy than the observer holds and more momentum than the handle arrived with. The
///    reduction begins early enough for latency and slew limit.
///
/// Neither damper nor reduction reverses a force, and a part that is zero stays zero.
class PassivityController {
public:
  static constexpr double kAtRest_s = 0.05;
  static constexpr int kMaxLatency_ticks = 8;

  /// The parts of a force, N.
  struct Parts {
    Vec3 contact{}; ///< force of models inside the servo
    Vec3 command{}; ///< force of the host, and every force that is not a contact
  };

  /// Updates the observer. position_m: of the handle now; written_n: the force that was written in
  /// the last tick, after the slew limit.
  void observe(const PassivitySettings& settings, const Vec3& position_m,
               const Vec3& written_n) noexcept;
  /// The parts to write instead of `desired`; velocity: the device's reading, m/s. A part becomes
  /// shorter, down to zero, or longer by at most b_device times the speed against it.
  [[nodiscard]] Parts limit(const PassivitySettings& settings, const Parts& desired,
                            const Vec3& velocity) noexcept;

  /// The work of the hand on the contact since it began, J: E_n = E_(n-1) - F_(n-1-L) . (x_n -
  /// x_(n-1)), exact for a held force, at most tank_j. It becomes zero when the last force of the
  /// contact has reached the hand; a negative energy also becomes zero when the handle has been at
  /// rest for kAtRest_s.
  [[nodiscard]] double energy_j() const noexcept { return energy_j_; }
  /// Magnitude of the change of the force by the last limit(), N.
  [[nodiscard]] double taken_n() const noexcept { return taken_n_; }

private:
  static constexpr std::size_t kHistory = 64;
  static_assert((kHistory & (kHistory - 1)) == 0 && kMaxLatency_ticks < int{kHistory});
  template <class T> static T& at(std::array<T, kHistory>& ring, std::size_t tick) noexcept {
    return ring[tick % kHistory];
  }
  /// One part of the force, and the energy that holding it has created.
  struct Held {
    Vec3 desired{}, returned{};              // forces of the last tick
    Vec3 direction{};                        // direction of the last force that was not zero
    double force_change_n = 0, motion_m = 0; // changes in a tick, along the direction; low-passed
    double changes_n2 = 0, product_nm = 0, motions_m2 = 0; // leaky sums
    double created_j = 0;
    [[nodiscard]] double stiffness(double period_s, const Vec3& force_n,
                                   const Vec3& moved_m) noexcept;
    /// lead_ticks: between the position and the middle of the tick in which its force is felt.
    void brake(const PassivitySettings& settings, const Vec3& force_n, const Vec3& moved_m,
               const Vec3& velocity, double lead_ticks, double allowance_w) noexcept;
  };
  [[nodiscard]] Vec3 displacement(const PassivitySettings& settings) noexcept;
  void begin_contact(const PassivitySettings& settings) noexcept;
  void end_contact(const PassivitySettings& settings) noexcept;
  [[nodiscard]] double affordable_force(const PassivitySettings& settings, double outward,
                                        double accelerated) noexcept;

  std::array<Vec3, kHistory> positions_{};
  std::array<Vec3, kHistory> contacts_{}; // the contact's part of the written force
  std::size_t tick_ = 0;
  Held contact_{}, command_{};
  Vec3 moved_{}, moved_before_{}; // displacements in the last tick, and in the tick before
  double energy_j_ = 0;
  Vec3 rest_position_{};
  double at_rest_s_ = 0;

  // the approach, as the end of a free flight
  Vec3 arrival_m_{}, approach_{}; // last reading before the contact; mean velocity until that
                                  // reading
  double approach_error_ = 0;     // m/s
  double contact_s_ = 0;
  double impulse_ns_ = 0, double_impulse_kg_m_ = 0; // integrals of the contact's force, felt until
                                                    // now
  double variation_n_ = 0;                          // sum of the changes of that force
  double outward_ = 0;                              // speed along the contact's force
  std::size_t free_ticks_ = 0;
  double taken_n_ = 0;
  bool started_ = false;
};

} // namespace tactus::haptic
