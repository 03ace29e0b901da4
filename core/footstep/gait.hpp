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

/// Gait of a person on two feet: walks in a Style, sets off, halts, turns, jumps, scuffs and drags
/// a foot. Returns the SoleState of both feet for every sample.
///
/// Times and forces vary from step to step by `variation` (coefficient of variation, 3 to 5 % in
/// people), landing speeds by four times that.
///
/// Initially both feet are in the air, and the first step is a landing. After a halt each foot
/// carries half of the weight, and walking sets off from there.
class Gait {
public:
  static constexpr std::size_t kFeet = 2, kOverlap = 4;

  void prepare(double sample_rate) noexcept;
  /// Takes effect with the next step.
  void set(const Walker& walker, double variation) noexcept;
  void seed(std::uint64_t value) noexcept { random_.seed(value); }
  /// Lifts both feet; walking starts again with a landing of the first foot.
  void reset() noexcept;
  /// Starts walking, or halts: one more, softer step, then the other foot is put beside it.
  void walk(bool on) noexcept { walk_requested_ = on; }
  [[nodiscard]] bool walking() const noexcept { return walk_requested_; }
  /// Starts one step of a foot at once. If the foot is on the ground, the new landing overlaps: up
  /// to kOverlap footfalls of one foot are active, and a further one ends the oldest.
  void step(std::size_t foot) noexcept;
  /// Makes the next step a pivot by this angle, radians, up to pi. If the person does not walk,
  /// `foot` makes a step for the turn.
  void turn(double angle_rad, std::size_t foot) noexcept;
  /// A jump on both feet, height in m, clamped to kMinJump..kMaxJump. A walker halts before it and
  /// sets off again afterwards; feet in the air are put down first.
  void jump(double height_m) noexcept;
  /// The ball of a foot strikes the ground and slides: in its next swing, or at once if the person
  /// does not walk.
  void scuff(std::size_t foot) noexcept;
  /// A foot slides by a length, m, at a speed, m/s, under part of the weight: in its next swing and
  /// at most for its duration, or at once if the person does not walk.
  void drag(std::size_t foot, double length_m, double speed_m_per_s) noexcept;

  /// Computes one sample of both feet.
  void next(std::array<SoleState, kFeet>& feet) noexcept;

private:
  enum class State { kAir, kWalking, kHalting, kStanding, kBusy };
  /// A scuff or drag to be done when the foot is in the air.
  struct SwingAction {
    enum class Kind { kNone, kScuff, kDrag } kind = Kind::kNone;
    double length_m = 0, speed_m_per_s = 0;
    double wait_s = -1; ///< time since the foot left the ground; negative: it is still on the
                        ///< ground
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
  GroundReaction reaction_; ///< reaction of walker_
  double variation_ = 0.04, step_s_ = 1.0 / 48000;
  bool walk_requested_ = false;
  State state_ = State::kAir;
  double time_left_s_ = 0; ///< time until the next contact, or the end of the current movement
  std::size_t next_foot_ = 0;
  int steps_ = 0;                      ///< number of steps since setting off; saturates
  double turn_rad_ = 0, jump_m_ = 0;   ///< requested and not yet done
  Footfall second_footfall_, landing_; ///< footfalls that start when time_left_s_ has passed
  bool landing_pending_ = false;
  std::array<SwingAction, kFeet> swing_actions_{};
  std::array<double, kFeet> unloaded_{}; ///< share of its load that the other foot carries now
  Random random_;
  std::array<std::array<Footfall, kOverlap>, kFeet> footfalls_{};
  std::array<std::size_t, kFeet> in_use_{}; ///< by foot: all footfalls from this index are inactive
};

} // namespace tactus::footstep
