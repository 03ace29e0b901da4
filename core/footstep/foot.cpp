#include "core/footstep/foot.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr double kMixTime = 0.02;  // s, time constant of a change of the mixture
constexpr double kLeaveTime = 0.3; // s, time constant of the fade of a ground that the foot has
                                   // left
constexpr double kCutTime = 0.005; // s, fade of a ground that loses its slot
constexpr double kGainThreshold = 1e-5;

} // namespace

Foot::Foot() { seed(1); }

void Foot::prepare(double sample_rate) {
  for (GroundSlot& slot : slots_)
    slot.ground.prepare(sample_rate);
  drive_.prepare(sample_rate);
  room_.prepare(sample_rate);
  glide_coefficient_ = 1 - math::exp(-1 / (kMixTime * sample_rate));
  leave_coefficient_ = 1 - math::exp(-1 / (kLeaveTime * sample_rate));
  cut_step_ = 1 / (kCutTime * sample_rate);
}

void Foot::seed(std::uint64_t value) noexcept {
  for (std::size_t i = 0; i < kGrounds; ++i)
    slots_[i].ground.seed(value * kGrounds + i);
}

void Foot::set_shoe(double shoe) noexcept {
  if (shoe == shoe_)
    return;
  shoe_ = shoe;
  for (GroundSlot& slot : slots_)
    if (slot.id)
      slot.ground.set(slot.recipe, shoe);
}

void Foot::set_weight(double weight_n) noexcept {
  if (weight_n == weight_n_)
    return;
  weight_n_ = weight_n;
  for (GroundSlot& slot : slots_)
    slot.ground.set_weight(weight_n);
}

void Foot::reset() noexcept {
  for (GroundSlot& slot : slots_) {
    slot.ground.reset();
    slot.gain = slot.target;
    slot.last = {};
  }
  cut_gain_ = 0;
  drive_.reset();
  room_.reset();
}

Foot::GroundSlot* Foot::acquire_slot(std::uint64_t id, const Recipe& recipe,
                                     const GroundSlot* keep) noexcept {
  // Finds the slot with this id, else a free slot, else the slot that was left longest ago.
  // kGrounds is larger than the two slots in use and the one to keep, so a slot is always found.
  std::size_t best = 0;
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t i = 0; i < kGrounds; ++i) {
    const GroundSlot& slot = slots_[i];
    if (&slot == keep)
      continue;
    if (slot.id == id)
      return &slots_[i];
    const std::uint64_t since = slot.id == 0 ? 0 : slot.since;
    if (&slot != a_ && &slot != b_ && since < oldest) {
      oldest = since;
      best = i;
    }
  }
  GroundSlot* const slot_taken = &slots_[best];
  if (slot_taken->id == 0)
    active_[active_count_++] = slot_taken;
  slot_taken->last.add(cut_, cut_gain_);
  cut_ = std::exchange(slot_taken->last, {});
  cut_gain_ = 1;
  slot_taken->ground.reset();
  slot_taken->ground.set(recipe, shoe_);
  slot_taken->recipe = recipe;
  slot_taken->id = id;
  slot_taken->reverb_send =
      recipe.room.level_db > Room::kMinLevel ? math::exp10(recipe.room.level_db / 20) : 0;
  slot_taken->gain = 0;
  return slot_taken;
}

void Foot::set_grounds(std::uint64_t a_id, const Recipe& a, std::uint64_t b_id, const Recipe& b,
                       double mix) noexcept {
  const bool first = a_ == nullptr;
  GroundSlot* next_a = acquire_slot(a_id, a, nullptr);
  GroundSlot* next_b = b_id == a_id ? next_a : acquire_slot(b_id, b, next_a);
  a_ = next_a;
  b_ = next_b;
  ++clock_;
  for (GroundSlot& slot : slots_) {
    if (&slot == a_ || &slot == b_)
      slot.since = clock_;
    else
      slot.target = 0;
  }
  set_mix(mix);
  if (first)
    for (GroundSlot& slot : slots_)
      slot.gain = slot.target;
}

void Foot::set_mix(double mix) noexcept {
  mix_ = std::clamp(mix, 0.0, 1.0);
  if (!a_)
    return;
  if (a_ == b_) {
    a_->target = 1;
    return update_room();
  }
  // The sounds of two grounds are uncorrelated: the squares of their gains sum to 1.
  a_->target = mix_ >= 1 ? 0 : math::cos(0.5 * std::numbers::pi * mix_);
  b_->target = mix_ <= 0 ? 0 : math::sin(0.5 * std::numbers::pi * mix_);
  update_room();
}

/// Interpolates between the rooms of two grounds. The reverb send stays that of each ground.
void Foot::update_room() noexcept {
  const Room::Settings &a = a_->recipe.room, &b = b_->recipe.room;
  const auto between = [this](double x, double y) { return x * math::pow(y / x, mix_); };
  // If only one ground has a room, its settings are used.
  if (a_->reverb_send == 0 || b_->reverb_send == 0) {
    const Room::Settings& active_settings = a_->reverb_send > 0 ? a : b;
    return room_.set({0, active_settings.t60_s, active_settings.bright_hz});
  }
  room_.set({0, between(a.t60_s, b.t60_s), between(a.bright_hz, b.bright_hz)});
}

Foot::Out Foot::next(const SoleState& sole) noexcept {
  Sum sum;
  cut_gain_ = std::max(cut_gain_ - cut_step_, 0.0);
  sum.add(cut_, cut_gain_);
  for (std::size_t i = 0; i < active_count_; ++i) {
    GroundSlot& slot = *active_[i];
    const bool current = &slot == a_ || &slot == b_;
    if (slot.gain != slot.target) {
      slot.gain += (current ? glide_coefficient_ : leave_coefficient_) * (slot.target - slot.gain);
      if (std::abs(slot.gain - slot.target) < kGainThreshold)
        slot.gain = slot.target;
    }
    if (slot.gain == 0 && slot.target == 0) {
      slot.last = {};
      if (!current) {
        slot.id = 0;
        active_[i--] = active_[--active_count_];
      } else if (!slot.ground.silent()) {
        slot.ground.reset(); // else its sound would continue when the mix returns to it
      }
      continue;
    }
    // A ground that the foot has left has no load, so its sound only decays.
    const Ground::Sound sound = slot.ground.next(current ? sole : SoleState{});
    slot.last = {};
    slot.last.add({sound.heel_vibration, sound.ball_vibration, sound.pressure_pa,
                   slot.reverb_send * sound.pressure_pa},
                  slot.gain);
    sum.add(slot.last, 1);
  }
  const ActuatorSignals::Pair pair =
      drive_.next(sum.heel_vibration, sum.ball_vibration, sole.heel_n, sole.ball_n);
  return {sum.pressure_pa + room_.next(room_factor_ * sum.reverb_send), pair.heel, pair.ball};
}

} // namespace tactus::footstep
