#include "core/modal/body/output_stage.hpp"

#include "core/dsp/soft_clip.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

constexpr double kGainSpeed = 0.005; // share of the remaining change, per sample

} // namespace

void OutputStage::set_delays(const BodyModel& body, bool doppler, bool jump) noexcept {
  for (std::size_t l = 0; l < kMaxListeners; ++l)
    delay_[l].set(body.delay_s[l] * sample_rate_, doppler, jump);
}

void OutputStage::set_gain(double gain) noexcept {
  gain_ = gain;
  if (silent())
    smooth_gain_ = gain;
}

void OutputStage::delay(ChannelBlock& sound, std::size_t listeners, std::size_t frames) noexcept {
  for (std::size_t l = 0; l < listeners; ++l)
    delay_[l].run(sound[l].data(), frames);
}

void OutputStage::amplify(ChannelBlock& sound, std::size_t listeners, std::size_t frames,
                          bool soft_limit) noexcept {
  const double start = smooth_gain_;
  std::size_t silent = silent_samples_ + frames;
  for (std::size_t l = 0; l < listeners; ++l) {
    auto& channel = sound[l];
    for (std::size_t n = frames; n > 0 && frames - n < silent; --n)
      if (channel[n - 1] != 0)
        silent = frames - n;
    smooth_gain_ = start;
    std::size_t n = 0;
    for (; n < frames && smooth_gain_ != gain_; ++n) {
      smooth_gain_ += kGainSpeed * (gain_ - smooth_gain_);
      if (std::abs(smooth_gain_ - gain_) <= 1e-6 * gain_)
        smooth_gain_ = gain_;
      channel[n] *= static_cast<float>(smooth_gain_);
    }
    const auto steady = static_cast<float>(smooth_gain_);
    for (; n < frames; ++n)
      channel[n] *= steady;
    for (n = 0; n < frames; ++n)
      channel[n] = channel[n] - channel[n] == 0 ? channel[n] : 0; // NaN and infinity become 0
    if (soft_limit)
      for (n = 0; n < frames; ++n)
        channel[n] = static_cast<float>(soft_clip(static_cast<double>(channel[n])));
  }
  silent_samples_ = std::min(silent, kSilence);
}

} // namespace tactus::modal
