#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/random.hpp"

namespace tactus::particle {

/// Draws the events of a Poisson process whose rate may change at any time.
/// Between two events the integral of the rate is exponentially distributed with mean 1, however
/// the rate varies (time-change theorem; Cinlar 1975, ch. 4). Counting that integral down gives the
/// right statistics at any sample rate. One sample may hold several events, each at its own time.
class PoissonClock {
public:
  /// Largest number of events in one interval; further ones are dropped. 64 per sample are 3
  /// million per second.
  static constexpr int kMaxEvents = 64;

  void reset() noexcept { armed_ = false; }

  /// Advances by an interval. `expected`: mean number of events in it, rate times duration. Calls
  /// `event(fraction)` for each event, at this fraction in [0, 1) of the interval. Returns their
  /// number.
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
        return count; // the process is memoryless: a new waiting time has the distribution of the
                      // remaining one
      ++count;
      event(elapsed / expected);
    }
    time_to_event_ -= expected - elapsed;
    return count;
  }

  /// Exponentially distributed number with mean 1.
  static double exponential(Random& random) noexcept { return -math::log1p(-random.uniform()); }

private:
  double time_to_event_ = 0; ///< integral of the rate until the next event
  bool armed_ = false;
};

} // namespace tactus::particle
