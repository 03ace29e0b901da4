#pragma once

#include <array>

namespace tactus::reed {

/// Odd coefficients h_1, h_3, ... of a half-band low-pass filter,
///   y = x_0/2 + sum_j h_(2j+1) (x_-(2j+1) + x_+(2j+1)),
/// by the window method (Kaiser, beta = 7): stop band below -70 dB, gain 1 at 0 Hz.
template <int pairs> [[nodiscard]] std::array<double, pairs> halfband_coefficients() noexcept;

/// Halves the sample rate of one signal (V = double) or of several in vector lanes. Linear phase;
/// delay 2 pairs - 1 input samples. No allocation.
template <class V, int pairs, int max_count> class Halfband {
public:
  void reset() noexcept { history_.fill(V(0.0)); }

  /// count outputs from 2 count inputs (2 count <= max_count); output may be the input.
  void run(const V* input, V* output, int count) noexcept {
    for (int i = 0; i < 2 * count; ++i)
      history_[static_cast<std::size_t>(kHistory + i)] = input[i];
    for (int n = 0; n < count; ++n) {
      const V* centre = history_.data() + 2 * n + 2 * pairs - 1;
      V sum = V(0.5) * centre[0];
      for (int j = 0; j < pairs; ++j)
        sum += V(coefficients_[static_cast<std::size_t>(j)]) *
               (centre[-2 * j - 1] + centre[2 * j + 1]);
      output[n] = sum;
    }
    for (int i = 0; i < kHistory; ++i)
      history_[static_cast<std::size_t>(i)] = history_[static_cast<std::size_t>(2 * count + i)];
  }

private:
  static constexpr int kHistory = 4 * pairs - 2;
  std::array<double, pairs> coefficients_ = halfband_coefficients<pairs>();
  std::array<V, kHistory + max_count> history_{};
};

/// Decimates by 4 or 2, with one or two half-band stages.
template <class V, int max_count> class Decimator {
public:
  void reset() noexcept {
    first_stage_.reset();
    second_stage_.reset();
  }

  /// count outputs from oversampling * count inputs (at most max_count), which are overwritten.
  /// oversampling: 2 or 4.
  void run(int oversampling, V* signal, V* output, int count) noexcept {
    if (oversampling == 4)
      first_stage_.run(signal, signal, 2 * count);
    second_stage_.run(signal, output, count);
  }

private:
  Halfband<V, 4, max_count> first_stage_{};
  Halfband<V, 8, max_count> second_stage_{};
};

} // namespace tactus::reed
