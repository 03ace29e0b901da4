#pragma once

#include "core/contact/exciter.hpp"
#include "core/contact/pressed_contacts.hpp"

#include <cstddef>
#include <span>

/// The loops over modes that every step needs, one copy for each instruction set.
namespace tactus::contact {

/// A body's state and its coefficients for the steps at hand; arrays of whole vectors.
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

/// A force at a place with this shape, over sqrt(m).
struct PointForce {
  const double* shape;
  double force;
};

/// One step length. 2^level of them make a sample.
struct Steps {
  double length_s;
  std::size_t level;
};

/// One place on the body, for steps of one length: z <- P z + F g B. The place's free mean velocity
/// in the step after the next is linear in the state after the next and in the next force: ahead .
/// z + answer F. So the sums over modes of a step need not wait for its force, nor its force for
/// them.
struct PointView {
  const double* shape;                                                ///< g, over sqrt(m)
  const double *response_at_point_real, *response_at_point_imaginary; ///< g B
  const double *next_mean_real,
      *next_mean_imaginary; ///< free mean velocity of the step after this one
  double next_mobility;     ///< of the next step's mean velocity to this one's force
};

/// Sums over modes that a step leaves to the next ones.
struct Prediction {
  double free = 0; ///< the place's free mean velocity in the next step
  double base = 0; ///< and in the one after it, without the force of the next
};

/// Samples of one exciter in a row, as long as nothing but the steps themselves has to be done:
/// inputs, outputs, and what ends it early.
struct SampleBatch {
  const double* drive;  ///< force on the mass, N, or velocity of the rubbing surface, m/s
  const double* normal; ///< of friction, N
  double* output;       ///< velocity at the ear; null: not wanted
  double* force;        ///< mean of each sample; null: not wanted
  const double *pickup_real, *pickup_imaginary;
  std::size_t count;
};

/// Every instruction set gives the same bits: the same operations in the same order.
class BodyKernel {
public:
  virtual ~BodyKernel() = default;
  /// A step of a body that nothing touches.
  virtual void ring(const ModesView&) const noexcept = 0;
  /// The same, and dots() of the ear's arrays and the state after it.
  virtual double ring_with_output(const ModesView&, const double* pickup_real,
                                  const double* pickup_imaginary) const noexcept = 0;
  /// Foresight from the state alone.
  [[nodiscard]] virtual Prediction predict(const ModesView&, const PointView&) const noexcept = 0;
  /// Samples with one exciter on the body that is near; no outer forces. Returns how many: it ends
  /// early after one that leaves the exciter in need of a look (ExcitedBody::look_around).
  virtual std::size_t advance_contact(const ModesView&, const PointView&, Prediction&, Exciter&,
                                      Steps, const SampleBatch&) const noexcept = 0;
  /// mean[i] = the modes' mean velocity in a step with these forces. Null `outer`: none.
  virtual void mean(const ModesView&, const double* external, std::span<const PointForce>,
                    double* mean) const noexcept = 0;
  /// The same without forces.
  virtual void free_mean(const ModesView&, double* mean) const noexcept = 0;
  /// A step on under these forces.
  virtual void advance(const ModesView&, const double* external,
                       std::span<const PointForce>) const noexcept = 0;
  /// Marks the contacts of the blocks that are about to end or whose energy is no longer what their
  /// steps were chosen for. `look`: their depths anew from where all is.
  virtual void check_pressed(std::span<PressedBlock>, const double* real, const double* imaginary,
                             bool measure, double h) const noexcept = 0;
  /// Their step of a sample, from one state of the modes into another, which may be the same.
  /// Marks those that have ended, which are still to be released and booked, or that are not sane.
  virtual void press(std::span<PressedBlock>, const double* from_real, const double* from_imaginary,
                     double* real, double* imaginary, double sample_rate) const noexcept = 0;
  /// to += factor from
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
  /// Velocity at a place with this shape: sum of shape (real - slowing imaginary).
  [[nodiscard]] virtual double velocity(const double* shape, const double* real,
                                        const double* imaginary, const double* decay_over_omega,
                                        std::size_t padded) const noexcept = 0;
};

/// The widest that this processor runs.
[[nodiscard]] const BodyKernel& body_kernel() noexcept;
/// The one that every processor runs, for comparison.
[[nodiscard]] const BodyKernel& baseline_body_kernel() noexcept;

} // namespace tactus::contact
