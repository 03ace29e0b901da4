#pragma once

#include "core/contact/mode_array.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::contact {

/// One mode of vibration: m (q'' + 2 d q' + (omega^2 + d^2) q) = force on it, d = ln(1000)/t60.
struct Mode {
  double frequency_hz = 440;
  double t60_s = 1;
  double mass_kg = 1; ///< modal mass for shapes of the size used
};

/// Finest division of a sample: 2^6.
inline constexpr std::size_t kLevels = 7;

/// The modes of a body, ready for steps of T, T/2, ... T/64.
///
/// A mode's state is a = sqrt(m) q' and p = sqrt(m) w q, so that its energy is (a^2 + p^2)/2. The
/// midpoint rule, which keeps energies exact, would put its poles where they do not belong
/// (warping); so frequency and damping of each step length are chosen such that its poles are
/// exactly R exp(+-j omega h), R = exp(-d h):
///     g = 2R cos(omega h)/(1+R^2),  W = (1-g)/(1+g) = (w h/2)^2,  s h = (1+W)(1-R^2)/(1+R^2)
///     mean a = b (a - sqrt(W) p + F h/2 / sqrt(m)),  b = 1/(1 + s h + W)
///     p += 2 sqrt(W) mean a,   a <- 2 mean a - a
/// Velocities are right at any frequency; displacements, sqrt(m) q = p h/(2 sqrt(W)), by the factor
/// (omega h/2)/tan(omega h/2), 1 for a mode far below the rate of steps.
///
/// As energy is in (a, p) alone, neither another step length nor new frequencies, decay times or
/// masses change the energy of a body that sounds.
class ModalBody {
public:
  explicit ModalBody(std::size_t most_modes);

  void prepare(double sample_rate) noexcept;
  /// Modes beyond the most are left out; those of 0.49 of the sample rate and above cannot be
  /// heard and are left out as well.
  void set_modes(std::span<const Mode> modes) noexcept;

  struct Level {
    ModeArray mean;         ///< b
    ModeArray turn;         ///< sqrt(W)
    ModeArray displacement; ///< h/(2 sqrt(W)) = 1/w
  };
  [[nodiscard]] const Level& level(std::size_t index) const noexcept { return levels_[index]; }
  [[nodiscard]] std::size_t modes() const noexcept { return count_; }
  [[nodiscard]] std::size_t most_modes() const noexcept { return most_; }
  /// Modes rounded up to whole vectors.
  [[nodiscard]] std::size_t padded() const noexcept {
    return (count_ + kModeLanes - 1) / kModeLanes * kModeLanes;
  }
  /// 1/sqrt(m) of a mode, 0 if it is left out.
  [[nodiscard]] double per_root_mass(std::size_t mode) const noexcept {
    return per_root_mass_[mode];
  }
  [[nodiscard]] double sample_rate() const noexcept { return sample_rate_; }

  ModeArray velocity;  ///< a
  ModeArray potential; ///< p
  /// J.
  [[nodiscard]] double energy() const noexcept;
  /// Modes too quiet for normal numbers come to rest. False if a state is not finite.
  bool tidy() noexcept;
  void silence() noexcept;

private:
  void work_out() noexcept;

  std::size_t most_, count_ = 0;
  double sample_rate_ = 48000;
  std::vector<Mode> wanted_;
  ModeArray per_root_mass_;
  std::array<Level, kLevels> levels_;
};

} // namespace tactus::contact
