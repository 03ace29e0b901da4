#include "core/modal/body/body_model.hpp"

#include <algorithm>

/// What forces on a body sound like besides its ringing modes: their kernels at the listeners.
namespace tactus::modal {

void BodyModel::make_kernels() {
  sample_kernel.resize(1 + settings.voices);
  contact_kernel.resize(rest_slot() + rests.size());
  for (std::size_t l = 0; l < kMaxListeners; ++l) {
    const std::size_t taps = direct[l].taps(), moments = direct[l].moments();
    const std::size_t rigid = direct[l].has_rigid() ? 1 : 0;
    for (auto& kernel : sample_kernel) {
      kernel[l].elastic.assign(taps, 0);
      kernel[l].rigid.assign(rigid * taps, 0);
    }
    for (auto& kernel : contact_kernel) {
      kernel[l].elastic.assign(moments * taps, 0);
      kernel[l].rigid.assign(rigid * moments * taps, 0);
    }
  }
}

/// Some listener's kernels are summed over the modes.
bool BodyModel::needs_gains() const noexcept {
  return std::any_of(direct.begin(),
                     direct.begin() + static_cast<std::ptrdiff_t>(settings.listeners),
                     [](const DirectKernels& kernels) { return !kernels.on_surface(); });
}

DirectKernels::SurfaceGain BodyModel::surface_gain(const SurfacePoint& place,
                                                   const Vec3& direction) const noexcept {
  DirectKernels::SurfaceGain gain{};
  const double scale = shape_scale_of(loaded->part_of_triangle(place.triangle));
  for (std::size_t i = 0; i < 3; ++i)
    gain[i] = {static_cast<std::size_t>(loaded->table.triangle[place.triangle][i]),
               -scale * place.weight[i] * direction};
  return gain;
}

void BodyModel::aim_point(const SurfacePoint& place, const Vec3& direction) noexcept {
  if (needs_gains())
    gains(place, direction, scratch);
  const RigidGain rigid = rigid_gains(place, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = sample_kernel[0][l];
    if (direct[l].on_surface())
      direct[l].assemble_samples(surface_gain(place, direction), kernel.elastic);
    else
      direct[l].assemble_samples(scratch, kernel.elastic);
    direct[l].assemble_rigid_samples(rigid, kernel.rigid);
  }
}

void BodyModel::aim_pulse(std::size_t slot, const SurfacePoint& place, const Vec3& direction,
                          std::span<const double> gain) noexcept {
  if (gain.empty() && needs_gains()) {
    gains(place, direction, scratch);
    for (std::size_t k = 0; k < scratch.size(); ++k)
      scratch[k] *= pulse_gain[k];
    gain = scratch;
  }
  const RigidGain rigid = rigid_gains(place, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = sample_kernel[1 + slot][l];
    if (direct[l].on_surface())
      direct[l].assemble_pulse(surface_gain(place, direction), kernel.elastic);
    else
      direct[l].assemble_samples(gain, kernel.elastic);
    direct[l].assemble_rigid_samples(rigid, kernel.rigid);
  }
}

void BodyModel::aim_contact(std::size_t slot, const SurfacePoint& place, const Vec3& direction,
                            std::span<const double> gain) noexcept {
  if (gain.empty() && needs_gains()) {
    gains(place, direction, scratch);
    gain = scratch;
  }
  const RigidGain rigid = rigid_gains(place, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = contact_kernel[slot][l];
    if (direct[l].on_surface())
      direct[l].assemble_moments(surface_gain(place, direction), kernel.elastic);
    else
      direct[l].assemble_moments(gain, kernel.elastic);
    direct[l].assemble_rigid_moments(rigid, kernel.rigid);
  }
}

} // namespace tactus::modal
