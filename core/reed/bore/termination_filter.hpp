#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/termination.hpp"

#include <array>
#include <cstddef>
#include <type_traits>

namespace tactus::reed {

/// The parallel sections of DigitalBlocks with their states, for one reed (V = double: two sections
/// in one vector register) or for several (V = simd::Lanes).
template <class V, int blocks> class TerminationFilter {
  static constexpr bool kSingle = std::is_same_v<V, double>;
  static constexpr std::size_t kLanesPerWord = kSingle ? 2 : 1, kWords = blocks / kLanesPerWord;
  using Word = std::conditional_t<kSingle, simd::Lanes<double, 2>, V>;
  using Words = std::array<Word, kWords>;

  static Words packed(const std::array<double, blocks>& numbers) noexcept {
    Words words;
    for (std::size_t k = 0; k < kWords; ++k) {
      words[k] = Word(numbers[k * kLanesPerWord]);
      if constexpr (kSingle)
        simd::set_lane(words[k], 1, numbers[2 * k + 1]);
    }
    return words;
  }

  Words x_, y_;

public:
  TerminationFilter() noexcept { reset(); }
  void reset() noexcept {
    x_.fill(Word(0.0));
    y_.fill(Word(0.0));
  }
  /// Calls change(V&) for each number of the state.
  template <class Change> void each(Change change) noexcept {
    for (Words* words : {&x_, &y_})
      for (Word& word : *words)
        if constexpr (kSingle) {
          for (int i = 0; i < 2; ++i) {
            double value = simd::lane(word, i);
            change(value);
            simd::set_lane(word, i, value);
          }
        } else {
          change(word);
        }
  }

  /// The filter for a block of samples, with coefficients and state in registers; its destructor
  /// stores the state.
  class BlockFilter {
  public:
    [[gnu::always_inline]] BlockFilter(TerminationFilter& filter,
                                       const DigitalBlocks<blocks>& c) noexcept
        : filter_(filter), x_(filter.x_), y_(filter.y_), a_(packed(c.a)), e_(packed(c.e)),
          w_(packed(c.w)), g_(packed(c.g)), h_(packed(c.h)), direct_(c.direct) {}
    BlockFilter(const BlockFilter&) = delete;
    BlockFilter& operator=(const BlockFilter&) = delete;
    [[gnu::always_inline]] ~BlockFilter() {
      filter_.x_ = x_;
      filter_.y_ = y_;
    }
    [[gnu::always_inline]] V operator()(const V& in) noexcept {
      const Word input(in);
      Word sum = x_[0] + y_[0];
      for (std::size_t k = 1; k < kWords; ++k)
        sum = sum + (x_[k] + y_[k]);
      for (std::size_t k = 0; k < kWords; ++k) {
        const Word x = (a_[k] * x_[k] - w_[k] * y_[k]) + g_[k] * input;
        y_[k] = (w_[k] * x_[k] + e_[k] * y_[k]) + h_[k] * input;
        x_[k] = x;
      }
      if constexpr (kSingle)
        return direct_ * in + (simd::lane(sum, 0) + simd::lane(sum, 1));
      else
        return direct_ * in + sum;
    }

  private:
    TerminationFilter& filter_;
    Words x_, y_, a_, e_, w_, g_, h_;
    V direct_;
  };
};

} // namespace tactus::reed
