#include "core/modal/body/body_model.hpp"

#include <algorithm>

/// BodyModel: the kernels of the direct sound at the points where forces act.
namespace tactus::modal {

void BodyModel::make_kernels() {
  sample_kernel.resize(1 + settings.voices);
  contact_kernel.resize(resting_slot() + resting_contacts.size());
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

/// True if some listener's kernels are summed over the modes, not over the surface.
bool BodyModel::needs_gains() const noexcept {
  return std::any_of(direct.begin(),
                     direct.begin() + static_cast<std::ptrdiff_t>(settings.listeners),
                     [](const DirectKernels& kernels) { return !kernels.on_surface(); });
}

DirectKernels::SurfaceGain BodyModel::surface_gain(const SurfacePoint& point,
                                                   const Vec3& direction) const noexcept {
  DirectKernels::SurfaceGain gain{};
  const double scale = shape_scale_of(loaded->part_of_triangle(point.triangle));
  for (std::size_t i = 0; i < 3; ++i)
    gain[i] = {static_cast<std::size_t>(loaded->table.triangle[point.triangle][i]),
               -scale * point.weight[i] * direction};
  return gain;
}

void BodyModel::build_point_kernels(const SurfacePoint& point, const Vec3& direction) noexcept {
  if (needs_gains())
    gains(point, direction, scratch);
  const RigidGain rigid = rigid_gains(point, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = sample_kernel[0][l];
    if (direct[l].on_surface())
      direct[l].assemble_samples(surface_gain(point, direction), kernel.elastic);
    else
      direct[l].assemble_samples(scratch, kernel.elastic);
    direct[l].assemble_rigid_samples(rigid, kernel.rigid);
  }
}

void BodyModel::build_pulse_kernels(std::size_t slot, const SurfacePoint& point,
                                    const Vec3& direction, std::span<const double> gain) noexcept {
  if (gain.empty() && needs_gains()) {
    gains(point, direction, scratch);
    for (std::size_t k = 0; k < scratch.size(); ++k)
      scratch[k] *= pulse_gain[k];
    gain = scratch;
  }
  const RigidGain rigid = rigid_gains(point, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = sample_kernel[1 + slot][l];
    if (direct[l].on_surface())
      direct[l].assemble_pulse(surface_gain(point, direction), kernel.elastic);
    else
      direct[l].assemble_samples(gain, kernel.elastic);
    direct[l].assemble_rigid_samples(rigid, kernel.rigid);
  }
}

void BodyModel::build_contact_kernels(std::size_t slot, const SurfacePoint& point,
                                      const Vec3& direction,
                                      std::span<const double> gain) noexcept {
  if (gain.empty() && needs_gains()) {
    gains(point, direction, scratch);
    gain = scratch;
  }
  const RigidGain rigid = rigid_gains(point, direction);
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    ForceKernel& kernel = contact_kernel[slot][l];
    if (direct[l].on_surface())
      direct[l].assemble_moments(surface_gain(point, direction), kernel.elastic);
    else
      direct[l].assemble_moments(gain, kernel.elastic);
    direct[l].assemble_rigid_moments(rigid, kernel.rigid);
  }
}

} // namespace tactus::modal
