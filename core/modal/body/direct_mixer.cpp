#include "core/modal/body/direct_mixer.hpp"

#include <algorithm>
#include <functional>

namespace tactus::modal {
namespace {

/// True if both have the same slots of contacts and the same number of listeners.
bool have_compatible_kernels(const BodyModel& one, const BodyModel& two) noexcept {
  return one.settings.sample_rate == two.settings.sample_rate &&
         one.settings.voices == two.settings.voices &&
         one.resting_contacts.size() == two.resting_contacts.size() &&
         one.settings.listeners == two.settings.listeners;
}

} // namespace

/// Calls work(model) for every model whose kernels sound.
template <class Work> void DirectMixer::for_each_model(Work&& work) noexcept {
  work(*model_);
  for (const ModelHandover::Use& previous : previous_)
    if (previous)
      work(*previous);
}

/// Calls work(part, model) for the parts of the glide with a weight above 0.
template <class Work> void DirectMixer::for_each_part(Work&& work) noexcept {
  const Glide& glide = model_->bank.glide(0);
  for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest}) {
    const bool counts = part == ModeBank::kOld      ? glide.moving() && glide.has_old()
                        : part == ModeBank::kMiddle ? glide.moving()
                                                    : !glide.moving() || glide.has_latest();
    if (counts && part_model_[part])
      work(part, *part_model_[part]);
  }
}

void DirectMixer::prepare(double sample_rate) {
  direct_.prepare(sample_rate);
  use_current_kernels();
}

void DirectMixer::set_point(const ForcePoint& point) noexcept {
  point_ = point;
  point_kernels_valid_ = false;
}

void DirectMixer::build_contact_kernels(std::size_t slot, const SurfacePoint& point,
                                        const Vec3& direction) noexcept {
  for_each_model([&](BodyModel& m) { m.build_contact_kernels(slot, point, direction); });
}

void DirectMixer::build_pulse_kernels(std::size_t slot, const SurfacePoint& point,
                                      const Vec3& direction) noexcept {
  for_each_model([&](BodyModel& m) {
    m.build_pulse_kernels(slot, point, direction,
                          &m == model_ ? std::span<const double>(m.scratch)
                                       : std::span<const double>());
  });
}

void DirectMixer::build_point_kernels() noexcept {
  point_kernels_valid_ = true;
  for_each_model([&](BodyModel& m) { m.build_point_kernels(point_.point, point_.direction); });
}

void DirectMixer::add_contacts(std::size_t at) noexcept {
  for (const ContactSolver::SampledForce& sampled : model_->solver.sampled())
    for_each_part([&](ModeBank::Part part, const BodyModel& m) {
      for (std::size_t l = 0; l < m.settings.listeners; ++l)
        direct_.add_moments(l, part, at, m.contact_kernel[sampled.slot][l], m.direct[l].taps(),
                            std::span<const double>(sampled.moments).first(m.direct[l].moments()));
    });
}

void DirectMixer::add_force(std::size_t at, float force) noexcept {
  if (force == 0)
    return;
  if (!point_kernels_valid_)
    build_point_kernels();
  add(0, at, force);
}

void DirectMixer::add_pulse(std::size_t slot, std::size_t at, float force) noexcept {
  if (force != 0)
    add(1 + slot, at, force);
}

void DirectMixer::add(std::size_t drive, std::size_t at, float force) noexcept {
  for_each_part([&](ModeBank::Part part, const BodyModel& m) {
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      direct_.add_sample(l, part, at, m.sample_kernel[drive][l], m.direct[l].taps(),
                         static_cast<double>(force));
  });
}

void DirectMixer::finish(ChannelBlock& output, std::span<const float> force, std::size_t from,
                         std::size_t to, const Glide& glide) noexcept {
  for (std::size_t l = 0; l < model_->settings.listeners; ++l)
    direct_.finish(l, std::span(output[l]).subspan(from, to - from), glide);
  if (to > from)
    last_force_ = static_cast<double>(force[to - 1]);
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
  part_model_[ModeBank::kLatest] = after.has_latest() ? model_ : nullptr;
  if (after.has_latest())
    carry_over(*part_model_[ModeBank::kMiddle], model_->solver);
  drop_unused();
}

void DirectMixer::exchange_body(BodyModel& model, const BodyModel* before, bool gliding) noexcept {
  model_ = &model;
  if (gliding)
    direct_.merge_parts(before->bank.glide(0));
  use_current_kernels();
}

void DirectMixer::continue_body(BodyModel& model, const ModelHandover::Use& before, bool gliding,
                                bool in_silence) noexcept {
  model_ = &model;
  if (in_silence || !have_compatible_kernels(model, *before)) {
    if (in_silence) {
      direct_.clear();
    } else { // sound in transit continues for the remaining listeners
      direct_.merge_parts(before->bank.glide(0));
      direct_.clear_from(model.settings.listeners);
    }
    return use_current_kernels();
  }
  // At most three parts sound, so that one of four is free.
  *std::find_if(previous_.begin(), previous_.end(), [](const auto& use) { return !use; }) = before;
  if (!gliding) {
    direct_.start();
    part_model_ = {nullptr, before.get(), model_};
    carry_over(*before, before->solver);
  }
  drop_unused();
}

/// From now on only the present model's kernels are used, whether the bank's weights glide or not.
void DirectMixer::use_current_kernels() noexcept {
  part_model_.fill(model_);
  drop_unused();
}

void DirectMixer::drop_unused() noexcept {
  for (ModelHandover::Use& previous : previous_)
    if (std::find(part_model_.begin(), part_model_.end(), previous.get()) == part_model_.end())
      previous = {};
}

/// Continues the latest part from an earlier model: forces that persist are assumed to have been
/// constant for a long time (DirectSound::add_history). `solver` has the present contacts.
void DirectMixer::carry_over(BodyModel& before, const ContactSolver& solver) noexcept {
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
  if (!model_->in_solver)
    return;
  for (const ContactSolver::SampledForce& sampled : solver.sampled())
    if (model_->solver.contact(sampled.slot).active)
      carry(latest.contact_kernel[sampled.slot], before.contact_kernel[sampled.slot],
            sampled.moments);
}

} // namespace tactus::modal
