#include "core/haptic/device/device.hpp"

namespace tactus::haptic {

void reject_unreachable(const Caps& caps, State& state, Vec3& last_good) noexcept {
  // The stated workspace is the region of dependable force; the arm may reach twice as far.
  constexpr double kReach = 4;
  const Vec3 centre = (caps.workspace_min + caps.workspace_max) * 0.5;
  const double half_diagonal_m = 0.5 * norm(caps.workspace_max - caps.workspace_min);
  if (is_finite(state.position) && norm(state.position - centre) <= kReach * half_diagonal_m) {
    last_good = state.position;
    return;
  }
  state.position = last_good;
  state.velocity = {};
  state.flags |= State::kUnreachable;
}

std::string Backend::configure(std::span<const std::string> words) {
  return words.empty() ? "the setting needs a name" : words[0] + ": unknown setting of this device";
}

} // namespace tactus::haptic
