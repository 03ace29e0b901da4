#include "core/modal/body/struck_body.hpp"

/// How a StruckBody is rubbed.
namespace tactus::modal {

void StruckBody::begin_rub() noexcept {
  enter_contact();
  place_rub();
}

void StruckBody::set_rub(const Rub& rub) noexcept {
  rub_ = rub;
  if (!model_ || !model_->solver.contact(rub_slot()).active)
    return;
  model_->solver.set_friction(rub_slot(), rub.law);
  place_rub();
}

/// Works out what a rub's place and direction are to the modes.
void StruckBody::place_rub() noexcept {
  if (!rub_.placed)
    rub_.place = point_;
  rub_.direction = along_surface(rub_.place.normal, rub_.direction);
  // Gains are of a push against a direction.
  const Vec3 against = -rub_.direction;
  model_->gains(rub_.place, against, model_->scratch);
  // What is rubbed is held: the surface drags its modes along, not the body, unless it rests on a
  // board.
  const BodyModel::RigidGain rigid = model_->recoils(rub_.place)
                                         ? model_->rigid_gains(rub_.place, against)
                                         : BodyModel::RigidGain{};
  if (model_->solver.contact(rub_slot()).active)
    model_->solver.move_rub(rub_slot(), model_->scratch, rigid);
  else
    model_->solver.begin_rub(rub_slot(), rub_.law, model_->scratch, rigid);
  aim_contact(rub_slot(), rub_.place, against);
}

/// What rubs in this sample.
void StruckBody::drive_rub(std::size_t sample) noexcept {
  const auto normal = static_cast<double>(chunk_.normal[sample]);
  if (normal > 0) {
    if (!model_->solver.contact(rub_slot()).active)
      place_rub();
    model_->solver.rub(rub_slot(), normal, static_cast<double>(chunk_.velocity[sample]));
  } else {
    model_->solver.end(rub_slot());
  }
}

} // namespace tactus::modal
