#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <cstddef>
#include <span>

namespace tactus::footstep {

/// The floor under one region of the sole (heel or ball): a body with modes that parts of the sole
/// strike one after the other, and that the sole rubs when it slides.
///
/// A landing is the fall of `patches` masses at one speed. The first mass touches at once, with
/// half of the total mass. The others share the rest of it and start at heights drawn from an
/// exponential distribution of mean `unevenness`, so at a slower landing they arrive later.
class StruckFloor {
public:
  StruckFloor();
  void prepare(double sample_rate) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;

  /// Sets the contact law: ground and sole in series. Vibration continues.
  void set(const SolidRecipe& solid, double shoe) noexcept;
  /// Sets the modes of the recipe, with factors on frequencies and decay times. The contact points
  /// stay.
  void scale_modes(const SolidRecipe& solid, std::span<const double> detune, double frequency,
                   double decay) noexcept;
  /// Draws new contact points for the parts of the sole.
  void draw_contact_positions(const SolidRecipe& solid) noexcept;
  /// Starts a landing of a mass, kg, at a speed > 0, m/s.
  void land(const SolidRecipe& solid, double mass_kg, double speed_m_per_s) noexcept;
  /// Sliding speed, m/s, and normal force, N, which stay until they are changed. Force 0: no
  /// sliding.
  void slide(double force_n, double speed_m_per_s) noexcept;

  /// Advances by a sample. Returns the velocity at the pickup, m/s.
  double next() noexcept;
  [[nodiscard]] bool active() const noexcept {
    return sliding_ || landing_samples_left_ > 0 || body_.active();
  }

private:
  static constexpr std::size_t kSole = kMaxPatches; ///< exciter slot of the sliding sole

  contact::ExcitedBody body_;
  contact::ImpactLaw law_;
  Random random_;
  double sample_rate_ = 48000;
  bool sliding_ = false; ///< the sole rubs, or still holds after it has stopped
  double normal_force_n_ = 0, normal_force_decay_ = 0.999;
  double landing_samples_left_ = 0; ///< samples until the last part of a landing has touched
};

} // namespace tactus::footstep
