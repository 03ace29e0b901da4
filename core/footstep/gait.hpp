#pragma once

#include "core/dsp/random.hpp"
#include "core/footstep/ground_reaction.hpp"
#include "core/footstep/step_event.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::footstep {

/// Steps of a person who walks or runs on: forces under heel and ball of one or two feet, and the
/// phases of each step. No two steps are alike: times and forces vary by `variation` (coefficient
/// of variation, 3 to 5 % in people), landing speeds by four times that.
class Gait {
public:
  static constexpr std::size_t kFeet = 2, kOverlap = 4;

  void prepare(double sample_rate) noexcept;
  /// Holds from the next step on.
  void set(const Walker& walker, double variation) noexcept;
  void seed(std::uint64_t value) noexcept { random_.seed(value); }
  /// Both feet in the air; the next sample is a contact of the first foot.
  void reset() noexcept;
  /// Begins or ends walking; a step that is under way is completed.
  void walk(bool on) noexcept;
  /// One step of that foot now. A foot that is on the ground lands once more beside it: up to
  /// kOverlap landings of one foot are under way at once, and one more ends the oldest.
  void step(std::size_t foot) noexcept;
  [[nodiscard]] bool walking() const noexcept { return walking_; }

  /// One sample of both feet.
  void next(std::array<SoleState, kFeet>& feet) noexcept;

private:
  struct Step {
    GroundReaction reaction;
    bool under_way = false;
    double time_s = 0, stance_s = 0.6, scale = 1, flat_s = 0.08;
    double heel_speed = 0, ball_speed = 0;
    bool landed = false, flat = false, heel_up = false;
    double heel_n = 0, ball_n = 0;
  };
  void begin(std::size_t foot) noexcept;
  void advance(Step& step, SoleState& sole) noexcept;

  Walker walker_;
  GroundReaction reaction_; ///< of that walker
  double variation_ = 0.04, step_s_ = 1.0 / 48000, until_contact_s_ = 0;
  std::size_t next_foot_ = 0;
  bool walking_ = false;
  Random random_;
  std::array<std::array<Step, kOverlap>, kFeet> steps_{};
};

} // namespace tactus::footstep
