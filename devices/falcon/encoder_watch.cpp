#include "devices/falcon/encoder_watch.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::devices::falcon {
namespace {

constexpr double kLowPass_s = 0.05, kLargest_n = 100;
constexpr double kSettled_s = 1; // after a question, before motion counts as the hand's own
constexpr int kMotion = 50;      // ticks with changed counts that are no more than stillness

} // namespace

// A count has changed.
void EncoderWatch::answer(double period_s) noexcept {
  if (asking_) {
    wait_s_ = std::min(2 * wait_s_, kMaxWait_s);
    since_asked_s_ = 0;
    moved_ = 0;
  } else if (since_asked_s_ > kSettled_s && ++moved_ >= kMotion) {
    wait_s_ = kWait_s;
  }
  asking_ = frozen_ = false;
  still_s_ = unanswered_s_ = none_s_ = 0;
  reference_ = sent_;
  gain_ = std::min(1.0, gain_ + period_s / kReturn_s);
}

void EncoderWatch::update(bool changed, const haptic::Vec3& asked_n, double period_s,
                          bool active) noexcept {
  if (!(period_s > 0))
    return;
  since_asked_s_ += period_s;
  const haptic::Vec3 finite = haptic::limited(asked_n, kLargest_n);
  const double share = std::min(1.0, period_s / kLowPass_s);
  asked_ += (finite - asked_) * share;
  sent_ += (finite * gain_ - sent_) * share;
  if (!active) {
    reset();
    return;
  }
  if (changed) {
    answer(period_s);
    return;
  }
  const double asked = norm(asked_);
  const bool out_of_band = norm(sent_ - reference_) > kBand_n;
  still_s_ = asked > kBand_n ? still_s_ + period_s : 0;
  unanswered_s_ += out_of_band ? period_s : 0;
  if (!asking_)
    asking_ = asked > kBand_n && (still_s_ >= wait_s_ || unanswered_s_ >= kUnanswered_s);
  if (!asking_) {
    gain_ = std::min(1.0, gain_ + period_s / kReturn_s);
    return;
  }
  gain_ = std::max(0.0, gain_ - period_s / kFade_s);
  none_s_ = gain_ > 0 ? 0 : none_s_ + period_s;
  if (none_s_ < kNone_s)
    return;
  frozen_ = frozen_ || out_of_band || unanswered_s_ >= kUnanswered_s;
  if (frozen_)
    return;
  // The patch took its force away by itself, before it could decide anything.
  asking_ = false;
  still_s_ = unanswered_s_ = none_s_ = 0;
  reference_ = sent_;
}

} // namespace tactus::devices::falcon
