#include "core/haptic/servo/pacer.hpp"

namespace tactus::haptic {

void Pacer::start(double start_s, double period_s) noexcept {
  start_s_ = start_s;
  period_s_ = period_s;
  next_ = 0;
}

Pacer::Wake Pacer::wake(double now_s) noexcept {
  Wake wake;
  wake.lateness_s = std::max(0.0, now_s - deadline_s());
  // Within a millionth of a period a grid point counts as reached, since k * period is rounded.
  const double whole = std::floor(std::min(wake.lateness_s / period_s_ + 1e-6, 1e15));
  wake.skipped = static_cast<std::uint64_t>(whole);
  wake.tick = {next_ + wake.skipped, now_s, period_s_};
  next_ += wake.skipped + 1;
  return wake;
}

} // namespace tactus::haptic
