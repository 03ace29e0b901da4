#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/contact/contact_kernel.hpp"

#include <cstddef>
#include <memory>
#include <span>

namespace tactus::modal {

/// The modes of a body in contact, advanced in steps h that are a fraction of a sample.
///
/// A force F that is constant within a step moves a mode exactly: z goes to p z + b F (p - 1)/s,
/// with p = exp(s h) and z as in ModeBank. The force of a step is added in the pass that computes
/// the next step, so that a step reads and writes every mode once. A pass can compute two steps,
/// which halves the memory traffic of large bodies. Up to kMaxModesInDouble modes are computed in
/// double precision, a larger number in single precision, where energy is conserved to float
/// rounding.
class ContactModes {
public:
  static constexpr std::size_t kMaxStepsAhead = 2; ///< steps in a pass
  static constexpr std::size_t kMaxModesInDouble = 512;

  /// Allocates. `rate`: s of the modes in 1/s. `max_steps`: the largest number of steps in a
  /// sample, a power of 2. `contacts`, `listeners`: the number of slots.
  [[nodiscard]] static std::unique_ptr<ContactModes>
  make(std::span<const Complex> rate, double sample_rate, unsigned max_steps, std::size_t contacts,
       std::size_t listeners, VectorSet widest = simd::kWidest);
  virtual ~ContactModes() = default;

  /// Sets the number of steps in a sample, a power of 2 up to `max_steps`.
  virtual void set_steps(unsigned steps) noexcept = 0;
  /// Sets the gains b at a contact point, 1/sqrt(kg); missing gains are zero. Returns the sum of
  /// their squares, in 1/kg: the velocity of the point per impulse.
  virtual double set_gain(std::size_t slot, std::span<const double> gain) noexcept = 0;
  [[nodiscard]] virtual double gain(std::size_t slot, std::size_t mode) const noexcept = 0;
  /// Ends a contact: nothing is computed for its slot until the next set_gain().
  virtual void remove_contact(std::size_t slot) noexcept = 0;
  /// Displacement at contact `to` at the end of a step, m/N, per force at `from` in that step
  /// (lag 0) or in the step before (lag 1).
  [[nodiscard]] virtual double compliance(std::size_t to, std::size_t from,
                                          std::size_t lag) noexcept = 0;

  /// Advances by `steps` steps (1 or 2) without new forces. Returns the displacement of the contact
  /// point after each step, m. `ends_sample`: the last step is the last of its sample, so that
  /// outputs are computed.
  [[nodiscard]] virtual const double* predict_displacement(std::size_t slot, std::size_t steps,
                                                           bool ends_sample) noexcept = 0;
  /// Sets the contact's forces in these steps, N, one for each step; the forces enter the state in
  /// the next pass.
  virtual void apply_forces(const double* force) noexcept = 0;
  /// The force of the last step at another contact, N.
  virtual void apply_force_at(std::size_t slot, double force) noexcept = 0;
  /// The displacement of another contact point after predict_displacement() with one step, m.
  [[nodiscard]] virtual double predicted_displacement(std::size_t slot) noexcept = 0;

  /// Applies the forces that the state does not contain yet.
  virtual void flush_pending() noexcept = 0;
  /// Displacement of a contact point, m, after flush_pending().
  [[nodiscard]] virtual double displacement(std::size_t slot) noexcept = 0;
  /// The sum of b (q' + alpha q) at a contact point, m/s: its velocity apart from the decay term.
  [[nodiscard]] virtual double velocity(std::size_t slot) noexcept = 0;
  /// Sets a listener's weights w, Pa s/(m sqrt(kg)).
  virtual void set_weight(std::size_t listener, std::span<const Complex> weight) noexcept = 0;
  /// From now on only the first `listeners` outputs are computed.
  virtual void set_listening(std::size_t listeners) noexcept = 0;
  /// The sum over the modes of Im(w z).
  [[nodiscard]] virtual double output(std::size_t listener) noexcept = 0;
  /// The sum over the modes of Im(w z) with weights that are not set; slower.
  [[nodiscard]] virtual double output(std::span<const Complex> weight) noexcept = 0;
  /// An impulse in N s on all modes at once, by float gains b.
  virtual void apply_impulse(std::span<const float> gain, double impulse) noexcept = 0;
  [[nodiscard]] virtual Complex state(std::size_t mode) const noexcept = 0;
  virtual void set_state(std::size_t mode, Complex z) noexcept = 0;
  /// Read or write all states, or the first ones. Writing sets the other states to zero.
  virtual void read_states(std::span<Complex> z) noexcept = 0;
  virtual void write_states(std::span<const Complex> z) noexcept = 0;
  virtual void silence() noexcept = 0;

  /// Upper bounds of the motion of a contact point while no force acts: the sums of all modes'
  /// amplitudes (m, m/s), and the sums of their squares.
  struct MotionBounds {
    double displacement = 0, speed = 0, displacement_square = 0, speed_square = 0;
  };
  [[nodiscard]] virtual MotionBounds motion_bounds(std::size_t slot) noexcept = 0;
};

} // namespace tactus::modal
