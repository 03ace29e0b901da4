#pragma once

#include "core/contact/mode_array.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::contact {

/// One mode of vibration of a linear body:
///     m (q'' + 2 d q' + (omega^2 + d^2) q) = F,   d = ln(1000)/t60
/// q is the modal displacement in m, F the modal force in N. omega is the angular frequency of the
/// damped vibration.
struct Mode {
  double frequency_hz = 440; ///< 0: rigid motion of a free body with mass_kg as its mass or inertia
  double t60_s = 1;
  double mass_kg = 1; ///< modal mass m; its value depends on the scale of the mode shapes
};

/// A sample is divided into 2^0 ... 2^6 steps; level l has 2^l steps.
inline constexpr std::size_t kLevels = 7;

/// The modes of a vibrating body and their exact time steps of length T, T/2, ... T/64, T being one
/// sample.
///
/// The state of a mode is z = sqrt(m) (q' + d q + j omega q), in sqrt(J). For a force F that is
/// constant within a step of length h, z goes exactly to
///     P z + F/sqrt(m) B,   P = e^(s h),   B = (P - 1)/s,   s = -d + j omega.
/// So frequency, decay, velocity and displacement are exact for any frequency and step length. The
/// mean velocity of a step is (q after - q before)/h.
///
/// The energy of a mode is (m q'^2 + m (omega^2 + d^2) q^2)/2, in J. New frequencies, decay times,
/// masses or sample rates keep the kinetic and the potential part of each mode.
class ModalBody {
public:
  explicit ModalBody(std::size_t max_modes);

  /// Sample rate in Hz, clamped to 1 kHz ... 10 MHz.
  void prepare(double sample_rate) noexcept;
  /// Modes after max_modes() are ignored. Modes at 0.49 of the sample rate and above do not
  /// vibrate: all their coefficients are 0.
  void set_modes(std::span<const Mode> modes) noexcept;

  /// Coefficients of a step of one length, by mode. Velocities and forces are scaled: sqrt(m) q'
  /// and F/sqrt(m).
  struct Level {
    ModeArray pole_real, pole_imaginary;         ///< P
    ModeArray response_real, response_imaginary; ///< B, s
    /// Mean velocity of a step without force = mean_real Re z + mean_imaginary Im z.
    ModeArray mean_real, mean_imaginary;
    ModeArray mobility; ///< mean velocity per force, s
  };
  [[nodiscard]] const Level& level(std::size_t index) const noexcept { return levels_[index]; }
  [[nodiscard]] std::size_t modes() const noexcept { return count_; }
  [[nodiscard]] std::size_t max_modes() const noexcept { return max_modes_; }
  /// modes() rounded up to a multiple of kModeLanes.
  [[nodiscard]] std::size_t padded() const noexcept {
    return (count_ + kModeLanes - 1) / kModeLanes * kModeLanes;
  }
  /// 1/sqrt(m) of a mode in kg^(-1/2); 0 if the mode does not vibrate.
  [[nodiscard]] double inverse_sqrt_mass(std::size_t mode) const noexcept {
    return inverse_sqrt_mass_[mode];
  }
  [[nodiscard]] double sample_rate() const noexcept { return sample_rate_; }

  ModeArray real, imaginary;  ///< z
  ModeArray displacement;     ///< 1/omega, s: sqrt(m) q = displacement Im z
  ModeArray decay_over_omega; ///< d/omega: sqrt(m) q' = Re z - decay_over_omega Im z
  /// Energy of all modes, J.
  [[nodiscard]] double energy() const noexcept;
  /// Sets modes below 1e-20 sqrt(J) to 0, so that no denormal numbers are computed. Returns false
  /// if a state is NaN or beyond 1e60 sqrt(J).
  bool flush_denormals() noexcept;
  /// Sets all states to 0.
  void silence() noexcept;

private:
  void compute() noexcept;

  std::size_t max_modes_, count_ = 0;
  double sample_rate_ = 48000;
  std::vector<Mode> requested_;
  ModeArray inverse_sqrt_mass_;
  std::array<Level, kLevels> levels_;
};

} // namespace tactus::contact
