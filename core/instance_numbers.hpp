#pragma once

#include "core/declaration.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

/// Seeds of instances. Two instances with the same seed in one patch would be correlated: their sum
/// would be 6 dB louder instead of 3 dB, and would seem to come from one point. A parameter with
/// `seeds` starts with its declared value in the first instance and one higher in each further
/// instance, so that a patch that is opened or rendered again has the same seeds.
namespace tactus {

/// The numbers, from 0, of an object's existing instances; each host counts its own.
class InstanceNumbers {
  using Taken = std::pair<const void*, std::size_t>;

public:
  /// Holds the lowest free number for its own lifetime.
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

/// Distance between the seeds of successive channels: larger than the number of instances in nearly
/// all patches, so that channels and instances do not share seeds.
inline constexpr double kChannelStep = 65536;

[[nodiscard]] inline double wrapped(const Parameter& seed, double value) noexcept {
  const double count = seed.highest - seed.lowest + 1;
  return seed.lowest + std::fmod(value - seed.lowest, count);
}

} // namespace seeds

/// Initial value of a parameter in a new instance.
[[nodiscard]] inline double initial_value(const Parameter& parameter,
                                          std::size_t instance) noexcept {
  return parameter.seeds
             ? seeds::wrapped(parameter, parameter.initial + static_cast<double>(instance))
             : parameter.initial;
}
/// Value for a channel (counted from 0) when a parameter is set.
[[nodiscard]] inline double channel_value(const Parameter& parameter, double value,
                                          std::size_t channel) noexcept {
  return parameter.seeds && channel > 0
             ? seeds::wrapped(parameter, value + seeds::kChannelStep * static_cast<double>(channel))
             : value;
}

} // namespace tactus
