#pragma once

#include "core/dsp/simd.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Delay line of the bore's round trip, for stretches of at most `longest` samples that are shorter
/// than the delay: a stretch is read, into the place of its samples to come, before it is written.
template <class V, int longest> class BoreLine {
public:
  /// Room for `delay` samples; silent. Allocates.
  void prepare(int delay) {
    std::size_t size = 1;
    while (size < static_cast<std::size_t>(delay + longest + 8))
      size *= 2;
    line_.assign(size, V(0.0));
    mask_ = static_cast<std::ptrdiff_t>(size) - 1;
    written_ = 0;
  }
  void clear() noexcept { std::fill(line_.begin(), line_.end(), V(0.0)); }

  /// The next count samples at a delay that stands. What is smaller than `silence` is 0.
  void read(double delay, double silence, V* wave, int count) const noexcept {
    // The stretch of the line that these samples see, oldest first, in one piece.
    const int whole = static_cast<int>(delay) - 2;
    const std::array<double, 4> h = weights(delay - whole - 1);
    const V h0(h[0]), h1(h[1]), h2(h[2]), h3(h[3]);
    std::array<V, longest + 3> whole_piece;
    const std::size_t from = slot(written_ - whole - 4);
    const auto length = static_cast<std::size_t>(count + 3);
    const V* seen = line_.data() + from;
    if (from + length > line_.size()) {
      const std::size_t first = line_.size() - from;
      std::copy_n(seen, first, whole_piece.data());
      std::copy_n(line_.data(), length - first, whole_piece.data() + first);
      seen = whole_piece.data();
    }
    const V least(silence);
    for (int i = 0; i < count; ++i) {
      const V sum = (h0 * seen[i + 3] + h1 * seen[i + 2]) + (h2 * seen[i + 1] + h3 * seen[i]);
      wave[i] = simd::select(simd::absolute(sum) < least, V(0.0), sum);
    }
  }
  /// The next count samples while the delay goes from one value to another within `period`
  /// samples, `phase` of which have passed.
  void read_moving(double from, double to, int phase, double period, double silence, V* wave,
                   int count) const noexcept {
    for (int i = 0; i < count; ++i) {
      const double now = from + (phase + i) / period * (to - from);
      const int whole = static_cast<int>(now) - 2;
      const std::array<double, 4> h = weights(now - whole - 1);
      const std::ptrdiff_t at = written_ + i - 1 - whole;
      const V sum = (V(h[0]) * line_[slot(at)] + V(h[1]) * line_[slot(at - 1)]) +
                    (V(h[2]) * line_[slot(at - 2)] + V(h[3]) * line_[slot(at - 3)]);
      wave[i] = simd::select(simd::absolute(sum) < V(silence), V(0.0), sum);
    }
  }
  /// Becomes what has come out of another line of the same size at that delay, count samples back.
  void follow(const BoreLine& other, double delay, int count) noexcept {
    const int whole = static_cast<int>(delay) - 2;
    const std::array<double, 4> h = weights(delay - whole - 1);
    count = std::min(count, static_cast<int>(mask_ + 1) - whole - 4);
    written_ = other.written_;
    for (int i = 1; i <= count; ++i) {
      const std::ptrdiff_t at = written_ - i - 1 - whole;
      line_[slot(written_ - i)] =
          (V(h[0]) * other.line_[slot(at)] + V(h[1]) * other.line_[slot(at - 1)]) +
          (V(h[2]) * other.line_[slot(at - 2)] + V(h[3]) * other.line_[slot(at - 3)]);
    }
  }
  /// Where the next samples go, so that they can be made in place: room() of them in one piece.
  [[nodiscard]] V* next() noexcept { return line_.data() + written_; }
  [[nodiscard]] int room() const noexcept { return static_cast<int>(mask_ + 1 - written_); }
  /// So many have been made there.
  void advance(int count) noexcept { written_ = (written_ + count) & mask_; }

private:
  /// Third-order Lagrange interpolation in the middle of its four points, where |H| <= 1.
  static std::array<double, 4> weights(double d) noexcept { // 1 <= d < 2
    return {-(d - 1) * (d - 2) * (d - 3) / 6, d * (d - 2) * (d - 3) / 2, -d * (d - 1) * (d - 3) / 2,
            d * (d - 1) * (d - 2) / 6};
  }
  [[nodiscard]] std::size_t slot(std::ptrdiff_t i) const noexcept {
    return static_cast<std::size_t>(i & mask_);
  }

  std::vector<V> line_;
  std::ptrdiff_t mask_ = 0, written_ = 0;
};

} // namespace tactus::reed
