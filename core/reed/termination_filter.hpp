#pragma once

#include "core/reed/termination.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// The sections of a DigitalBlocks with their states, for one reed or several (V = simd::Lanes).
/// Silence costs no more than sound: see each().
template <class V, int blocks> class TerminationFilter {
  static constexpr std::size_t kSize = blocks;
  std::array<V, kSize> x_{}, y_{};

public:
  void reset() noexcept {
    x_.fill(V(0.0));
    y_.fill(V(0.0));
  }
  template <class Change> void each(Change change) noexcept {
    for (V& x : x_)
      change(x);
    for (V& y : y_)
      change(y);
  }

  /// With its coefficients at hand for a stretch of samples; the state goes back at the end of its
  /// life.
  class Stretch {
  public:
    [[gnu::always_inline]] Stretch(TerminationFilter& filter,
                                   const DigitalBlocks<blocks>& c) noexcept
        : filter_(filter), x_(filter.x_), y_(filter.y_), direct_(c.direct) {
      for (std::size_t k = 0; k < kSize; ++k) {
        a_[k] = V(c.a[k]);
        e_[k] = V(c.e[k]);
        w_[k] = V(c.w[k]);
        g_[k] = V(c.g[k]);
        h_[k] = V(c.h[k]);
      }
    }
    Stretch(const Stretch&) = delete;
    Stretch& operator=(const Stretch&) = delete;
    [[gnu::always_inline]] ~Stretch() {
      filter_.x_ = x_;
      filter_.y_ = y_;
    }
    [[gnu::always_inline]] V operator()(const V& in) noexcept {
      V sum = direct_ * in;
      for (std::size_t k = 0; k < kSize; ++k) {
        sum = sum + (x_[k] + y_[k]);
        const V x = (a_[k] * x_[k] - w_[k] * y_[k]) + g_[k] * in;
        y_[k] = (w_[k] * x_[k] + e_[k] * y_[k]) + h_[k] * in;
        x_[k] = x;
      }
      return sum;
    }

  private:
    TerminationFilter& filter_;
    std::array<V, kSize> x_, y_, a_, e_, w_, g_, h_;
    V direct_;
  };
};

} // namespace tactus::reed
