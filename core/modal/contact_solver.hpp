#pragma once

#include "core/modal/striker.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// A vibrating body and everything that touches it, in double precision and steps much shorter
/// than a contact.
///
/// Within a step h every contact force is constant, and modes (z = q' + alpha q + j omega_d q),
/// a free body's six rigid motions and the strikers answer it exactly: z goes to
/// e^(s h) z + b F (e^(s h) - 1)/s. The force is the contact's work divided by the way,
///   F = (W(d1) - W(d0)) / (d1 - d0)   (a discrete gradient: Gonzalez 1996),
/// so that what the contact stores is to the last bit of rounding what the bodies lose: no energy
/// arises for any step, stiffness or mode, and each step solves one equation for d1 a contact.
/// Forces of several contacts are found together, whatever their order.
class ContactSolver {
public:
  static constexpr std::size_t kRigid = 6;
  static constexpr unsigned kMostSteps = 1024; ///< in a sample, a power of 2

  /// Rates s of all modes, also those too high to be heard; room for so many contacts. `rigid`:
  /// the body is free to recoil.
  ContactSolver(std::span<const std::complex<double>> rate, double sample_rate,
                std::size_t contacts, bool rigid);

  struct Contact {
    ContactLaw law;
    double striker_mass_kg = 0.01;
    double place_m = 0;            ///< of the striker, inwards: at begin() from the surface as it
                                   ///< is, when led from the untouched surface
    double speed_m_per_s = 0;      ///< inwards
    double compliance_m_per_n = 0; ///< of the modes that the table left out
    bool led = false;              ///< its place is prescribed: a hand holds it
    bool active = false;
    double age_s = 0;
    double force_n = 0;            ///< mean of the last sample
    double compression_m = 0;
  };
  /// Starts a contact: b of all modes and of the rigid motions, 1/sqrt(kg).
  void begin(std::size_t slot, const Contact& contact, std::span<const double> gain,
             const std::array<double, kRigid>& rigid_gain) noexcept;
  void end(std::size_t slot) noexcept;
  /// Where a led striker shall be after the next step; it gets there no faster than a hand.
  void lead(std::size_t slot, double place_m, double fastest_m_per_s = 50) noexcept;
  /// Everything at rest, nothing touches.
  void silence() noexcept;
  [[nodiscard]] const Contact& contact(std::size_t slot) const noexcept { return contacts_[slot]; }
  [[nodiscard]] bool touching() const noexcept { return active_count_ > 0; }
  /// Steps that one sample takes now.
  [[nodiscard]] unsigned steps() const noexcept { return steps_; }

  /// One sample on. Contacts that are over for good become inactive. Returns the mean force, N.
  double step() noexcept;
  /// An impulse on the modes at once, N s, e.g. a sample of an outer force.
  void kick(std::span<const float> gain, double impulse) noexcept;
  /// Sum over modes of Im(w z).
  [[nodiscard]] double hear(std::span<const std::complex<double>> weight) const noexcept;

  [[nodiscard]] std::complex<double> state(std::size_t mode) const noexcept {
    return {real_[mode], imaginary_[mode]};
  }
  void set_state(std::size_t mode, std::complex<double> z) noexcept {
    real_[mode] = z.real();
    imaginary_[mode] = z.imag();
  }
  void rest_rigid() noexcept {
    rigid_place_.fill(0);
    rigid_speed_.fill(0);
  }
  [[nodiscard]] std::size_t modes() const noexcept { return real_.size(); }
  /// Energy of modes, rigid motion, strikers and elastic contacts, J.
  [[nodiscard]] double energy() const noexcept;

private:
  struct Slot {
    std::vector<double> gain, place_gain; ///< b and b/omega_d of the modes
    std::array<double, kRigid> rigid{};
    double mobility = 0; ///< 1/kg that the contact feels at once
  };
  void choose_steps(double wanted) noexcept;
  void work_out_answers() noexcept;
  void substep(double h) noexcept;
  [[nodiscard]] double surface_place(std::size_t slot) const noexcept;
  [[nodiscard]] double stored(const Contact& contact, double depth) const noexcept;
  [[nodiscard]] double elastic(const Contact& contact, double depth) const noexcept;
  /// The compression after a step that would end at `free` without force, and its force.
  [[nodiscard]] double solve(const Contact& contact, double free, double answer, double h,
                             double& force) const noexcept;
  void look_for_ends() noexcept;

  double sample_rate_;
  bool has_rigid_;
  std::vector<double> alpha_, omega_;
  std::vector<double> finest_real_, finest_imaginary_; ///< exp(s T / kMostSteps)
  std::vector<double> step_real_, step_imaginary_;     ///< of the step at work
  std::vector<double> push_real_, push_imaginary_;     ///< (exp(s h) - 1)/s
  std::vector<double> real_, imaginary_;
  std::array<double, kRigid> rigid_place_{}, rigid_speed_{};
  std::vector<Contact> contacts_;
  std::vector<Slot> slots_;
  std::vector<double> answer_;  ///< [i][j] m/N: place of contact i after a step with force at j
  std::vector<double> free_, force_, next_force_;
  std::vector<std::size_t> touching_; ///< the active contacts
  std::size_t active_count_ = 0;
  unsigned steps_ = 0;
};

} // namespace tactus::modal
