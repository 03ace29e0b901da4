#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tactus::modal {

/// Sound on its way: a delay of any fraction of a sample, by the cubic through four samples
/// (Lagrange; flat within 0.1 dB up to a quarter of the sample rate). A new delay takes over in a
/// cross-fade, or glides there and bends the pitch as a moving listener hears it.
class DelayLine {
public:
  static constexpr std::size_t kFade = 512; ///< samples

  /// Allocates; keeps nothing of before.
  void prepare(std::size_t longest) {
    std::size_t size = 8;
    while (size < longest + 8)
      size *= 2;
    line_.assign(size, 0);
    mask_ = size - 1;
    write_ = 0;
    fade_left_ = 0;
  }
  void set(double samples, bool glide, bool jump) noexcept {
    const double target = std::clamp(samples, 0.0, static_cast<double>(line_.size()) - 8);
    if (target == delay_)
      return;
    old_delay_ = current();
    delay_ = target;
    glide_ = glide;
    fade_left_ = jump ? 0 : kFade;
  }
  void clear() noexcept { std::fill(line_.begin(), line_.end(), 0.0F); }

  [[nodiscard]] float step(float in) noexcept {
    line_[write_ & mask_] = in;
    float out;
    if (fade_left_ == 0) {
      out = tap(delay_);
    } else if (glide_) {
      out = tap(current());
      --fade_left_;
    } else {
      const float rest = static_cast<float>(fade_left_) / static_cast<float>(kFade);
      const float fresh = tap(delay_);
      out = fresh + rest * (tap(old_delay_) - fresh);
      --fade_left_;
    }
    ++write_;
    return out;
  }

private:
  [[nodiscard]] double current() const noexcept {
    return glide_ ? delay_ + (old_delay_ - delay_) * static_cast<double>(fade_left_) /
                                 static_cast<double>(kFade)
                  : delay_;
  }
  [[nodiscard]] float tap(double delay) const noexcept {
    // The cubic needs a sample on either side: below one sample of delay the straight line has to do.
    const auto whole = static_cast<std::size_t>(delay);
    const float x = static_cast<float>(delay - static_cast<double>(whole));
    const auto at = [&](std::size_t back) { return line_[(write_ - back) & mask_]; };
    if (x == 0)
      return at(whole);
    if (whole == 0)
      return at(0) + x * (at(1) - at(0));
    const float a = at(whole - 1), b = at(whole), c = at(whole + 1), d = at(whole + 2);
    return -x * (x - 1) * (x - 2) / 6 * a + (x + 1) * (x - 1) * (x - 2) / 2 * b -
           (x + 1) * x * (x - 2) / 2 * c + (x + 1) * x * (x - 1) / 6 * d;
  }

  std::vector<float> line_ = std::vector<float>(16, 0.0F);
  std::size_t mask_ = 15, write_ = 0, fade_left_ = 0;
  double delay_ = 0, old_delay_ = 0;
  bool glide_ = false;
};

} // namespace tactus::modal
