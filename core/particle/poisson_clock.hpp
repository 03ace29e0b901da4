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
  static constexpr int kMostEvents = 64;

  void reset() noexcept { armed_ = false; }

  /// Lets an interval pass in which `expected` events are expected (rate times duration). Calls
  /// `event(fraction)` for each, fraction in [0, 1) of the interval. Returns their number.
  template <class Event> int advance(double expected, Random& random, Event&& event) noexcept {
    if (!(expected > 0))
      return 0;
    if (!armed_) {
      waiting_ = exponential(random);
      armed_ = true;
    }
    double passed = 0;
    int count = 0;
    while (waiting_ < expected - passed) {
      passed += waiting_;
      waiting_ = exponential(random);
      if (count == kMostEvents)
        return count; // the process forgets: a fresh waiting time is as good as the rest of this
      ++count;
      event(passed / expected);
    }
    waiting_ -= expected - passed;
    return count;
  }

  /// Exponential with mean 1.
  static double exponential(Random& random) noexcept { return -std::log1p(-random.uniform()); }

private:
  double waiting_ = 0; ///< integral of the rate until the next event
  bool armed_ = false;
};

} // namespace tactus::particle
