#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <cstdint>
#include <span>

namespace tactus::footstep {

/// Floor boards that creak: stick-slip friction in a joint between two boards. The load of the foot
/// presses the joint together, and the bending of the floor drives it.
///
/// A joint of stiffness K = m (2 pi f)^2 (N/m) under the normal force N slips each time the bending
/// has stretched it by 2 (mu_s - mu_d) N / K. At a bending speed v the time between two slips is
/// that stretch divided by v. The stretch that remains when the foot leaves stays until the next
/// step.
class CreakingBoards {
public:
  CreakingBoards();
  void prepare(double sample_rate) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;
  /// Sets the friction law and the joint. Vibration continues.
  void set(const FrictionRecipe& friction) noexcept;
  /// Sets the modes of the recipe, with factors on frequencies and decay times. The contact point
  /// stays.
  void scale_modes(const FrictionRecipe& friction, std::span<const double> detune, double frequency,
                   double decay) noexcept;
  /// Draws a new contact point of the joint and a new factor on its bending speed.
  void draw_contact_position(const FrictionRecipe& friction) noexcept;

  /// Advances by a sample. Returns the velocity at the pickup, m/s. `load`: on the floor, reference
  /// weights. `bending`: rate of the load that bends the floor, reference weights per second;
  /// negative while the floor springs back. The joint takes at least 50 ms to open, however fast
  /// the load falls.
  double next(const FrictionRecipe& friction, double load, double bending) noexcept;
  [[nodiscard]] bool active() const noexcept { return active_; }

private:
  static constexpr std::size_t kModes = 8, kJoint = 1;

  contact::ExcitedBody body_;
  Random random_;
  double load_ = 0, peak_load_ = 0; ///< load on the joint, and its peak since the joint was open
  double unloading_ = 0.001;        ///< largest fall of the load in a sample, as a share of the
                                    ///< peak
  double bending_ = 0;              ///< bending rate of the last sample
  double wobble_ = 0, wobble_pole_ = 0.999;
  double speed_factor_ = 1;
  double sample_rate_ = 48000;
  double silent_samples_ = 0; ///< samples without sound since the load left
  double peak_ = 0;           ///< largest output since the boards were at rest
  bool active_ = false;
};

} // namespace tactus::footstep
