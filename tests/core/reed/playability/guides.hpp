#pragma once

#include "core/reed/playability/gradient.hpp"

namespace tactus::reed::test {

/// What a plane's guide is, made in one go.
inline PlaneGuide guide_of(const PlaneSettings& plane) {
  constexpr std::size_t kNodes = ReedGradient::kGrowthNodes;
  GrowthMap map;
  map.prepare(kNodes, kNodes);
  map.begin(plane.playing, plane.range);
  (void)map.advance(kNodes * kNodes);
  PlaneGuide guide;
  guide.build(map);
  return guide;
}

} // namespace tactus::reed::test
