#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <cstdint>
#include <span>

namespace tactus::footstep {

/// Boards that rub in a joint while a load comes to them and moves over them: stick and slip whose
/// normal force is the foot's and whose drive is the bending of the floor.
///
/// A joint of stiffness K = m (2 pi f)^2 pressed by N slips each time that the bending at a speed v
/// has stretched it by 2 (mu_s - mu_d) N / K: 1/v times that is the time between two bursts.
/// What stretches it when the foot leaves stays until the next step.
class CreakingBoards {
public:
  CreakingBoards();
  void prepare(double sample_rate) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;
  /// What sounds goes on.
  void set(const FrictionRecipe& friction) noexcept;
  /// Modes of the recipe, scaled in frequency and decay time; where they rub stays.
  void scale_modes(const FrictionRecipe& friction, std::span<const double> detune, double frequency,
                   double decay) noexcept;
  /// Draws how the modes take part in the joint, and how fast it bends.
  void draw_contact_position(const FrictionRecipe& friction) noexcept;

  /// Velocity that is heard, m/s, one sample on. load: on the floor, in reference weights; bending:
  /// rate of the load that bends it, reference weights a second, negative while it springs back.
  double next(const FrictionRecipe& friction, double load, double bending) noexcept;
  [[nodiscard]] bool active() const noexcept { return active_; }

private:
  static constexpr std::size_t kModes = 8, kJoint = 1;

  contact::ExcitedBody body_;
  Random random_;
  double wobble_ = 0, wobble_pole_ = 0.999;
  double speed_factor_ = 1;
  double sample_rate_ = 48000;
  double silent_samples_ = 0; ///< samples without sound since the load has left
  double peak_ = 0;           ///< since the boards were last at rest
  bool active_ = false;
};

} // namespace tactus::footstep
