#pragma once

#include "core/contact/friction.hpp"
#include "core/geometry/surface.hpp"

#include <variant>

namespace tactus::modal {

/// A striker: a ball in Hertz contact, or a mass with a contact law of its own.
struct Striker {
  double mass_kg = 0.00710, radius_m = 0.006, youngs_modulus_pa = 206e9, poisson = 0.29;
  double stiffness = 0, exponent = 1.5, loss_s_per_m = 0; ///< stiffness above 0 overrides Hertz
  double restitution = 1; ///< restitution on a rigid wall; below 1 it sets the loss
};

struct Hit {
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< unit vector; the striker moves against it
  double speed_m_per_s = 1;
  bool falls = false; ///< the striker falls under gravity and bounces until it lies still
};

/// The events of a body, in the order of Event.
struct Strike {
  Hit hit;
  Striker striker;
};
/// Where the external force and the hand act from now on.
struct ForcePoint {
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< unit vector; the force acts against it
};
/// The friction law and the point of the surface that rubs the body, such as a bow.
struct Rub {
  bool placed = false; ///< false: it rubs at the force point
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< unit vector along the body's surface, in the direction of positive
                           ///< velocity
  contact::FrictionLaw law;
};
/// All contacts end, and the sound fades out.
struct Reset {};
using Event = std::variant<Strike, ForcePoint, Rub, Reset>;

} // namespace tactus::modal
