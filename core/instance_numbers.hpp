#pragma once

#include "core/declaration.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

/// What each instance of an object leaves to chance is its own: two alike in one patch would sound
/// 6 dB louder, not 3, and from one place. A parameter that seeds begins with its declared value in
/// the first instance, and one higher in each further one, so that a patch that is opened again, or
/// rendered again, has the same seeds.
namespace tactus {

/// The numbers that the living instances of an object have, from 0 up, in each host apart.
class InstanceNumbers {
  using Taken = std::pair<const void*, std::size_t>;

public:
  /// A number, until the end of this hold on it: the lowest that is free.
  class Hold {
  public:
    Hold(InstanceNumbers& numbers, const void* host) : numbers_(numbers), taken_{host, 0} {
      const std::lock_guard lock(numbers_.mutex_);
      auto& all = numbers_.taken_;
      while (std::find(all.begin(), all.end(), taken_) != all.end())
        ++taken_.second;
      all.push_back(taken_);
    }
    ~Hold() {
      const std::lock_guard lock(numbers_.mutex_);
      auto& all = numbers_.taken_;
      all.erase(std::find(all.begin(), all.end(), taken_));
    }
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;
    [[nodiscard]] std::size_t number() const noexcept { return taken_.second; }

  private:
    InstanceNumbers& numbers_;
    Taken taken_;
  };

private:
  std::mutex mutex_;
  std::vector<Taken> taken_;
};

namespace seeds {

/// Further channels keep this distance, which few patches have instances to bridge.
inline constexpr double kChannelStep = 65536;

[[nodiscard]] inline double wrapped(const Parameter& seed, double value) noexcept {
  const double count = seed.highest - seed.lowest + 1;
  return seed.lowest + std::fmod(value - seed.lowest, count);
}

} // namespace seeds

/// What a parameter is in a new instance.
[[nodiscard]] inline double initial_value(const Parameter& parameter,
                                          std::size_t instance) noexcept {
  return parameter.seeds
             ? seeds::wrapped(parameter, parameter.initial + static_cast<double>(instance))
             : parameter.initial;
}
/// What a channel, from 0, gets when a parameter is set.
[[nodiscard]] inline double channel_value(const Parameter& parameter, double value,
                                          std::size_t channel) noexcept {
  return parameter.seeds && channel > 0
             ? seeds::wrapped(parameter, value + seeds::kChannelStep * static_cast<double>(channel))
             : value;
}

} // namespace tactus
