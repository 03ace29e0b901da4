#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <cstddef>
#include <span>

namespace tactus::footstep {

/// The floor around one region of the sole, heel or ball: a body with modes that the sole's parts
/// strike one after the other and that the sole rubs when it slides.
///
/// A landing is the fall of `patches` masses at one speed. The first touches at once with half of
/// the mass; the others share the rest and begin at heights drawn from an exponential distribution
/// of mean `unevenness`: the slower the landing, the longer it takes them to arrive.
class StruckFloor {
public:
  StruckFloor();
  void prepare(double sample_rate) noexcept;
  void seed(std::uint64_t value) noexcept;
  void reset() noexcept;

  /// Contact law of ground and sole in series. What sounds goes on.
  void set(const SolidRecipe& solid, double shoe) noexcept;
  /// Modes of the recipe, scaled in frequency and decay time; where it is struck stays.
  void scale_modes(const SolidRecipe& solid, std::span<const double> detune, double frequency,
                   double decay) noexcept;
  /// Draws where the parts of the sole meet the modes.
  void draw_contact_positions(const SolidRecipe& solid) noexcept;
  /// A mass (kg) arrives at a speed (m/s, > 0).
  void land(const SolidRecipe& solid, double mass_kg, double speed_m_per_s) noexcept;
  /// The sole slides at a speed (m/s) under a force (N) from now on; 0 N: it does not.
  void slide(double force_n, double speed_m_per_s) noexcept;

  /// Velocity that is heard, m/s, one sample on.
  double next() noexcept;
  [[nodiscard]] bool active() const noexcept {
    return sliding_ || landing_samples_left_ > 0 || body_.active();
  }

private:
  static constexpr std::size_t kSole = kMaxPatches; ///< slot of the sole that slides

  contact::ExcitedBody body_;
  contact::ImpactLaw law_;
  Random random_;
  double sample_rate_ = 48000;
  bool sliding_ = false; ///< or holds still
  double normal_force_n_ = 0, normal_force_decay_ = 0.999;
  double landing_samples_left_ = 0; ///< samples until the last part of a landing has touched
};

} // namespace tactus::footstep
