#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"

#include <array>
#include <cstddef>
#include <utility>

namespace tactus::reed {

/// States (or coefficients) of the eight wall-loss sections, for several reeds (V = simd::Lanes)
/// or, packed in pairs in vector registers, for one (V = double). Both sum in the same order.
template <class V> struct LossStates {
  static constexpr std::size_t kSize = RoundTrip::kLossSections;
  std::array<V, kSize> value{};

  explicit LossStates(const std::array<double, kSize>& numbers = {}) noexcept {
    for (std::size_t k = 0; k < kSize; ++k)
      value[k] = V(numbers[k]);
  }
  /// value = pole * value + gain * in.
  [[gnu::always_inline]] void step(const LossStates& pole, const LossStates& gain,
                                   const V& in) noexcept {
    step(pole, gain, in, std::make_index_sequence<kSize>());
  }
  [[nodiscard, gnu::always_inline]] V sum() const noexcept {
    return ((value[0] + value[4]) + (value[2] + value[6])) +
           ((value[1] + value[5]) + (value[3] + value[7]));
  }
  template <class Change> void each(Change change) noexcept {
    for (V& x : value)
      change(x);
  }

private:
  // Written out, because compilers keep an array in registers when every index is a constant.
  template <std::size_t... k>
  [[gnu::always_inline]] void step(const LossStates& pole, const LossStates& gain, const V& in,
                                   std::index_sequence<k...>) noexcept {
    ((value[k] = pole.value[k] * value[k] + gain.value[k] * in), ...);
  }
};

template <> struct LossStates<double> {
  using Pair = simd::Lanes<double, 2>;
  Pair a{0.0}, b{0.0}, c{0.0}, d{0.0};

  explicit LossStates(const std::array<double, RoundTrip::kLossSections>& numbers = {}) noexcept
      : a(pair(numbers[0], numbers[1])), b(pair(numbers[2], numbers[3])),
        c(pair(numbers[4], numbers[5])), d(pair(numbers[6], numbers[7])) {}

  [[gnu::always_inline]] void step(const LossStates& pole, const LossStates& gain,
                                   double in) noexcept {
    const Pair both(in);
    a = pole.a * a + gain.a * both;
    b = pole.b * b + gain.b * both;
    c = pole.c * c + gain.c * both;
    d = pole.d * d + gain.d * both;
  }
  [[nodiscard, gnu::always_inline]] double sum() const noexcept {
    const Pair two = (a + c) + (b + d);
    return simd::lane(two, 0) + simd::lane(two, 1);
  }
  template <class Change> void each(Change change) noexcept {
    for (Pair* two : {&a, &b, &c, &d}) {
      double first = simd::lane(*two, 0), second = simd::lane(*two, 1);
      change(first);
      change(second);
      *two = pair(first, second);
    }
  }

private:
  static Pair pair(double first, double second) noexcept {
    Pair two(first);
    simd::set_lane(two, 1, second);
    return two;
  }
};

/// The wall-loss and open-end filters of a RoundTrip, with their states. V is double or
/// simd::Lanes.
template <class V> class RoundTripFilter {
public:
  void reset() noexcept {
    loss_ = LossStates<V>();
    end_ = {V(0.0), V(0.0)};
  }
  /// Calls change(V&) for each number of the state.
  template <class Change> void each(Change change) noexcept {
    loss_.each(change);
    change(end_[0]);
    change(end_[1]);
  }

  /// Calls change(V&) for each number of the state of the wall loss alone.
  template <class Change> void each_loss(const Change& change) noexcept { loss_.each(change); }

  /// The filter for a block of samples, with coefficients and state in registers; its destructor
  /// stores the state.
  class BlockFilter {
  public:
    [[gnu::always_inline]] BlockFilter(RoundTripFilter& filter, const RoundTrip& trip,
                                       double reflected_weight) noexcept
        : filter_(filter), loss_(filter.loss_), loss_pole_(trip.loss_pole),
          loss_residue_(trip.loss_residue), first_(filter.end_[0]), second_(filter.end_[1]),
          first_pole_(trip.end.pole[0]), second_pole_(trip.end.pole[1]),
          first_input_(trip.end.input[0]), second_input_(trip.end.input[1]),
          incident_gain_(trip.incident_gain), direct_(trip.end.direct),
          reflected_weight_(reflected_weight) {}
    BlockFilter(const BlockFilter&) = delete;
    BlockFilter& operator=(const BlockFilter&) = delete;
    [[gnu::always_inline]] ~BlockFilter() {
      filter_.loss_ = loss_;
      filter_.end_ = {first_, second_};
    }

    /// From the delay line's output to the reflected wave b, returned. leaving: a -
    /// reflected_weight * b of the first lane, a the wave that arrives at the open end.
    [[gnu::always_inline]] V operator()(const V& wave, double& leaving) noexcept {
      const V at_end = incident(wave), back = direct_ * at_end + second_;
      second_ = second_pole_ * second_ + (second_input_ * at_end + first_);
      first_ = first_pole_ * first_ + first_input_ * at_end;
      leaving = static_cast<double>(simd::lane(at_end - reflected_weight_ * back, 0));
      return back;
    }

    /// Applies the wall loss alone: turns the delay line's output into the wave `a` that arrives at
    /// the end.
    [[gnu::always_inline]] V incident(const V& wave) noexcept {
      const V attenuated = wave + loss_.sum();
      loss_.step(loss_pole_, loss_residue_, wave);
      return incident_gain_ * attenuated;
    }

  private:
    RoundTripFilter& filter_;
    LossStates<V> loss_, loss_pole_, loss_residue_;
    V first_, second_, first_pole_, second_pole_, first_input_, second_input_;
    V incident_gain_, direct_, reflected_weight_;
  };

private:
  LossStates<V> loss_{};
  std::array<V, 2> end_{V(0.0), V(0.0)};
};

} // namespace tactus::reed
