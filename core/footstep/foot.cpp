#include "core/footstep/foot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr double kGlide = 0.02; // s, of a change of the mixture
constexpr double kLeave = 0.3;  // s, of a ground that is left
constexpr double kNothing = 1e-5;

} // namespace

Foot::Foot() { seed(1); }

void Foot::prepare(double sample_rate) {
  for (Stand& stand : stands_)
    stand.ground.prepare(sample_rate);
  drive_.prepare(sample_rate);
  room_.prepare(sample_rate);
  glide_ = 1 - std::exp(-1 / (kGlide * sample_rate));
  leave_ = 1 - std::exp(-1 / (kLeave * sample_rate));
}

void Foot::seed(std::uint64_t value) noexcept {
  for (std::size_t i = 0; i < kGrounds; ++i)
    stands_[i].ground.seed(value * kGrounds + i);
}

void Foot::set_shoe(double shoe) noexcept {
  if (shoe == shoe_)
    return;
  shoe_ = shoe;
  for (Stand& stand : stands_)
    if (stand.id)
      stand.ground.set(stand.recipe, shoe);
}

void Foot::set_weight(double weight_n) noexcept {
  if (weight_n == weight_n_)
    return;
  weight_n_ = weight_n;
  for (Stand& stand : stands_)
    stand.ground.set_weight(weight_n);
}

void Foot::reset() noexcept {
  for (Stand& stand : stands_) {
    stand.ground.reset();
    stand.part = stand.wanted;
  }
  drive_.reset();
  room_.reset();
}

Foot::Stand* Foot::take(std::uint64_t id, const Recipe& recipe, const Stand* keep) noexcept {
  // One that has it, else a free one, else the one that was left first; there are more than the two
  // in use and the one to keep.
  std::size_t best = 0;
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t i = 0; i < kGrounds; ++i) {
    const Stand& stand = stands_[i];
    if (&stand == keep)
      continue;
    if (stand.id == id)
      return &stands_[i];
    const std::uint64_t since = stand.id == 0 ? 0 : stand.since;
    if (&stand != a_ && &stand != b_ && since < oldest) {
      oldest = since;
      best = i;
    }
  }
  Stand* const chosen = &stands_[best];
  if (chosen->id == 0)
    in_use_[used_++] = chosen;
  chosen->ground.reset();
  chosen->ground.set(recipe, shoe_);
  chosen->recipe = recipe;
  chosen->id = id;
  chosen->to_room =
      recipe.room.level_db > Room::kLowestLevel ? std::pow(10.0, recipe.room.level_db / 20) : 0;
  chosen->part = 0;
  return chosen;
}

void Foot::stand_on(std::uint64_t a_id, const Recipe& a, std::uint64_t b_id, const Recipe& b,
                    double mix) noexcept {
  const bool first = a_ == nullptr;
  Stand* next_a = take(a_id, a, nullptr);
  Stand* next_b = b_id == a_id ? next_a : take(b_id, b, next_a);
  a_ = next_a;
  b_ = next_b;
  ++clock_;
  for (Stand& stand : stands_) {
    if (&stand == a_ || &stand == b_)
      stand.since = clock_;
    else
      stand.wanted = 0;
  }
  set_mix(mix);
  if (first)
    for (Stand& stand : stands_)
      stand.part = stand.wanted;
}

void Foot::set_mix(double mix) noexcept {
  mix_ = std::clamp(mix, 0.0, 1.0);
  if (!a_)
    return;
  if (a_ == b_) {
    a_->wanted = 1;
    return furnish();
  }
  // Two grounds are independent sounds: their powers add up to one.
  a_->wanted = mix_ >= 1 ? 0 : std::cos(0.5 * std::numbers::pi * mix_);
  b_->wanted = mix_ <= 0 ? 0 : std::sin(0.5 * std::numbers::pi * mix_);
  furnish();
}

/// The room between two grounds' rooms; how much of each ground's sound it gets is the ground's
/// own.
void Foot::furnish() noexcept {
  const Room::Settings &a = a_->recipe.room, &b = b_->recipe.room;
  const auto between = [this](double x, double y) { return x * std::pow(y / x, mix_); };
  // Of two grounds without a room and with one, the one with it decides what it is like.
  if (a_->to_room == 0 || b_->to_room == 0) {
    const Room::Settings& only = a_->to_room > 0 ? a : b;
    return room_.set({0, only.t60_s, only.bright_hz});
  }
  room_.set({0, between(a.t60_s, b.t60_s), between(a.bright_hz, b.bright_hz)});
}

Foot::Out Foot::next(const SoleState& sole) noexcept {
  double heel_felt = 0, ball_felt = 0, heard = 0, to_room = 0;
  for (std::size_t i = 0; i < used_; ++i) {
    Stand& stand = *in_use_[i];
    const bool current = &stand == a_ || &stand == b_;
    if (stand.part != stand.wanted) {
      stand.part += (current ? glide_ : leave_) * (stand.wanted - stand.part);
      if (std::abs(stand.part - stand.wanted) < kNothing)
        stand.part = stand.wanted;
    }
    if (stand.part == 0 && stand.wanted == 0) {
      if (!current) {
        stand.id = 0;
        in_use_[i--] = in_use_[--used_];
      }
      continue;
    }
    // Nothing steps on a ground that is left: it only rings out.
    const Ground::Sound sound = stand.ground.next(current ? sole : SoleState{});
    heel_felt += stand.part * sound.heel_felt;
    ball_felt += stand.part * sound.ball_felt;
    heard += stand.part * sound.heard;
    to_room += stand.to_room * stand.part * sound.heard;
  }
  const Drive::Pair pair = drive_.next(heel_felt, ball_felt, sole.heel_n, sole.ball_n);
  return {heard + room_.next(room_factor_ * to_room), pair.heel, pair.ball};
}

} // namespace tactus::footstep
