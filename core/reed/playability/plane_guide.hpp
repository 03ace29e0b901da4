#pragma once

#include "core/reed/playability/growth_map.hpp"
#include "core/reed/playability/guidance.hpp"

#include <cmath>

namespace tactus::reed {

/// The settings that a map by linear theory depends on.
struct PlaneSettings {
  PlayingSetup playing; // valve with the player's lips, length of the bore, factor on f_r
  ControlRange range;
  unsigned revision = 0; // counts changes of parameters and range

  /// True if a map for the other settings is valid for these: lengths and lips within 0.1 %.
  [[nodiscard]] bool matches(const PlaneSettings& other) const noexcept {
    const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-3 * b; };
    return revision == other.revision && near(playing.length, other.playing.length) &&
           near(playing.reed_scale, other.playing.reed_scale);
  }
};

/// A finished GrowthMap as lookup tables for ReedGradient: built off the audio path, read on it.
struct PlaneGuide {
  GradientField height;         // height of the GrowthMap
  GuidanceField distance_field; // distance to the region where a note grows at 8 1/s or faster

  /// Copies a finished map. Allocates; takes some milliseconds.
  void build(const GrowthMap& map) {
    height = map.height();
    distance_field.build(map.height(), Guidance::kQuickGrowth);
  }
};

} // namespace tactus::reed
