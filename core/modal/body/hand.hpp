#pragma once

#include "core/dsp/joined_steps.hpp"
#include "core/modal/body/direct_mixer.hpp"

#include <span>

namespace tactus::modal {

/// A striker whose height above the force point is given, sample by sample.
class Hand {
public:
  void prepare(double sample_rate) noexcept { steps_.prepare(sample_rate); }
  /// Joins the held readings of a chunk of heights, m, in place.
  void join(std::span<float> height) noexcept { steps_.run(height); }
  /// Removes the hand; the next one begins at the surface.
  void leave() noexcept { steps_.reset(); }
  void begin(const Striker& striker, const ForcePoint& point, BodyModel& body,
             DirectMixer& direct) noexcept;
  /// Moves the hand to a height for a sample of the solver; it begins to touch below 0.
  void press(double height_m, bool driven, const Striker& striker, const ForcePoint& point,
             BodyModel& body, DirectMixer& direct) noexcept;
  /// Ends that sample. The hand leaves the body above the surface, when `force_n` is 0.
  void lift(double height_m, bool driven, double force_n, BodyModel& body) noexcept;
  /// Lets samples pass without a contact.
  void pass(double height_m) noexcept { last_height_m_ = height_m; }
  /// Continues the contact in the solver of a new model of the same body.
  void take_over_contact(const ForcePoint& point, BodyModel& now, const BodyModel& before) noexcept;

private:
  JoinedSteps steps_{};
  double last_height_m_ = 0;
  double scale_ = 1; ///< scale of the depth, while the body changes under the hand
};

} // namespace tactus::modal
