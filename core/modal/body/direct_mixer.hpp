#pragma once

#include "core/modal/body/events.hpp"
#include "core/modal/body/model_handover.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::modal {

/// The direct sound of the forces on a body (DirectSound). While the modes' weights glide from
/// model to model, forces are filtered by the kernels of each of these models, blended in step.
class DirectMixer {
public:
  /// Allocates, and drops all sound in transit.
  void prepare(double sample_rate);
  /// Where the external force acts.
  void set_point(const ForcePoint& point) noexcept;
  /// Sets the kernels of a contact's forces.
  void build_contact_kernels(std::size_t slot, const SurfacePoint& point,
                             const Vec3& direction) noexcept;
  /// Sets the kernels of a pulse, whose gains, without culled modes, are in the present model's
  /// `scratch`.
  void build_pulse_kernels(std::size_t slot, const SurfacePoint& point,
                           const Vec3& direction) noexcept;

  /// Add forces at sample `at` of the segment: those of the solver's last sample, the external
  /// force, and a pulse.
  void add_contacts(std::size_t at) noexcept;
  void add_force(std::size_t at, float force) noexcept;
  void add_pulse(std::size_t slot, std::size_t at, float force) noexcept;
  /// Ends the segment of samples `from` to `to` and adds its sound to `output`. `force`: the
  /// external force. `glide`: as at the segment's beginning.
  void finish(ChannelBlock& output, std::span<const float> force, std::size_t from, std::size_t to,
              const Glide& glide) noexcept;

  /// Makes `model` the present model. It is of another body than `before` (null: there was none).
  /// `gliding`: the weights of `before` were gliding. Sound in transit is kept.
  void exchange_body(BodyModel& model, const BodyModel* before, bool gliding) noexcept;
  /// Makes `model` the present model. It is of the same body as `before`; `in_silence`: nothing
  /// sounds. Earlier models are kept for as long as their kernels sound.
  void continue_body(BodyModel& model, const ModelHandover::Use& before, bool gliding,
                     bool in_silence) noexcept;
  /// The sound in transit.
  [[nodiscard]] DirectSound& sound() noexcept { return direct_; }

private:
  template <class Work> void for_each_model(Work&& work) noexcept;
  template <class Work> void for_each_part(Work&& work) noexcept;
  void add(std::size_t drive, std::size_t at, float force) noexcept;
  void build_point_kernels() noexcept;
  void use_current_kernels() noexcept;
  void drop_unused() noexcept;
  void carry_over(BodyModel& before, const ContactSolver& solver) noexcept;

  BodyModel* model_ = nullptr;
  /// Earlier models whose kernels still sound, and the model of each part of the glide.
  std::array<ModelHandover::Use, 4> previous_;
  std::array<BodyModel*, 3> part_model_{};
  DirectSound direct_;
  ForcePoint point_;
  bool point_kernels_valid_ = false; ///< the external force's kernels are those of the point
  double last_force_ = 0;            ///< N, the external force
};

} // namespace tactus::modal
