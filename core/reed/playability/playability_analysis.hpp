#pragma once

#include "core/dsp/complex.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::reed {

/// Interface of a discrete Fourier transform of real signals, implemented outside of core.
class RealTransform {
public:
  virtual ~RealTransform() = default;
  /// Prepares for signals of size samples, a power of two; may allocate and lock.
  virtual void prepare(std::size_t size) = 0;
  /// spectrum[k] = sum signal[n] exp(-2 pi i k n/size), k = 0 .. size/2.
  virtual void forward(std::span<const double> signal, std::span<Complex> spectrum) noexcept = 0;
  /// The inverse transform, not divided by size.
  virtual void inverse(std::span<const Complex> spectrum, std::span<double> signal) noexcept = 0;
};

/// Result of the periodicity analysis of one frame.
struct Periodicity {
  double frequency_hz = 0;   // f_0; 0 when the frame is silent or has no period
  double periodicity = 0;    // 1 - d'(tau_0) in [0, 1]
  double harmonicity_db = 0; // 10 log10(periodicity/(1 - periodicity)), within +-90
  double centroid_hz = 0;    // centroid of the power spectrum under a Hann window
};

/// Periodicity and f_0 of a signal, frame by frame, by the cumulative mean normalised difference
/// function of YIN (de Cheveigne & Kawahara 2002, eq. 6 and 8):
///   d(tau) = sum_{j < N/2} (x_j - x_{j+tau})^2,   d'(tau) = d(tau) tau/sum_{k=1..tau} d(k),
/// computed with one correlation by Fourier transform. tau_0 is the first minimum of d' below 0.1,
/// else its global minimum, refined by a parabola. Frames of N samples, N the power of two nearest
/// to 85 ms, start every N/4; the lowest f_0 is 2/85 ms = 24 Hz.
class PeriodicityAnalysis {
public:
  /// Allocates. Keeps its state when rate (Hz) and transform are the same. transform may be null:
  /// then nothing is analysed.
  void prepare(double sample_rate, std::shared_ptr<RealTransform> transform);
  void reset() noexcept;
  /// True when this sample completes a frame and result() is new. That sample costs four
  /// transforms.
  bool tick(double sample) noexcept;
  [[nodiscard]] const Periodicity& result() const noexcept { return result_; }
  [[nodiscard]] std::size_t frame() const noexcept { return ring_.size(); }

private:
  void analyse() noexcept;
  void difference() noexcept;

  double sample_rate_ = 0;
  std::shared_ptr<RealTransform> transform_;
  std::vector<double> ring_, frame_, work_, difference_;
  std::vector<Complex> spectrum_, half_frame_spectrum_;
  std::size_t write_ = 0, filled_ = 0, samples_since_frame_ = 0;
  Periodicity result_{};
};

} // namespace tactus::reed
