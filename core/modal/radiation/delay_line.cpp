#include "core/modal/radiation/delay_line.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {
namespace {

constexpr double kBeta = 5.5;
constexpr std::size_t kWindowSteps = 2048;

/// Kaiser's window from its middle to its end.
class Window {
public:
  Window() {
    for (std::size_t i = 0; i < value_.size(); ++i) {
      const double u = static_cast<double>(i) / kWindowSteps;
      value_[i] =
          math::bessel_i0(kBeta * std::sqrt(std::max(1 - u * u, 0.0))) / math::bessel_i0(kBeta);
    }
  }
  /// u in [0, 1]
  [[nodiscard]] double at(double u) const noexcept {
    const double x = u * kWindowSteps;
    const auto i = std::min(static_cast<std::size_t>(x), kWindowSteps - 1);
    return value_[i] + (x - static_cast<double>(i)) * (value_[i + 1] - value_[i]);
  }

private:
  std::array<double, kWindowSteps + 1> value_{};
};
const Window kWindow;

} // namespace

DelayLine::Kernel::Kernel(double delay) noexcept {
  const double floor = std::floor(delay), x = delay - floor;
  const auto whole = static_cast<std::size_t>(floor);
  if (!(x > 1e-9)) {
    newest = whole;
    return;
  }
  const std::size_t half = std::min(kHalf, whole + 1);
  newest = whole + 1 - half;
  count = 2 * half;
  // sin(pi t) is sin(pi x) with alternating sign.
  const double sine = math::sin(std::numbers::pi * x) / std::numbers::pi;
  const double scale = 1 / static_cast<double>(half);
  std::array<double, 2 * kHalf> exact;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = x - (static_cast<double>(i) + 1 - static_cast<double>(half));
    const bool odd = (i + half) % 2 == 0; // the neighbour just newer than the delay is t = x
    exact[i] = (odd ? -sine : sine) / t * kWindow.at(std::min(std::abs(t) * scale, 1.0));
    sum += exact[i];
  }
  for (std::size_t i = 0; i < count; ++i)
    weight[i] = static_cast<float>(exact[i] / sum);
}

void DelayLine::prepare(std::size_t longest) {
  std::size_t size = 8;
  while (size < longest + kMargin)
    size *= 2;
  line_.assign(size, 0);
  mask_ = size - 1;
  write_ = 0;
  glide_.stop();
}

void DelayLine::set(double samples, bool glide, bool jump) noexcept {
  target_ = std::clamp(samples, 0.0, static_cast<double>(line_.size() - kMargin));
  if (jump) {
    glide_.stop();
    middle_ = old_ = latest_ = {target_, Kernel(target_)};
    doppler_ = glide;
    return;
  }
  if (!glide_.moving() && target_ == latest_.delay)
    return;
  if (!glide_.moving())
    doppler_ = glide;
  exchange(glide_.start(), false);
}

void DelayLine::clear() noexcept { std::fill(line_.begin(), line_.end(), 0.0F); }

/// The target, limited to what the fastest glide reaches within a segment.
DelayLine::Value DelayLine::limited(double target) const noexcept {
  if (doppler_) {
    constexpr double kMaxDelayChange = kMaxSlope * static_cast<double>(Glide::kSegment);
    target = std::clamp(target, middle_.delay - kMaxDelayChange, middle_.delay + kMaxDelayChange);
  }
  return {target, Kernel(target)};
}

void DelayLine::exchange(Glide::Exchange exchange, bool had_target) noexcept {
  if (exchange == Glide::Exchange::kNone)
    return;
  if (exchange == Glide::Exchange::kRotate)
    old_ = middle_;
  middle_ = latest_;
  if (exchange == Glide::Exchange::kStart)
    latest_ = limited(target_);
  else if (had_target) // a moving delay follows the mean of the targets, which does not depend on
                       // their times of arrival
    latest_ = limited(doppler_ ? target_sum_ / target_age_ : target_);
  target_sum_ = target_age_ = 0;
  // The rest of a limited step follows in the next segments.
  if (latest_.delay != target_) {
    const Glide::Exchange more = glide_.start();
    if (more == Glide::Exchange::kStart)
      this->exchange(more, false);
  }
}

/// Reads the delayed samples of the present chunk from sample `first` on.
void DelayLine::read(const Kernel& kernel, std::size_t first, float* out,
                     std::size_t count) const noexcept {
  std::array<float, kChunk + 2 * kHalf> piece;
  const std::size_t length = count + kernel.count - 1;
  const std::size_t begin = (first - kernel.newest - (kernel.count - 1)) & mask_;
  const std::size_t to_end = std::min(length, line_.size() - begin);
  std::copy_n(line_.data() + begin, to_end, piece.data());
  std::copy_n(line_.data(), length - to_end, piece.data() + to_end);
  if (kernel.count == 1) {
    std::copy_n(piece.data(), count, out);
    return;
  }
  std::array<float, kChunk> sum{};
  for (std::size_t i = 0; i < kernel.count; ++i) {
    const float w = kernel.weight[i];
    const float* const from = piece.data() + kernel.count - 1 - i;
    for (std::size_t n = 0; n < count; ++n)
      sum[n] += w * from[n];
  }
  std::copy_n(sum.data(), count, out);
}

void DelayLine::run(float* sound, std::size_t count) noexcept {
  while (count > 0) {
    std::size_t part = std::min(count, kChunk);
    if (glide_.moving())
      part = std::min(part, glide_.left());
    run_chunk(sound, part);
    sound += part;
    count -= part;
  }
}

void DelayLine::run_chunk(float* sound, std::size_t count) noexcept {
  const std::size_t to_end = std::min(count, line_.size() - (write_ & mask_));
  std::copy_n(sound, to_end, line_.data() + (write_ & mask_));
  std::copy_n(sound + to_end, count - to_end, line_.data());
  const std::size_t first = write_;
  write_ += count;
  target_sum_ += static_cast<double>(count) * target_;
  target_age_ += static_cast<double>(count);
  if (!glide_.moving())
    return read(latest_.kernel, first, sound, count);
  if (doppler_) {
    for (std::size_t n = 0; n < count; ++n) {
      const Glide::Blend b = glide_.blend(n);
      const double delay = b.old * old_.delay + b.middle * middle_.delay + b.latest * latest_.delay;
      read(Kernel(delay), first + n, sound + n, 1);
    }
  } else {
    std::array<float, kChunk> part;
    std::array<double, kChunk> sum{};
    const auto add = [&](const Value& value, double Glide::Blend::*share) {
      read(value.kernel, first, part.data(), count);
      for (std::size_t n = 0; n < count; ++n)
        sum[n] += glide_.blend(n).*share * static_cast<double>(part[n]);
    };
    add(middle_, &Glide::Blend::middle);
    if (glide_.has_old())
      add(old_, &Glide::Blend::old);
    if (glide_.has_latest())
      add(latest_, &Glide::Blend::latest);
    for (std::size_t n = 0; n < count; ++n)
      sound[n] = static_cast<float>(sum[n]);
  }
  const bool had_target = glide_.has_target();
  exchange(glide_.advance(count), had_target);
}

} // namespace tactus::modal
