#pragma once

#include "core/reed/playability/gradient_field.hpp"

#include <cstddef>

namespace tactus::reed {

/// Signed distance D to the region where the instrument plays, over the plane of mouth pressure and
/// reed frequency, in units of the plane's side: D > 0 outside, D < 0 inside.
///
/// The region is where a quality (growth rate, or f_p) reaches a threshold. D is blurred by a
/// Gaussian, so that its gradient, of length 1 almost everywhere, turns smoothly where two borders
/// are equally near. Nodes are 1/80 apart; before blurring D is accurate to about half of this
/// distance. If all of the plane plays, or none of it, the gradient is 0.
class GuidanceField {
public:
  static constexpr std::size_t kNodes = 81; // nodes along y and along z
  static constexpr double kBlur = 0.015;    // standard deviation, of the plane's side

  /// True if the field has not been built yet.
  [[nodiscard]] bool empty() const noexcept { return distance_.empty(); }
  /// Computes D for the region quality >= threshold. Allocates; takes a few milliseconds.
  void build(const GradientField& quality, double threshold);

  [[nodiscard]] double distance(double y, double z) const noexcept { return distance_.value(y, z); }
  [[nodiscard]] Gradient slope(double y, double z) const noexcept {
    return distance_.gradient(y, z);
  }

private:
  GradientField distance_;
};

} // namespace tactus::reed
