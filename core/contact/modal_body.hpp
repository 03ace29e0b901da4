#pragma once

#include "core/contact/mode_array.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::contact {

/// One mode of vibration: m (q'' + 2 d q' + (omega^2 + d^2) q) = force on it, d = ln(1000)/t60.
struct Mode {
  double frequency_hz = 440; ///< 0: a free body's rigid motion, of that mass or inertia
  double t60_s = 1;
  double mass_kg = 1; ///< modal mass for shapes of the size used
};

/// Finest division of a sample: 2^6.
inline constexpr std::size_t kLevels = 7;

/// The modes of a body, ready for steps of T, T/2, ... T/64.
///
/// A mode's state is z = sqrt(m) (q' + d q + j omega q). Within a step the force is constant, and z
/// goes exactly to
///     P z + F/sqrt(m) B,   P = e^(s h),   B = (P - 1)/s,   s = -d + j omega
/// so frequency, decay, velocity and displacement are right at any frequency and step, and the mean
/// velocity of a step is (q after - q before)/h.
///
/// The energy of a mode is that of its velocity and displacement, (m q'^2 + m (omega^2 + d^2)
/// q^2)/2; new frequencies, decay times or masses change neither part.
class ModalBody {
public:
  explicit ModalBody(std::size_t max_modes);

  void prepare(double sample_rate) noexcept;
  /// Modes beyond the most are left out; those of 0.49 of the sample rate and above cannot be
  /// heard and are left out as well.
  void set_modes(std::span<const Mode> modes) noexcept;

  /// What a step of one length does; of a force F, F/sqrt(m) counts.
  struct Level {
    ModeArray pole_real, pole_imaginary;         ///< P
    ModeArray response_real, response_imaginary; ///< B
    ModeArray mean_real,
        mean_imaginary; ///< mean velocity of a step = these times the state's parts
    ModeArray mobility; ///< mean velocity for a force, s
  };
  [[nodiscard]] const Level& level(std::size_t index) const noexcept { return levels_[index]; }
  [[nodiscard]] std::size_t modes() const noexcept { return count_; }
  [[nodiscard]] std::size_t max_modes() const noexcept { return max_modes_; }
  /// Modes rounded up to whole vectors.
  [[nodiscard]] std::size_t padded() const noexcept {
    return (count_ + kModeLanes - 1) / kModeLanes * kModeLanes;
  }
  /// 1/sqrt(m) of a mode, 0 if it is left out.
  [[nodiscard]] double inverse_sqrt_mass(std::size_t mode) const noexcept {
    return inverse_sqrt_mass_[mode];
  }
  [[nodiscard]] double sample_rate() const noexcept { return sample_rate_; }

  ModeArray real, imaginary;  ///< z
  ModeArray displacement;     ///< 1/omega: sqrt(m) q = imaginary part times it
  ModeArray decay_over_omega; ///< d/omega: sqrt(m) q' = real part - imaginary part times it
  /// J.
  [[nodiscard]] double energy() const noexcept;
  /// Modes too quiet for normal numbers come to rest. False if a state is not finite.
  bool flush_denormals() noexcept;
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
