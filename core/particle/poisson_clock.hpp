#pragma once

#include "core/dsp/random.hpp"

#include <cmath>

namespace tactus::particle {

/// Events of a Poisson process whose rate may change at any time, by their waiting times.
/// The integral of the rate between two events is exponential with mean 1 whatever the rate does
/// (time-change theorem; Cinlar 1975, ch. 4), so counting that integral down gives the right
/// statistics at any sample rate, with several events in one sample where they belong.
class PoissonClock {
public:
  /// More in one interval are left out: 64 a sample are 3 million a second.
  static constexpr int kMaxEvents = 64;

  void reset() noexcept { armed_ = false; }

  /// Lets an interval pass in which `expected` events are expected (rate times duration). Calls
  /// `event(fraction)` for each, fraction in [0, 1) of the interval. Returns their number.
  template <class Event> int advance(double expected, Random& random, Event&& event) noexcept {
    if (!(expected > 0))
      return 0;
    if (!armed_) {
      time_to_event_ = exponential(random);
      armed_ = true;
    }
    double elapsed = 0;
    int count = 0;
    while (time_to_event_ < expected - elapsed) {
      elapsed += time_to_event_;
      time_to_event_ = exponential(random);
      if (count == kMaxEvents)
        return count; // the process forgets: a fresh waiting time is as good as the rest of this
      ++count;
      event(elapsed / expected);
    }
    time_to_event_ -= expected - elapsed;
    return count;
  }

  /// Exponential with mean 1.
  static double exponential(Random& random) noexcept { return -std::log1p(-random.uniform()); }

private:
  double time_to_event_ = 0; ///< integral of the rate until the next event
  bool armed_ = false;
};

} // namespace tactus::particle
