#include "net/playout_delay.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::net {
namespace {

std::int64_t slot_of(double now_s) noexcept {
  return static_cast<std::int64_t>(std::floor(now_s / PlayoutDelay::kSlot_s));
}

} // namespace

void PlayoutDelay::add(double delay_s, double now_s) noexcept {
  update(now_s);
  Slot& slot = slots_[static_cast<std::size_t>(last_slot_) % kSlots];
  slot = {last_slot_, slot.number == last_slot_ ? std::max(slot.max_s, delay_s) : delay_s};
  value_s_ = std::min(kMax_s, std::max(value_s_, delay_s + kMargin_s));
}

std::optional<double> PlayoutDelay::percentile_s() const noexcept {
  std::array<double, kSlots> samples;
  std::size_t count = 0;
  for (const Slot& slot : slots_)
    if (slot.number >= 0 && slot.number >= last_slot_ - static_cast<std::int64_t>(kSlots))
      samples[count++] = slot.max_s;
  if (count == 0)
    return {};
  const auto wanted =
      samples.begin() + static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(count - 1));
  std::nth_element(samples.begin(), wanted, samples.begin() + static_cast<std::ptrdiff_t>(count));
  return *wanted;
}

void PlayoutDelay::update(double now_s) noexcept {
  if (const std::int64_t slot = slot_of(now_s); slot > last_slot_) {
    last_slot_ = slot;
    // Without messages the measured delay is kept.
    if (const auto percentile = percentile_s())
      target_s_ = std::min(kMax_s, *percentile + kMargin_s);
  }
  value_s_ = std::max(target_s_, value_s_ - kFall_rate * (now_s - last_s_));
  last_s_ = now_s;
}

double PlayoutDelay::value(double now_s) noexcept {
  update(now_s);
  return fixed_s_ ? std::clamp(*fixed_s_, 0.0, kMax_s) : value_s_;
}

} // namespace tactus::net
