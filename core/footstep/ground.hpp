#pragma once

#include "core/contact/touched_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"
#include "core/footstep/step_event.hpp"
#include "core/particle/cloud.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::footstep {

/// One foot's ground, made of a recipe: masses of heel and ball strike a body with modes, boards
/// rub, grains and bubbles are set free by landings and by load that comes and goes. Each landing
/// of the heel draws a new place: frequencies, decay times, strengths differ a little from step to
/// step.
class Ground {
public:
  Ground();
  void prepare(double sample_rate) noexcept;
  /// What sounds goes on sounding under the new recipe. Shoe 0 soft to 1 hard: it changes the
  /// stiffness of the contact tenfold up and down from its middle 0.4.
  void set(const Recipe& recipe, double shoe) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;

  struct Sound {
    double felt = 0;  ///< the ground's motion
    double heard = 0; ///< what of it the air takes
  };
  /// One sample; weight_n > 0 turns forces into body weights.
  Sound next(const SoleState& sole, double weight_n) noexcept;
  [[nodiscard]] bool silent() const noexcept { return silent_; }

private:
  static constexpr std::size_t kFrictionModes = 8;
  using Shape = std::array<double, kMostModes>;
  void new_place() noexcept;
  void tune(contact::TouchedBody& body, const ModesRecipe& modes, std::span<const double> detune,
            double frequency, double decay) noexcept;
  [[nodiscard]] Shape shape(const ModesRecipe& modes) noexcept;
  [[nodiscard]] double drawn(double deviation) noexcept;
  double rub(double weights, double slope) noexcept;

  Recipe recipe_;
  double sample_rate_ = 48000, shoe_ = 0.4;
  Random random_;
  Shape detune_{};
  contact::TouchedBody solid_, boards_;
  std::array<particle::Cloud, kMostClouds> clouds_;
  double wobble_ = 0, wobble_kept_ = 0.999;
  double speed_factor_ = 1, friction_factor_ = 1;
  double radiation_ = 0, radiation_kept_ = 0;
  bool silent_ = true, rubbing_ = false;
};

} // namespace tactus::footstep
