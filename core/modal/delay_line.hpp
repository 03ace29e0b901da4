#pragma once

#include <algorithm>
#include <array>
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
    while (size < longest + kRoom)
      size *= 2;
    line_.assign(size, 0);
    mask_ = size - 1;
    write_ = 0;
    fade_left_ = 0;
  }
  void set(double samples, bool glide, bool jump) noexcept {
    const double target = std::clamp(samples, 0.0, static_cast<double>(line_.size() - kRoom));
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

  /// The same for many samples, in place.
  void run(float* sound, std::size_t count) noexcept {
    while (count > 0) {
      const std::size_t part = std::min(count, kPart);
      if (fade_left_ > 0)
        for (std::size_t n = 0; n < part; ++n)
          sound[n] = step(sound[n]);
      else
        run_part(sound, part);
      sound += part;
      count -= part;
    }
  }

private:
  static constexpr std::size_t kPart = 64;        ///< samples worked together
  static constexpr std::size_t kRoom = kPart + 8; ///< beyond the longest delay

  /// A delay that stays: all samples go in first, and the line's piece around the delayed ones is
  /// laid out straight.
  void run_part(float* sound, std::size_t count) noexcept {
    const std::size_t to_end = std::min(count, line_.size() - (write_ & mask_));
    std::copy_n(sound, to_end, line_.data() + (write_ & mask_));
    std::copy_n(sound + to_end, count - to_end, line_.data());
    if (delay_ == 0) {
      write_ += count;
      return;
    }
    const auto whole = static_cast<std::size_t>(delay_);
    const float x = static_cast<float>(delay_ - static_cast<double>(whole));
    std::array<float, kPart + 3> piece;
    const std::size_t first = (write_ - whole - 2) & mask_; // two before the first sample's place
    write_ += count;
    const std::size_t there = std::min(count + 3, line_.size() - first);
    std::copy_n(line_.data() + first, there, piece.data());
    std::copy_n(line_.data(), count + 3 - there, piece.data() + there);
    if (whole == 0) { // the last of the piece is still to come, and not needed
      for (std::size_t n = 0; n < count; ++n)
        sound[n] = piece[n + 2] + x * (piece[n + 1] - piece[n + 2]);
      return;
    }
    const Cubic cubic(x);
    for (std::size_t n = 0; n < count; ++n)
      sound[n] = cubic.a * piece[n + 3] + cubic.b * piece[n + 2] + cubic.c * piece[n + 1] +
                 cubic.d * piece[n];
  }

  /// Weights of four samples around a place between the second and the third.
  struct Cubic {
    explicit Cubic(float x) noexcept
        : a(-x * (x - 1) * (x - 2) / 6), b((x + 1) * (x - 1) * (x - 2) / 2),
          c(-(x + 1) * x * (x - 2) / 2), d((x + 1) * x * (x - 1) / 6) {}
    float a, b, c, d;
  };
  [[nodiscard]] double current() const noexcept {
    return glide_ ? delay_ + (old_delay_ - delay_) * static_cast<double>(fade_left_) /
                                 static_cast<double>(kFade)
                  : delay_;
  }
  [[nodiscard]] float tap(double delay) const noexcept {
    // The cubic needs a sample on either side: below one sample of delay the straight line has to
    // do.
    const auto whole = static_cast<std::size_t>(delay);
    const float x = static_cast<float>(delay - static_cast<double>(whole));
    const auto at = [&](std::size_t back) { return line_[(write_ - back) & mask_]; };
    if (whole == 0)
      return at(0) + x * (at(1) - at(0));
    const Cubic cubic(x);
    return cubic.a * at(whole - 1) + cubic.b * at(whole) + cubic.c * at(whole + 1) +
           cubic.d * at(whole + 2);
  }

  std::vector<float> line_ = std::vector<float>(128, 0.0F);
  std::size_t mask_ = 127, write_ = 0, fade_left_ = 0;
  double delay_ = 0, old_delay_ = 0;
  bool glide_ = false;
};

} // namespace tactus::modal
