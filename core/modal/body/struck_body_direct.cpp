#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <functional>
#include <utility>

/// What the forces on a StruckBody sound like besides the modes that ring. While the weights of the
/// modes glide from model to model, forces sound by the kernels of those models, in step.
namespace tactus::modal {

/// Every model whose kernels are heard, or will be.
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

/// The gains that are left of the modes are in the present model's `scratch`.
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

/// A model of the same body has come, the one before given; `moving`: its weights were gliding. The
/// models before stay for as long as their kernels are heard.
void StruckBody::take_over_direct(Handover* before, bool moving) noexcept {
  const auto free_entry = std::find(previous_models_.begin(), previous_models_.end(), nullptr);
  *free_entry = before; // three parts at most are heard, so one of four is free
  if (!moving) {
    direct_.start();
    part_ = {nullptr, before->model.get(), model_.get()};
    carry_over_direct(*before->model, before->model->solver);
  }
  retire_unused();
}

/// Only the present model's kernels count from now on, whether the bank's weights glide or not.
void StruckBody::use_current_kernels() noexcept {
  part_.fill(model_.get());
  retire_unused();
}

void StruckBody::retire_unused() noexcept {
  for (Handover*& previous : previous_models_)
    if (previous && std::find(part_.begin(), part_.end(), previous->model.get()) == part_.end())
      retire(std::exchange(previous, nullptr));
}

/// The freshest part goes on from a model before: forces that go on are taken as having acted for
/// long. `solver` has the present contacts.
void StruckBody::carry_over_direct(BodyModel& before, const ContactSolver& solver) noexcept {
  const BodyModel& latest = *part_[ModeBank::kLatest];
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

/// Calls work(part, model) for the parts that a force sounds by.
template <class Work> void StruckBody::for_each_part(Work&& work) noexcept {
  const Glide& glide = model_->bank.glide(0);
  for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest}) {
    const bool counts = part == ModeBank::kOld      ? glide.moving() && glide.has_old()
                        : part == ModeBank::kMiddle ? glide.moving()
                                                    : !glide.moving() || glide.has_latest();
    if (counts && part_[part])
      work(part, *part_[part]);
  }
}

/// Of the sample that the solver has just worked, `at` samples into the segment.
void StruckBody::add_direct_contacts(std::size_t at) noexcept {
  for (const ContactSolver::SampledForce& sampled : model_->solver.sampled())
    for_each_part([&](ModeBank::Part part, const BodyModel& m) {
      for (std::size_t l = 0; l < m.settings.listeners; ++l)
        direct_.add_moments(l, part, at, m.contact_kernel[sampled.slot][l], m.direct[l].taps(),
                            std::span<const double>(sampled.moments).first(m.direct[l].moments()));
    });
}

/// Of the force inlet and of pulses, at a sample of the chunk.
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

/// `glide`: as it was when the segment began.
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
    part_[ModeBank::kOld] = part_[ModeBank::kMiddle];
    part_[ModeBank::kMiddle] = part_[ModeBank::kLatest];
  }
  if (!after.moving())
    return use_current_kernels();
  if (!after.has_old())
    part_[ModeBank::kOld] = nullptr;
  part_[ModeBank::kLatest] = after.has_latest() ? model_.get() : nullptr;
  if (after.has_latest())
    carry_over_direct(*part_[ModeBank::kMiddle], model_->solver);
  retire_unused();
}

} // namespace tactus::modal
