#pragma once

#include "core/reed/playability/playability_analysis.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace tactus::reed::reference {

/// The textbook radix-2 transform, for tests.
class RadixTwo final : public RealTransform {
public:
  void prepare(std::size_t size) override { points_.resize(size); }
  void forward(std::span<const double> signal, std::span<Complex> spectrum) noexcept override {
    for (std::size_t n = 0; n < points_.size(); ++n)
      points_[n] = signal[n];
    transform(-1);
    for (std::size_t k = 0; k < spectrum.size(); ++k)
      spectrum[k] = points_[k];
  }
  void inverse(std::span<const Complex> spectrum, std::span<double> signal) noexcept override {
    const std::size_t size = points_.size();
    for (std::size_t k = 0; k <= size / 2; ++k)
      points_[k] = spectrum[k];
    for (std::size_t k = size / 2 + 1; k < size; ++k)
      points_[k] = conj(spectrum[size - k]);
    transform(1);
    for (std::size_t n = 0; n < size; ++n)
      signal[n] = points_[n].real();
  }

private:
  void transform(double sign) noexcept {
    const std::size_t size = points_.size();
    for (std::size_t i = 1, j = 0; i < size; ++i) {
      std::size_t bit = size >> 1;
      for (; j & bit; bit >>= 1)
        j ^= bit;
      j ^= bit;
      if (i < j)
        std::swap(points_[i], points_[j]);
    }
    for (std::size_t length = 2; length <= size; length *= 2)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const Complex twiddle =
            tactus::math::polar(1.0, sign * 2 * std::numbers::pi * static_cast<double>(k) /
                                         static_cast<double>(length));
        for (std::size_t start = k; start < size; start += length) {
          const Complex a = points_[start], x = points_[start + length / 2];
          const Complex b(x.real() * twiddle.real() - x.imag() * twiddle.imag(),
                          x.real() * twiddle.imag() + x.imag() * twiddle.real());
          points_[start] = a + b;
          points_[start + length / 2] = a - b;
        }
      }
  }
  std::vector<Complex> points_;
};

} // namespace tactus::reed::reference
