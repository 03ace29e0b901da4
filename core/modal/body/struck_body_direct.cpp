#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <functional>
#include <utility>

/// StruckBody: the direct sound of forces (DirectSound). While the modes' weights glide from model
/// to model, forces are filtered by the kernels of each of these models, blended in step.
namespace tactus::modal {

/// Calls work(model) for every model whose kernels sound.
template <class Work> void StruckBody::for_each_model(Work&& work) noexcept {
  work(*model_);
  for (Handover* const previous : previous_models_)
    if (previous)
      work(*previous->model);
}

void StruckBody::build_contact_kernels(std::size_t slot, const SurfacePoint& point,
                                       const Vec3& direction) noexcept {
  for_each_model([&](BodyModel& m) { m.build_contact_kernels(slot, point, direction); });
}

/// The pulse's gains, without culled modes, are in the present model's `scratch`.
void StruckBody::build_pulse_kernels(std::size_t slot, const SurfacePoint& point,
                                     const Vec3& direction) noexcept {
  for_each_model([&](BodyModel& m) {
    m.build_pulse_kernels(slot, point, direction,
                          &m == model_.get() ? std::span<const double>(m.scratch)
                                             : std::span<const double>());
  });
}

void StruckBody::build_point_kernels() noexcept {
  point_kernels_valid_ = true;
  for_each_model([&](BodyModel& m) { m.build_point_kernels(point_, point_direction_); });
}

/// Continues with a new model of the same body. `moving`: the weights of the old one were gliding.
/// Old models are kept for as long as their kernels sound.
void StruckBody::take_over_direct(Handover* before, bool moving) noexcept {
  const auto free_entry = std::find(previous_models_.begin(), previous_models_.end(), nullptr);
  *free_entry = before; // at most three parts sound, so that one of four is free
  if (!moving) {
    direct_.start();
    part_model_ = {nullptr, before->model.get(), model_.get()};
    carry_over_direct(*before->model, before->model->solver);
  }
  retire_unused();
}

/// From now on only the present model's kernels are used, whether the bank's weights glide or not.
void StruckBody::use_current_kernels() noexcept {
  part_model_.fill(model_.get());
  retire_unused();
}

void StruckBody::retire_unused() noexcept {
  for (Handover*& previous : previous_models_)
    if (previous && std::find(part_model_.begin(), part_model_.end(), previous->model.get()) ==
                        part_model_.end())
      retire(std::exchange(previous, nullptr));
}

/// Continues the latest part from an earlier model: forces that persist are taken as constant for
/// long (DirectSound::add_history). `solver` has the present contacts.
void StruckBody::carry_over_direct(BodyModel& before, const ContactSolver& solver) noexcept {
  const BodyModel& latest = *part_model_[ModeBank::kLatest];
  const auto carry = [&](const auto& to, const auto& from, std::span<const double> force) {
    std::array<double, DirectKernels::kMaxMoments> negative{};
    std::transform(force.begin(), force.end(), negative.begin(), std::negate());
    for (std::size_t l = 0; l < latest.settings.listeners; ++l) {
      const auto moments = [&](const BodyModel& m, std::span<const double> all) {
        return all.first(std::min(force.size(), m.direct[l].moments()));
      };
      direct_.add_history(l, to[l], latest.direct[l].taps(), moments(latest, force));
      direct_.add_history(l, from[l], before.direct[l].taps(), moments(before, negative));
    }
  };
  if (last_force_ != 0) {
    if (!point_kernels_valid_)
      build_point_kernels();
    carry(latest.sample_kernel[0], before.sample_kernel[0], {&last_force_, 1});
  }
  if (!in_solver_)
    return;
  for (const ContactSolver::SampledForce& sampled : solver.sampled())
    if (model_->solver.contact(sampled.slot).active)
      carry(latest.contact_kernel[sampled.slot], before.contact_kernel[sampled.slot],
            sampled.moments);
}

/// Calls work(part, model) for the parts of the glide with a weight above 0.
template <class Work> void StruckBody::for_each_part(Work&& work) noexcept {
  const Glide& glide = model_->bank.glide(0);
  for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest}) {
    const bool counts = part == ModeBank::kOld      ? glide.moving() && glide.has_old()
                        : part == ModeBank::kMiddle ? glide.moving()
                                                    : !glide.moving() || glide.has_latest();
    if (counts && part_model_[part])
      work(part, *part_model_[part]);
  }
}

/// Adds the contact forces of the sample that the solver has just computed, `at` samples into the
/// segment.
void StruckBody::add_direct_contacts(std::size_t at) noexcept {
  for (const ContactSolver::SampledForce& sampled : model_->solver.sampled())
    for_each_part([&](ModeBank::Part part, const BodyModel& m) {
      for (std::size_t l = 0; l < m.settings.listeners; ++l)
        direct_.add_moments(l, part, at, m.contact_kernel[sampled.slot][l], m.direct[l].taps(),
                            std::span<const double>(sampled.moments).first(m.direct[l].moments()));
    });
}

/// Adds the external force and the pulses at a sample of the chunk.
void StruckBody::add_direct_samples(std::size_t at, std::size_t sample) noexcept {
  const auto add = [&](std::size_t drive, float force) {
    for_each_part([&](ModeBank::Part part, const BodyModel& m) {
      for (std::size_t l = 0; l < m.settings.listeners; ++l)
        direct_.add_sample(l, part, at, m.sample_kernel[drive][l], m.direct[l].taps(),
                           static_cast<double>(force));
    });
  };
  if (const float force = chunk_.force[sample]; force != 0) {
    if (!point_kernels_valid_)
      build_point_kernels();
    add(0, force);
  }
  for (std::size_t i = 0; i < model_->settings.voices; ++i)
    if (pulses_[i].active && chunk_.pulse[i][sample] != 0)
      add(1 + i, chunk_.pulse[i][sample]);
}

/// Ends a segment of the chunk. `glide`: as at the segment's beginning.
void StruckBody::finish_direct(std::size_t from, std::size_t to, const Glide& glide) noexcept {
  for (std::size_t l = 0; l < model_->settings.listeners; ++l)
    direct_.finish(l, std::span(chunk_.output[l]).subspan(from, to - from), glide);
  if (to > from)
    last_force_ = static_cast<double>(chunk_.force[to - 1]);
  if (!glide.moving() || to - from < glide.left())
    return;
  const Glide& after = model_->bank.glide(0);
  direct_.rotate(glide, after);
  if (glide.has_latest()) {
    part_model_[ModeBank::kOld] = part_model_[ModeBank::kMiddle];
    part_model_[ModeBank::kMiddle] = part_model_[ModeBank::kLatest];
  }
  if (!after.moving())
    return use_current_kernels();
  if (!after.has_old())
    part_model_[ModeBank::kOld] = nullptr;
  part_model_[ModeBank::kLatest] = after.has_latest() ? model_.get() : nullptr;
  if (after.has_latest())
    carry_over_direct(*part_model_[ModeBank::kMiddle], model_->solver);
  retire_unused();
}

} // namespace tactus::modal
