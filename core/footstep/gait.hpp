#pragma once

#include "core/dsp/random.hpp"
#include "core/footstep/footfall.hpp"
#include "core/footstep/ground_reaction.hpp"
#include "core/footstep/movements.hpp"
#include "core/footstep/step_event.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::footstep {

/// A person on two feet: walks in a Style, sets off, halts, turns, jumps, scuffs and drags a foot.
/// Gives forces under heel and ball of both feet, landing speeds, sliding, and the phases of each
/// step. No two steps are alike: times and forces vary by `variation` (coefficient of variation, 3
/// to 5 % in people), landing speeds by four times that.
///
/// At first the feet are in the air and the first step is a landing. Who halts stands, each foot
/// with half of the weight, and sets off from there.
class Gait {
public:
  static constexpr std::size_t kFeet = 2, kOverlap = 4;

  void prepare(double sample_rate) noexcept;
  /// Holds from the next step on.
  void set(const Walker& walker, double variation) noexcept;
  void seed(std::uint64_t value) noexcept { random_.seed(value); }
  /// Both feet in the air; a walker begins anew with a contact of the first foot.
  void reset() noexcept;
  /// Walks on, or halts: one more step, softer, and the other foot beside it.
  void walk(bool on) noexcept { walk_requested_ = on; }
  [[nodiscard]] bool walking() const noexcept { return walk_requested_; }
  /// One step of that foot now, whatever else goes on. A foot that is on the ground lands once more
  /// beside it: up to kOverlap landings of one foot are under way at once, and one more ends the
  /// oldest.
  void step(std::size_t foot) noexcept;
  /// The next step pivots by that angle (radians, up to pi); who does not walk makes a step of that
  /// foot for it.
  void turn(double angle_rad, std::size_t foot) noexcept;
  /// A jump on both feet, height in m (kMinJump..kMaxJump). A walker halts before it and sets
  /// off again after; feet in the air are put down first.
  void jump(double height_m) noexcept;
  /// The ball of that foot strikes and slides: in its next swing, or at once if it does not walk.
  void scuff(std::size_t foot) noexcept;
  /// That foot slides by a length (m) at a speed (m/s) under part of the weight: a walker's in its
  /// next swing and no longer than it, else at once.
  void drag(std::size_t foot, double length_m, double speed_m_per_s) noexcept;

  /// One sample of both feet.
  void next(std::array<SoleState, kFeet>& feet) noexcept;

private:
  enum class State { kAir, kWalking, kHalting, kStanding, kBusy };
  /// Something that a foot does once it is free.
  struct SwingAction {
    enum class Kind { kNone, kScuff, kDrag } kind = Kind::kNone;
    double length_m = 0, speed_m_per_s = 0;
    double wait_s = -1; ///< since the foot left the ground; negative: it has not yet
  };
  Footfall& play(std::size_t foot, const Footfall& footfall) noexcept;
  void replace(std::size_t foot, const Footfall& footfall) noexcept;
  void begin_step(std::size_t foot) noexcept;
  void begin_halt() noexcept;
  void begin_jump() noexcept;
  void start_from_air() noexcept;
  void begin_swing_actions() noexcept;
  void unload(std::size_t foot, double force_n, SoleState& sole) noexcept;
  void update_state() noexcept;
  [[nodiscard]] bool on_ground(std::size_t foot) const noexcept;
  [[nodiscard]] bool standing() const noexcept;
  [[nodiscard]] bool both_standing() const noexcept;
  void lift_feet() noexcept;
  [[nodiscard]] double varied(double times) noexcept;
  [[nodiscard]] double swing_s() const noexcept;

  Walker walker_;
  GroundReaction reaction_; ///< of that walker
  double variation_ = 0.04, step_s_ = 1.0 / 48000;
  bool walk_requested_ = false;
  State state_ = State::kAir;
  double time_left_s_ = 0; ///< until the next contact, or the end of what is under way
  std::size_t next_foot_ = 0;
  int steps_ = 0;                      ///< since setting off, as far as they differ
  double turn_rad_ = 0, jump_m_ = 0;   ///< what is still to be done
  Footfall second_footfall_, landing_; ///< what comes at the end of time_left_s_
  bool landing_pending_ = false;
  std::array<SwingAction, kFeet> swing_actions_{};
  std::array<double, kFeet> unloaded_{}; ///< part of its load that a foot does not bear just now
  Random random_;
  std::array<std::array<Footfall, kOverlap>, kFeet> footfalls_{};
  std::array<std::size_t, kFeet> in_use_{}; ///< by foot: no footfall from there on is under way
};

} // namespace tactus::footstep
