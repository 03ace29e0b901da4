#pragma once

#include "core/modal/body/direct_mixer.hpp"
#include "core/modal/body/point_map.hpp"

#include <cstdint>

namespace tactus::modal {

/// A surface that rubs the body, its normal force and velocity given sample by sample.
class RubbingSurface {
public:
  /// Sets the law and the point. `body` is null if there is no body.
  void set(const Rub& rub, const ForcePoint& force_point, BodyModel* body,
           DirectMixer& direct) noexcept;
  [[nodiscard]] const Rub& rub() const noexcept { return rub_; }
  /// Seeds the noise of the roughness.
  void set_seed(std::uint64_t seed) noexcept { seed_ = seed; }
  void begin(const ForcePoint& force_point, BodyModel& body, DirectMixer& direct) noexcept;
  /// Applies the normal force and the velocity of a sample of the solver.
  void press(double normal_force_n, double velocity_m_per_s, const ForcePoint& force_point,
             BodyModel& body, DirectMixer& direct) noexcept;
  void move_points(const PointMap& map) noexcept;
  /// Continues the contact in the solver of a new model of the same body.
  void take_over_contact(BodyModel& now, const BodyModel& before) const noexcept;

private:
  void set_contact(const ForcePoint& force_point, BodyModel& body, DirectMixer& direct) noexcept;

  Rub rub_;     ///< the rub as it was set
  Rub contact_; ///< the rub on the body's surface
  std::uint64_t seed_ = 1;
};

} // namespace tactus::modal
