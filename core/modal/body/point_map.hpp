#pragma once

#include "core/modal/body/body_model.hpp"
#include "core/modal/body/events.hpp"

namespace tactus::modal {

/// Moves points of a body's surface to the surface of the model that takes over. In another shape
/// of the same body they move to the same material points, on another body to the same positions in
/// metres.
class PointMap {
public:
  PointMap(const BodyModel& before, const BodyModel& now, bool same_body) noexcept
      : now_(now), size_before_(before.settings.size), same_body_(same_body) {}

  /// A direction along the normal stays along the normal.
  void move(SurfacePoint& point, Vec3& direction) const noexcept {
    const bool along_normal = direction == point.normal;
    point = moved(point);
    if (along_normal)
      direction = point.normal;
  }
  void move(Hit& hit) const noexcept { move(hit.point, hit.direction); }
  void move(Strike& strike) const noexcept { move(strike.hit); }
  void move(ForcePoint& force) const noexcept { move(force.point, force.direction); }
  void move(Rub& rub) const noexcept {
    if (!rub.placed)
      return;
    rub.point = moved(rub.point);
    rub.direction = along_surface(rub.point.normal, rub.direction);
  }
  void move(Reset& /*reset*/) const noexcept {}

private:
  [[nodiscard]] SurfacePoint moved(const SurfacePoint& point) const noexcept {
    if (!same_body_)
      return now_.nearest(size_before_ * point.position);
    const Surface& surface = now_.loaded->surface;
    return surface.empty() ? point : surface.on(point.triangle, point.weight[1], point.weight[2]);
  }
  const BodyModel& now_;
  double size_before_;
  bool same_body_;
};

} // namespace tactus::modal
