#pragma once

#include "core/contact/body_lanes.hpp"
#include "core/contact/dense_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

/// DenseKernel, written once for any instruction set. Every sum runs over the columns in the same
/// order, or over eight lanes and then across the lanes. So every set gives the same bits.
namespace tactus::contact {

template <class Set> class DenseLanes final : public DenseKernel, Lanes<Set> {
  using L = Lanes<Set>;
  using V = typename L::V;
  using L::across, L::all, L::kRegisters, L::kWidth, L::load, L::store;

  [[gnu::always_inline]] static std::size_t lanes_from(std::size_t row) noexcept {
    return row / kModeLanes * kModeLanes;
  }

  /// Subtracts the contributions of the earlier columns from 8 x `Groups` rows of one column.
  template <std::size_t Groups>
  [[gnu::always_inline]] static void reduce(const DenseView& m, std::size_t row,
                                            std::size_t column) noexcept {
    constexpr std::size_t kCount = Groups * kRegisters;
    double* const to = m.at + column * m.stride + row;
    V sum[kCount];
#pragma GCC unroll 8
    for (std::size_t r = 0; r < kCount; ++r)
      sum[r] = load(to + r * kWidth);
    for (std::size_t k = 0; k < column; ++k) {
      const double* const from = m.at + k * m.stride + row;
      const V times = all(m(column, k));
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kCount; ++r)
        sum[r] -= times * load(from + r * kWidth);
    }
#pragma GCC unroll 8
    for (std::size_t r = 0; r < kCount; ++r)
      store(to + r * kWidth, sum[r]);
  }

public:
  void factorise(const DenseView& m, double min_pivot) const noexcept override {
    for (std::size_t column = 0; column < m.count; ++column) {
      std::size_t row = lanes_from(column);
      for (; row + 2 * kModeLanes <= m.stride; row += 2 * kModeLanes)
        reduce<2>(m, row, column);
      if (row < m.stride)
        reduce<1>(m, row, column);
      const double root = std::sqrt(std::max(m(column, column), min_pivot));
      const V over = all(1 / root);
      double* const to = m.at + column * m.stride;
      for (row = lanes_from(column); row < m.stride; row += kWidth)
        store(to + row, load(to + row) * over);
      to[column] = root;
      std::fill(to + lanes_from(column), to + column, 0.0);
    }
  }

  void substitute(const DenseView& m, double* first, double* second) const noexcept override {
    for (std::size_t k = 0; k < m.count; ++k) {
      const double* const column = m.at + k * m.stride;
      const double over = 1 / column[k], x = first[k] * over, y = second[k] * over;
      for (std::size_t i = lanes_from(k); i < m.stride; i += kWidth) {
        const V c = load(column + i); // 0 above the diagonal
        store(first + i, load(first + i) - all(x) * c);
        store(second + i, load(second + i) - all(y) * c);
      }
      first[k] = x;
      second[k] = y;
    }
    for (std::size_t k = m.count; k-- > 0;) {
      const double* const column = m.at + k * m.stride;
      const double x = first[k], y = second[k], over = 1 / column[k];
      first[k] = second[k] = 0; // excludes the unknown itself from the sums below
      V one[kRegisters] = {}, two[kRegisters] = {};
      for (std::size_t i = lanes_from(k); i < m.stride; i += kModeLanes)
#pragma GCC unroll 4
        for (std::size_t r = 0; r < kRegisters; ++r) {
          const V c = load(column + i + r * kWidth);
          one[r] += c * load(first + i + r * kWidth);
          two[r] += c * load(second + i + r * kWidth);
        }
      first[k] = (x - across(one)) * over;
      second[k] = (y - across(two)) * over;
    }
  }

  void add_square(const DenseView& m, const double* x, double factor) const noexcept override {
    for (std::size_t column = 0; column < m.count; ++column) {
      const V times = all(factor * x[column]);
      double* const to = m.at + column * m.stride;
      for (std::size_t i = lanes_from(column); i < m.stride; i += kWidth)
        store(to + i, load(to + i) + times * load(x + i));
    }
  }

  void add_column(double* to, double* sum, const double* y, const ColumnWeights& weights,
                  std::size_t padded) const noexcept override {
    const double* const row = weights.row;
    const V times = all(weights.column), part = all(weights.sum);
    for (std::size_t i = 0; i < padded; i += kWidth) {
      const V value = load(y + i);
      store(to + i, times * load(row + i) * value);
      store(sum + i, load(sum + i) + part * value);
    }
  }
};

} // namespace tactus::contact
