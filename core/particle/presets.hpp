#pragma once

#include "core/particle/cloud.hpp"
#include "core/particle/ringing_body.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace tactus::particle {

/// Particles that have a name, and the body that they strike.
struct Preset {
  std::string_view name;
  CloudSettings cloud{};
  double direct = 1; ///< share of the grains that is heard beside the body
  std::size_t mode_count = 0;
  std::array<RingingMode, RingingBody::kMaxModes> modes{};

  [[nodiscard]] std::span<const RingingMode> body() const noexcept {
    return std::span(modes).first(mode_count);
  }
};

/// All presets, the maraca first. docs/particle.md says where each number comes from; the levels
/// alone are set by measurement, so that at a constant energy of 1 one sample in 10^4 exceeds 0.4.
[[nodiscard]] std::span<const Preset> presets() noexcept;
/// Null when there is none of that name.
[[nodiscard]] const Preset* find_preset(std::string_view name) noexcept;

/// The maraca's numbers, with which [particle~] begins.
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
