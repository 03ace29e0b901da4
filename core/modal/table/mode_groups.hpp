#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace tactus::modal {

/// How many modes to keep so that `count` cut no group of near-equal frequencies: all of its last
/// group. Any directions of a group's modes are right, so a part of it would be heard by how the
/// body is turned. Near is a gap below 0.1 %, and below a tenth of a plate's mean one, 1 / mode.
[[nodiscard]] inline std::size_t with_whole_groups(std::span<const double> frequency_hz,
                                                   std::size_t count) noexcept {
  const auto& f = frequency_hz;
  while (count > 0 && count < f.size() &&
         std::abs(f[count] - f[count - 1]) <
             std::min(1e-3, .1 / static_cast<double>(count)) * f[count])
    ++count;
  return std::min(count, f.size());
}

} // namespace tactus::modal
