#pragma once

#include "core/contact/exciter.hpp"
#include "core/contact/pressed_contacts.hpp"
#include "core/dsp/vector_set.hpp"

#include <cstddef>
#include <span>

/// The loops over modes that every time step needs, implemented once per instruction set.
namespace tactus::contact {

/// State of a range of modes and their coefficients for one step length (ModalBody::Level). Every
/// array has `padded` numbers, a multiple of kModeLanes.
struct ModesView {
  double* real;
  double* imaginary;
  const double *pole_real, *pole_imaginary;         ///< P
  const double *response_real, *response_imaginary; ///< B
  const double *mean_real, *mean_imaginary;
  const double* mobility;
  const double* decay_over_omega;
  std::size_t padded;
};

/// A force, N, at a contact point with this shape over sqrt(m).
struct PointForce {
  const double* shape;
  double force;
};

/// Length of the steps, s; 2^level of them make a sample.
struct Steps {
  double length_s;
  std::size_t level;
};

/// One contact point for steps of one length, z <- P z + F g B. The free mean velocity (without
/// force) at the point in the next step but one is linear in the state z after this step and in the
/// force F of the next one:
///     next_mean_real . Re z + next_mean_imaginary . Im z + next_mobility F.
/// The sum over the modes is therefore computed one step ahead, so that the force need not wait for
/// it.
struct PointView {
  const double* shape;                                                ///< g, over sqrt(m)
  const double *response_at_point_real, *response_at_point_imaginary; ///< g B
  const double *next_mean_real, *next_mean_imaginary;
  double next_mobility; ///< m/(N s)
};

/// Sums over modes that are computed ahead.
struct Prediction {
  double free = 0; ///< free mean velocity of the point in the next step, m/s
  double base = 0; ///< free mean velocity in the step after the next, without the force of the next
                   ///< step, m/s
};

/// Inputs and outputs of several samples in a row in which only one exciter acts on the body.
struct SampleBatch {
  const double* drive;  ///< force on the mass, N, or velocity of the rubbing surface, m/s
  const double* normal; ///< normal force, N; friction only
  double* output;       ///< velocity at the pickup, m/s; null: not computed
  double* force;        ///< mean contact force of each sample, N; null: not computed
  const double *pickup_real, *pickup_imaginary; ///< weights of the state in the velocity at the
                                                ///< pickup
  std::size_t count;                            ///< samples
};

/// Interface of the loops. Every instruction set does the same operations in the same order, so all
/// give the same bits.
class BodyKernel {
public:
  virtual ~BodyKernel() = default;
  /// A step without forces.
  virtual void ring(const ModesView&) const noexcept = 0;
  /// A step without forces. Returns dots() of the pickup's arrays and the state after the step.
  virtual double ring_with_output(const ModesView&, const double* pickup_real,
                                  const double* pickup_imaginary) const noexcept = 0;
  /// Computes the sums that advance_contact() starts with, from the state.
  [[nodiscard]] virtual Prediction predict(const ModesView&, const PointView&) const noexcept = 0;
  /// Advances a body with one near exciter by up to batch.count samples.
  /// Returns the number of samples done. It stops early after a sample that requires a new
  /// ExcitedBody::update_proximity().
  virtual std::size_t advance_contact(const ModesView&, const PointView&, Prediction&, Exciter&,
                                      Steps, const SampleBatch&) const noexcept = 0;
  /// mean[i] = mean velocity of mode i in a step under these forces.
  virtual void mean(const ModesView&, std::span<const PointForce>, double* mean) const noexcept = 0;
  /// mean[i] = mean velocity of mode i in a step without forces.
  virtual void free_mean(const ModesView&, double* mean) const noexcept = 0;
  /// Advances the state by a step under these forces.
  virtual void advance(const ModesView&, std::span<const PointForce>) const noexcept = 0;
  /// Marks the contacts that are about to end, or whose energy no longer fits their step length h.
  /// With `measure`, it first recomputes their depths from the positions of mass and surface.
  virtual void check_pressed(std::span<PressedBlock>, const double* real, const double* imaginary,
                             bool measure, double h) const noexcept = 0;
  /// Advances the contacts by a step of one sample, from one state of the modes to another; both
  /// may be the same memory. Marks the contacts that have ended, or whose state is out of range.
  virtual void press(std::span<PressedBlock>, const double* from_real, const double* from_imaginary,
                     double* real, double* imaginary, double sample_rate) const noexcept = 0;
  /// to += factor from.
  virtual void add(double* to, const double* from, double factor,
                   std::size_t padded) const noexcept = 0;
  /// Sum of a b.
  [[nodiscard]] virtual double dot(const double* a, const double* b,
                                   std::size_t padded) const noexcept = 0;
  /// Sum of a b c.
  [[nodiscard]] virtual double dot(const double* a, const double* b, const double* c,
                                   std::size_t padded) const noexcept = 0;
  /// Sum of a b + c d.
  [[nodiscard]] virtual double dots(const double* a, const double* b, const double* c,
                                    const double* d, std::size_t padded) const noexcept = 0;
  /// Velocity at a point with this shape, m/s: sum of shape (real - decay_over_omega imaginary).
  [[nodiscard]] virtual double velocity(const double* shape, const double* real,
                                        const double* imaginary, const double* decay_over_omega,
                                        std::size_t padded) const noexcept = 0;
};

/// The implementation for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] const BodyKernel* body_kernel(simd::VectorSet widest) noexcept;
[[nodiscard]] const BodyKernel* body_kernel(simd::Baseline) noexcept;
[[nodiscard]] const BodyKernel* body_kernel(simd::Avx2) noexcept;

} // namespace tactus::contact
