#pragma once

#include "core/reed/playability/growth_map.hpp"
#include "core/reed/playability/guidance.hpp"

#include <cmath>

namespace tactus::reed {

/// What a map by linear theory depends on.
struct PlaneSettings {
  PlayingSetup playing; // the valve as it is held, the bore's length, the factor on f_r
  ControlRange range;
  unsigned revision = 0; // counts changes of parameters and range

  /// True when a map made for the other serves here, too: lengths and lips within 0.1 %.
  [[nodiscard]] bool matches(const PlaneSettings& other) const noexcept {
    const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-3 * b; };
    return revision == other.revision && near(playing.length, other.playing.length) &&
           near(playing.reed_scale, other.playing.reed_scale);
  }
};

/// A finished map in the form in which a hand is led by it: made off the audio path, looked up on
/// it.
struct PlaneGuide {
  GradientField height;         // GrowthMap's
  GuidanceField distance_field; // to where a note grows quickly

  /// Of a finished map. Allocates; some milliseconds.
  void build(const GrowthMap& map) {
    height = map.height();
    distance_field.build(map.height(), Guidance::kQuickGrowth);
  }
};

} // namespace tactus::reed
