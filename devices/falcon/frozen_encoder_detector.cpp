#include "devices/falcon/frozen_encoder_detector.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::devices::falcon {
namespace {

constexpr double kLowPass_s = 0.05, kMaxForce_n = 100;
constexpr double kSettled_s = 1; // after a test; the returning force may cause earlier motion
constexpr int kMotion = 50;      // ticks with changed counts that show a moving hand

} // namespace

// Called when a count has changed, which shows that the encoders work.
void FrozenEncoderDetector::end_test(double period_s) noexcept {
  if (testing_) {
    wait_s_ = std::min(2 * wait_s_, kMaxWait_s);
    since_test_s_ = 0;
    moved_ = 0;
  } else if (since_test_s_ > kSettled_s && ++moved_ >= kMotion) {
    wait_s_ = kWait_s;
  }
  testing_ = frozen_ = false;
  still_s_ = mismatch_s_ = zero_force_s_ = 0;
  reference_ = sent_;
  gain_ = std::min(1.0, gain_ + period_s / kReturn_s);
}

void FrozenEncoderDetector::update(bool changed, const Vec3& commanded_n, double period_s,
                                   bool active) noexcept {
  if (!(period_s > 0))
    return;
  since_test_s_ += period_s;
  const Vec3 finite = limited(commanded_n, kMaxForce_n);
  const double smoothing = std::min(1.0, period_s / kLowPass_s);
  commanded_ += (finite - commanded_) * smoothing;
  sent_ += (finite * gain_ - sent_) * smoothing;
  if (!active) {
    reset();
    return;
  }
  if (changed) {
    end_test(period_s);
    return;
  }
  const bool forced = norm(commanded_) > kBand_n;
  const bool out_of_band = norm(sent_ - reference_) > kBand_n;
  still_s_ = forced ? still_s_ + period_s : 0;
  mismatch_s_ += out_of_band ? period_s : 0;
  if (!testing_)
    testing_ = forced && (still_s_ >= wait_s_ || mismatch_s_ >= kMismatch_s);
  if (!testing_) {
    gain_ = std::min(1.0, gain_ + period_s / kReturn_s);
    return;
  }
  gain_ = std::max(0.0, gain_ - period_s / kFade_s);
  zero_force_s_ = gain_ > 0 ? 0 : zero_force_s_ + period_s;
  if (zero_force_s_ < kZeroForce_s)
    return;
  frozen_ = frozen_ || out_of_band || mismatch_s_ >= kMismatch_s;
  if (frozen_)
    return;
  // The patch ended its force during the test, within the friction band: the test is inconclusive.
  testing_ = false;
  still_s_ = mismatch_s_ = zero_force_s_ = 0;
  reference_ = sent_;
}

} // namespace tactus::devices::falcon
