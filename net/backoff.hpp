#pragma once

#include "core/dsp/random.hpp"

#include <algorithm>

namespace tactus::net {

/// Pauses between attempts to connect: 0.25, 0.5, 1, 2 and then 4 s, each by up to 20 % longer or
/// shorter, so that many clients do not reconnect at the same moment.
class Backoff {
public:
  static constexpr double kFirst_s = 0.25, kMax_s = 4, kSpread = 0.2;
  explicit Backoff(std::uint64_t seed) noexcept : random_(seed) {}
  [[nodiscard]] double next() noexcept {
    const double pause_s = pause_s_ * (1 + kSpread * (2 * random_.uniform() - 1));
    pause_s_ = std::min(2 * pause_s_, kMax_s);
    return pause_s;
  }
  /// Call it when the connection has worked.
  void reset() noexcept { pause_s_ = kFirst_s; }

private:
  Random random_;
  double pause_s_ = kFirst_s;
};

} // namespace tactus::net
