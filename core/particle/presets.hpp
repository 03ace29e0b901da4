#pragma once

#include "core/particle/cloud.hpp"
#include "core/particle/ringing_body.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace tactus::particle {

/// A named set of particles and of the body that they strike.
struct Preset {
  std::string_view name;
  CloudSettings cloud{};
  double direct = 1; ///< gain of the direct sound of the particles
  std::size_t mode_count = 0;
  std::array<RingingMode, RingingBody::kMaxModes> modes{};

  [[nodiscard]] std::span<const RingingMode> body() const noexcept {
    return std::span(modes).first(mode_count);
  }
};

/// All presets, the maraca first. docs/theory/particle.md gives the source of each number. Only the
/// levels are set by measurement: at a constant energy of 1, one sample in 10^4 exceeds 0.4.
[[nodiscard]] std::span<const Preset> presets() noexcept;
/// The preset of this name, or null.
[[nodiscard]] const Preset* find_preset(std::string_view name) noexcept;

/// The maraca: initial settings of [particle~].
inline constexpr CloudSettings kMaraca{.count = 24.4,
                                       .attack_s = 0.005,
                                       .decay_s = 0.0453,
                                       .exponent = 1,
                                       .largest = 1.001,
                                       .frequency_hz = 3200,
                                       .spread = 0,
                                       .lower_by_size = 0,
                                       .quality = 11.2,
                                       .length_s = 0.00088,
                                       .rise = 0,
                                       .level = 0.0143};

} // namespace tactus::particle
