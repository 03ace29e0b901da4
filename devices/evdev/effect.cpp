#include "devices/evdev/effect.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::devices::evdev {

ConstantForce constant_force(const Vec3& force_n, double peak_n, bool two_axes) noexcept {
  const double x = force_n.x, z = force_n.z;
  if (!two_axes) {
    constexpr std::uint16_t kLeft = 0x4000;
    const double share = std::isfinite(x) && peak_n > 0 ? std::clamp(-x / peak_n, -1.0, 1.0) : 0.0;
    return {static_cast<std::int16_t>(std::lround(32767 * share)), kLeft};
  }
  const double length = std::hypot(x, z);
  if (!std::isfinite(length) || !(length > 0) || !(peak_n > 0))
    return {};
  ConstantForce force;
  force.level = static_cast<std::int16_t>(std::lround(32767 * std::min(1.0, length / peak_n)));
  const double turns = std::atan2(-x, z) / (2 * std::numbers::pi);
  force.direction = static_cast<std::uint16_t>(std::lround(65536 * (turns + 1)) & 0xFFFF);
  return force;
}

} // namespace tactus::devices::evdev
