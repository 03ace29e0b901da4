#pragma once

#include "core/dsp/simd.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Fractional delay line of the bore's round trip: a ring buffer with fifth-order Lagrange
/// interpolation, read and written in blocks.
///
/// The delay is in samples. A block is shorter than the delay and has at most max_count samples. It
/// is read before it is written, and its output may be put in the slots where its input will go:
///   read(...) into next();  turn the output into the new input in place;  advance(count).
/// V is double or simd::Lanes. Only prepare() allocates.
template <class V, int max_count> class BoreLine {
public:
  static constexpr int kPoints = 6;
  /// Longest block that may be read at this delay.
  [[nodiscard]] static int max_block(double delay) noexcept { return first_of(delay); }

  /// Weights of the samples 0, 1, ... 5 back for a delay of 2 <= d < 3. This is the centred range
  /// of fifth-order Lagrange interpolation, where |H| <= 1 (Laakso, Valimaki, Karjalainen & Laine
  /// 1996).
  [[nodiscard]] static std::array<double, kPoints> weights(double d) noexcept {
    const double a = d, b = d - 1, c = d - 2, e = d - 3, f = d - 4, g = d - 5;
    const double abc = a * b * c, efg = e * f * g;
    return {-b * c * efg / 120, a * c * efg / 24,  -a * b * efg / 12,
            abc * f * g / 12,   -abc * e * g / 24, abc * e * f / 120};
  }

  /// Allocates room for delays of `delay` samples; all samples are 0.
  void prepare(int delay) {
    std::size_t size = 1;
    while (size < static_cast<std::size_t>(delay + max_count + 8))
      size *= 2;
    line_.assign(size, V(0.0));
    mask_ = static_cast<std::ptrdiff_t>(size) - 1;
    written_ = 0;
  }
  void clear() noexcept { std::fill(line_.begin(), line_.end(), V(0.0)); }

  /// The next count samples at a constant delay. Magnitudes below `silence` become 0.
  void read(double delay, double silence, V* wave, int count) const noexcept {
    // All samples that the block reads, oldest first: copied if they wrap around the ring.
    const int first = first_of(delay);
    const std::array<double, kPoints> h = weights(delay - first);
    const V h0(h[0]), h1(h[1]), h2(h[2]), h3(h[3]), h4(h[4]), h5(h[5]);
    std::array<V, max_count + kPoints - 1> contiguous;
    const std::size_t from = slot(written_ - first - (kPoints - 1));
    const auto length = static_cast<std::size_t>(count + kPoints - 1);
    const V* history = line_.data() + from;
    if (from + length > line_.size()) {
      const std::size_t count_to_end = line_.size() - from;
      std::copy_n(history, count_to_end, contiguous.data());
      std::copy_n(line_.data(), length - count_to_end, contiguous.data() + count_to_end);
      history = contiguous.data();
    }
    const V threshold(silence);
    for (int i = 0; i < count; ++i) {
      const V sum =
          ((h0 * history[i + 5] + h5 * history[i]) + (h1 * history[i + 4] + h4 * history[i + 1])) +
          (h2 * history[i + 3] + h3 * history[i + 2]);
      wave[i] = simd::select(simd::absolute(sum) < threshold, V(0.0), sum);
    }
  }
  /// A delay that moves linearly within `period` samples, `phase` of which have passed.
  struct MovingDelay {
    double from, to;
    int phase;
    double period;
  };
  /// The next count samples at a moving delay.
  void read_moving(const MovingDelay& delay, double silence, V* wave, int count) const noexcept {
    for (int i = 0; i < count; ++i) {
      const double now = delay.from + (delay.phase + i) / delay.period * (delay.to - delay.from);
      const int first = first_of(now);
      const std::array<double, kPoints> h = weights(now - first);
      const std::ptrdiff_t at = written_ + i - first;
      const V sum = ((V(h[0]) * line_[slot(at)] + V(h[5]) * line_[slot(at - 5)]) +
                     (V(h[1]) * line_[slot(at - 1)] + V(h[4]) * line_[slot(at - 4)])) +
                    (V(h[2]) * line_[slot(at - 2)] + V(h[3]) * line_[slot(at - 3)]);
      wave[i] = simd::select(simd::absolute(sum) < V(silence), V(0.0), sum);
    }
  }
  /// Sets its last count samples to the output of another line of the same size at this delay.
  void follow(const BoreLine& other, double delay, int count) noexcept {
    const int first = first_of(delay);
    const std::array<double, kPoints> h = weights(delay - first);
    count = std::min(count, static_cast<int>(mask_ + 1) - first - kPoints);
    written_ = other.written_;
    for (int i = 1; i <= count; ++i) {
      V sum(0.0);
      for (int k = 0; k < kPoints; ++k)
        sum += V(h[static_cast<std::size_t>(k)]) * other.line_[slot(written_ - i - first - k)];
      line_[slot(written_ - i)] = sum;
    }
  }
  /// Memory for the next samples; room() of them are contiguous.
  [[nodiscard]] V* next() noexcept { return line_.data() + written_; }
  [[nodiscard]] int room() const noexcept { return static_cast<int>(mask_ + 1 - written_); }
  /// Accepts count samples written at next().
  void advance(int count) noexcept { written_ = (written_ + count) & mask_; }

private:
  /// Age, in samples, of the most recent of the six points for a delay.
  static int first_of(double delay) noexcept { return static_cast<int>(delay) - 2; }
  [[nodiscard]] std::size_t slot(std::ptrdiff_t i) const noexcept {
    return static_cast<std::size_t>(i & mask_);
  }

  std::vector<V> line_;
  std::ptrdiff_t mask_ = 0, written_ = 0;
};

} // namespace tactus::reed
