#pragma once

#include "core/reed/playability/gradient_field.hpp"

#include <cstddef>

namespace tactus::reed {

/// How far it is to a place that plays, over the plane of mouth pressure and reed frequency, in
/// units of the plane's side: D > 0 where nothing plays, the way to the nearest playing place;
/// D < 0 where it plays, the way to the border. Made from any quality that is high where it plays
/// (growth of linear theory, f_p by playing) and a threshold; then blurred by a Gaussian, so that
/// the slope, of length 1 almost everywhere, turns smoothly where two ways are equally short.
///
/// Nodes are 1/80 apart and D is good to about half of that before blurring. Where all of the plane
/// plays, or none, the slope is 0.
class GuidanceField {
public:
  static constexpr std::size_t kNodes = 81; // along y and along z
  static constexpr double kBlur = 0.015;    // standard deviation, of the plane's side

  /// Not yet built.
  [[nodiscard]] bool empty() const noexcept { return distance_.empty(); }
  /// Places with quality >= threshold play. Off the audio path: allocates and takes a few
  /// milliseconds.
  void build(const GradientField& quality, double threshold);

  [[nodiscard]] double distance(double y, double z) const noexcept { return distance_.value(y, z); }
  [[nodiscard]] Gradient slope(double y, double z) const noexcept {
    return distance_.gradient(y, z);
  }

private:
  GradientField distance_;
};

} // namespace tactus::reed
