#pragma once

#include "core/reed/playability/playability_analysis.hpp"

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>
#include <mutex>

#include <fftw3.h>

namespace tactus::reed {

/// RealTransform by FFTW. Plans are estimated, not measured: measured plans differ from run to run,
/// and with them the last bits of the result.
class FftwTransform final : public RealTransform {
public:
  FftwTransform() = default;
  ~FftwTransform() override { release(); }
  FftwTransform(const FftwTransform&) = delete;
  FftwTransform& operator=(const FftwTransform&) = delete;

  void prepare(std::size_t size) override {
    if (size == size_)
      return;
    release();
    size_ = size;
    samples_.reset(fftw_alloc_real(size));
    bins_.reset(fftw_alloc_complex(size / 2 + 1));
    const std::lock_guard lock(planner());
    forward_ =
        fftw_plan_dft_r2c_1d(static_cast<int>(size), samples_.get(), bins_.get(), FFTW_ESTIMATE);
    inverse_ =
        fftw_plan_dft_c2r_1d(static_cast<int>(size), bins_.get(), samples_.get(), FFTW_ESTIMATE);
  }

  void forward(std::span<const double> signal, std::span<Complex> spectrum) noexcept override {
    std::copy_n(signal.begin(), size_, samples_.get());
    fftw_execute(forward_);
    for (std::size_t k = 0; k <= size_ / 2; ++k)
      spectrum[k] = {bins_.get()[k][0], bins_.get()[k][1]};
  }

  void inverse(std::span<const Complex> spectrum, std::span<double> signal) noexcept override {
    for (std::size_t k = 0; k <= size_ / 2; ++k) {
      bins_.get()[k][0] = spectrum[k].real();
      bins_.get()[k][1] = spectrum[k].imag();
    }
    fftw_execute(inverse_);
    std::copy_n(samples_.get(), size_, signal.begin());
  }

private:
  struct Release {
    void operator()(void* memory) const noexcept { fftw_free(memory); }
  };

  /// FFTW has one planner per process, which only one thread may use at a time.
  static std::mutex& planner() {
    static std::mutex mutex;
    return mutex;
  }

  void release() noexcept {
    if (!forward_)
      return;
    const std::lock_guard lock(planner());
    fftw_destroy_plan(forward_);
    fftw_destroy_plan(inverse_);
    forward_ = inverse_ = nullptr;
  }

  std::size_t size_ = 0;
  std::unique_ptr<double[], Release> samples_;
  std::unique_ptr<fftw_complex[], Release> bins_;
  fftw_plan forward_ = nullptr, inverse_ = nullptr;
};

} // namespace tactus::reed
