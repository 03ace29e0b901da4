#pragma once

#include "core/reed/playability/gradient.hpp"
#include "tests/core/reed/reference_instruments.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace tactus::reed::test {

constexpr double kHandRate = 48000;
constexpr double kHandPeriod_s = ReedGradient::kHandPeriod / kHandRate;

inline ReedGradient five_trumpets(ReedGradient::Mode mode = ReedGradient::Mode::kReed,
                                  simd::VectorSet widest = simd::kWidest) {
  ReedGradient gradient(widest);
  gradient.set(reference::trumpet());
  gradient.set_range({0, 8000, 80, 900});
  gradient.prepare(kHandRate);
  gradient.set_mode(mode);
  return gradient;
}

/// Theory of their plane, computed once, and the guide that is made of it.
inline const GrowthMap& trumpet_map() {
  static const GrowthMap made = [] {
    constexpr std::size_t kNodes = ReedGradient::kGrowthNodes;
    const Parameters p = reference::trumpet();
    GrowthMap map;
    map.prepare(kNodes, kNodes);
    map.begin({p, p.length}, {0, 8000, 80, 900});
    (void)map.advance(kNodes * kNodes);
    return map;
  }();
  return made;
}
inline const PlaneGuide& trumpet_guide() {
  static const PlaneGuide made = [] {
    PlaneGuide guide;
    guide.build(trumpet_map());
    return guide;
  }();
  return made;
}

struct Felt {
  std::vector<double> sound;
  std::vector<PlaneForce> force;  // at each reading of the hand
  std::vector<Gradient> gradient; // with it
};

/// A hand at (y, z) of the time in s, the stream cut into blocks.
inline Felt feel(ReedGradient& gradient,
                 const std::function<std::pair<double, double>(double)>& hand, double seconds,
                 std::size_t block = ReedGradient::kHandPeriod) {
  Felt felt;
  felt.sound.resize(static_cast<std::size_t>(seconds * kHandRate));
  for (std::size_t at = 0; at < felt.sound.size();) {
    const std::size_t end = std::min(at + block, felt.sound.size());
    while (at < end) {
      if (gradient.samples_until_hand() == 0) {
        const auto [y, z] = hand(static_cast<double>(at) / kHandRate);
        gradient.move(y, z, 0);
        felt.force.push_back(gradient.force());
        felt.gradient.push_back(gradient.gradient());
      }
      const std::size_t left =
          gradient.samples_until_hand() ? gradient.samples_until_hand() : ReedGradient::kHandPeriod;
      const std::size_t count = std::min(left, end - at);
      gradient.process(std::span(felt.sound).subspan(at, count));
      at += count;
    }
  }
  return felt;
}

inline Felt stay(ReedGradient& gradient, double y, double z, double seconds,
                 std::size_t block = ReedGradient::kHandPeriod) {
  return feel(
      gradient, [y, z](double) { return std::pair(y, z); }, seconds, block);
}

} // namespace tactus::reed::test
