#include "core/modal/body/struck_body.hpp"

/// StruckBody: friction by a rubbing surface.
namespace tactus::modal {

void StruckBody::begin_rub() noexcept {
  enter_contact();
  set_rub_point();
}

void StruckBody::set_rub(const Rub& rub) noexcept {
  rub_ = rub;
  if (!model_ || !model_->solver.contact(rub_slot()).active)
    return;
  model_->solver.set_friction(rub_slot(), rub.law);
  set_rub_point();
}

/// Sets the modal gains of the rub's point and direction.
void StruckBody::set_rub_point() noexcept {
  if (!rub_.placed)
    rub_.point = point_;
  rub_.direction = along_surface(rub_.point.normal, rub_.direction);
  // gains() is for a force against a direction.
  const Vec3 against = -rub_.direction;
  model_->gains(rub_.point, against, model_->scratch);
  // A rubbed body is held: friction moves its modes but not the body as a whole, unless it rests on
  // a board.
  const BodyModel::RigidGain rigid = model_->recoils(rub_.point)
                                         ? model_->rigid_gains(rub_.point, against)
                                         : BodyModel::RigidGain{};
  if (model_->solver.contact(rub_slot()).active)
    model_->solver.move_rub(rub_slot(), model_->scratch, rigid);
  else
    model_->solver.begin_rub(rub_slot(), rub_.law, model_->scratch, rigid, options_.seed);
  build_contact_kernels(rub_slot(), rub_.point, against);
}

/// Applies the rubbing surface's normal force and velocity of a sample.
void StruckBody::drive_rub(std::size_t sample) noexcept {
  const auto normal = static_cast<double>(chunk_.normal[sample]);
  if (normal > 0) {
    if (!model_->solver.contact(rub_slot()).active)
      set_rub_point();
    model_->solver.rub(rub_slot(), normal, static_cast<double>(chunk_.velocity[sample]));
  } else {
    model_->solver.end(rub_slot());
  }
}

} // namespace tactus::modal
