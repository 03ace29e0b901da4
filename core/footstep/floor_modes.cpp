#include "core/footstep/floor_modes.hpp"

#include "core/dsp/elementary.hpp"

namespace tactus::footstep {

void set_body_modes(contact::ExcitedBody& body, const ModesRecipe& modes,
                    std::span<const double> detune, double frequency, double decay,
                    std::span<const contact::Mode> before) noexcept {
  std::array<contact::Mode, kMaxModes> tuned{};
  std::array<double, kMaxModes> pickup{};
  const std::size_t first = std::min(before.size(), kMaxModes);
  std::copy_n(before.begin(), first, tuned.begin());
  const auto count =
      std::min({static_cast<std::size_t>(modes.count), detune.size(), kMaxModes - first});
  double step = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double relative = step * math::exp(modes.detune * detune[i]);
    tuned[first + i] = {modes.frequency_hz * frequency * relative,
                        modes.t60_s * decay * math::pow(relative, -modes.t60_tilt), modes.mass_kg};
    pickup[first + i] = math::pow(relative, -modes.tilt) * math::exp10(modes.gains_db[i] / 20);
    step *= modes.ratio;
  }
  body.set_modes(std::span(tuned.data(), first + count));
  body.set_pickup(0, std::span(pickup.data(), first + count));
}

std::array<double, kMaxModes> draw_mode_shape(const ModesRecipe& modes, Random& random) noexcept {
  std::array<double, kMaxModes> shape{};
  for (double& s : shape)
    s = lognormal_factor(modes.mode_share_scatter, random);
  return shape;
}

} // namespace tactus::footstep
