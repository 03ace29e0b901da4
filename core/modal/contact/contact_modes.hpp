#pragma once

#include "core/modal/contact/contact_kernel.hpp"

#include <complex>
#include <cstddef>
#include <memory>
#include <span>

namespace tactus::modal {

/// The modes of a body that something touches, stepped in any part of a sample by forces that are
/// constant within a step: z goes to p z + b F (p - 1)/s, p = exp(s h), z as in ModeBank.
///
/// A step's force enters the state in the pass over all modes that makes the next step, so that a
/// step reads and writes every mode once; bodies of so many modes that reading them is what takes
/// the time make two steps in a pass. Up to kMaxModesInDouble modes are kept in double precision,
/// larger bodies in single: their energy is then true to rounding in float.
class ContactModes {
public:
  static constexpr std::size_t kMaxStepsAhead = 2; ///< steps in a pass
  static constexpr std::size_t kMaxModesInDouble = 512;

  /// Steps of a sample are a power of 2, at most `max_steps`.
  [[nodiscard]] static std::unique_ptr<ContactModes>
  make(std::span<const std::complex<double>> rate, double sample_rate, unsigned max_steps,
       std::size_t contacts, std::size_t listeners, VectorSet set = best_vector_set());
  virtual ~ContactModes() = default;

  virtual void set_steps(unsigned steps) noexcept = 0;
  /// Gains b at a contact's place, 1/sqrt(kg); those that are not given are zero. Returns the sum
  /// of their squares: the mobility against a blow, 1/kg.
  virtual double set_gain(std::size_t slot, std::span<const double> gain) noexcept = 0;
  /// The contact is over: nothing is worked out for it any more.
  virtual void drop(std::size_t slot) noexcept = 0;
  /// Displacement at contact `to`, for 1 N at `from` in the step before last `lag`, m/N.
  [[nodiscard]] virtual double compliance(std::size_t to, std::size_t from,
                                          std::size_t lag) noexcept = 0;

  /// Looks `steps` steps ahead: after the forces given so far, without new ones, where is the
  /// contact's place after each step, m?
  [[nodiscard]] virtual const double* predict_displacement(std::size_t slot, std::size_t steps,
                                                           bool ends_sample) noexcept = 0;
  /// The forces of these steps there, N, one for each; they are taken in with the next pass.
  virtual void apply_forces(const double* force) noexcept = 0;
  /// A force of the last step at another contact.
  virtual void apply_force_beside(std::size_t slot, double force) noexcept = 0;
  /// Where another contact's place is in the state that predict_displacement() has left; one step
  /// ahead only.
  [[nodiscard]] virtual double displacement_beside(std::size_t slot) noexcept = 0;

  /// Everything given is in the state.
  virtual void settle() noexcept = 0;
  /// Displacement at a contact's place, m, with all that has been given.
  [[nodiscard]] virtual double displacement(std::size_t slot) noexcept = 0;
  /// Velocity there without the decay's part, sum b (q' + alpha q), m/s.
  [[nodiscard]] virtual double velocity(std::size_t slot) noexcept = 0;
  virtual void set_weight(std::size_t listener,
                          std::span<const std::complex<double>> weight) noexcept = 0;
  /// Only so many listeners hear from now on, the first ones.
  virtual void set_listening(std::size_t listeners) noexcept = 0;
  /// Sum over modes of Im(w z).
  [[nodiscard]] virtual double output(std::size_t listener) noexcept = 0;
  /// The same with other weights, slower.
  [[nodiscard]] virtual double output(std::span<const std::complex<double>> weight) noexcept = 0;
  virtual void apply_impulse(std::span<const float> gain, double impulse) noexcept = 0;
  [[nodiscard]] virtual std::complex<double> state(std::size_t mode) const noexcept = 0;
  virtual void set_state(std::size_t mode, std::complex<double> z) noexcept = 0;
  /// All of them, or the first ones; the others are at rest.
  virtual void read_states(std::span<std::complex<double>> z) noexcept = 0;
  virtual void write_states(std::span<const std::complex<double>> z) noexcept = 0;
  virtual void silence() noexcept = 0;

  /// Bounds of what the modes can do at a contact's place without forces: all amplitudes together,
  /// and the squares' sums.
  struct Reach {
    double displacement = 0, speed = 0, displacement_square = 0, speed_square = 0;
  };
  [[nodiscard]] virtual Reach reach(std::size_t slot) noexcept = 0;
};

} // namespace tactus::modal
