#pragma once

#include "core/particle/cloud.hpp"
#include "core/rows.hpp"

#include <array>
#include <string_view>

/// One row for each member of CloudSettings.
namespace tactus::particle {

inline constexpr std::array<std::string_view, 3> kKinds{"grains", "bubbles", "rustle"};
/// Rows whose initial values are those of `first`.
[[nodiscard]] constexpr auto cloud_rows(const CloudSettings& first) {
  return std::array{
      member<&CloudSettings::kind>.row(
          "kind", kKinds,
          "kind of particles: single noisy grains, bubbles, or a rustle of very many grains",
          static_cast<double>(first.kind)),
      member<&CloudSettings::count>.row("count", "", first.count, 0, 50000,
                                        "collisions for each unit of energy"),
      member<&CloudSettings::decay_s>.row("decay", "s", first.decay_s, 1e-4, 60,
                                          "time in which the energy falls to 1/e"),
      member<&CloudSettings::attack_s>.row("attack", "s", first.attack_s, 1e-4, 5,
                                           "time constant of the rise of a shake's energy"),
      member<&CloudSettings::exponent>.row(
          "exponent", "", first.exponent, 0.05, 20,
          "exponent of the distribution of collision energies e: ~ e^-(exponent + 1)"),
      member<&CloudSettings::largest>.row(
          "largest", "", first.largest, 1.001, 1e6,
          "ratio of largest to smallest collision energy; 1.001: nearly equal"),
      member<&CloudSettings::frequency_hz>.row(
          "frequency", "Hz", first.frequency_hz, 20, 20000,
          "median frequency of the grains; with `lower_by_size`, of the smallest grains"),
      member<&CloudSettings::spread>.row(
          "spread", "", first.spread, 0, 3,
          "standard deviation of the natural logarithm of the frequency"),
      member<&CloudSettings::lower_by_size>.row(
          "lower_by_size", "", first.lower_by_size, 0, 2,
          "exponent that makes large grains lower: frequency ~ collision energy^-exponent"),
      member<&CloudSettings::quality>.row("quality", "", first.quality, 0.1, 200,
                                          "quality factor of a grain's band-pass"),
      member<&CloudSettings::length_s>.row("length", "s", first.length_s, 1e-5, 1,
                                           "median time in which a grain's amplitude falls to 1/e"),
      member<&CloudSettings::rise>.row("rise", "", first.rise, 0, 1,
                                       "rise of a bubble's pitch while it decays"),
      member<&CloudSettings::level>.row("level", "", first.level, 0, 1e4,
                                        "amplitude of new collisions"),
  };
}
inline constexpr auto kCloudRows = cloud_rows({});

} // namespace tactus::particle
