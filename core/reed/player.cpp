#include "core/reed/player.hpp"

#include "core/reed/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {

void Player::set(const Parameters& parameters, const BoreDesign& bore) noexcept {
  parameters_ = parameters;
  bore_ = bore;
  ear_.forget();
  due_ = true;
}

const Player::Hold& Player::control(double bore_frequency, double reed_frequency) noexcept {
  hold_.valve_changed = false;
  if (!(bore_frequency == bore_frequency_)) { // false also for a first NaN
    bore_frequency_ = bore_frequency > 0 && bore_frequency < 1e9 ? bore_frequency : 0;
    due_ = true;
  }
  if (due_)
    choose(reed_frequency);
  if (listens_)
    trim(ear_.trim());
  return hold_;
}

void Player::choose(double reed_frequency) noexcept {
  due_ = false;
  Playing playing{parameters_, parameters_.length};
  const double f =
      std::clamp(bore_frequency_, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
  listens_ = parameters_.tune && bore_frequency_ > 0 && !(parameters_.length_override > 0);
  if (listens_)
    playing = tuned(parameters_, f, reed_frequency);
  else if (bore_frequency_ > 0)
    playing.length = bore_.length_for(f);
  if (parameters_.length_override > 0)
    playing.length = parameters_.length_override;
  hold_.length = std::clamp(playing.length, 5e-3, bore_.longest());
  hold_.valve = playing.valve;
  hold_.valve_changed = true;
  own_scale_ = playing.reed_scale;
  listens_ = listens_ && parameters_.ear;
  if (listens_)
    ear_.mean(f);
  trim(listens_ ? ear_.trim() : 0);
}

/// Plays sharper by exp(logarithm): the bore shorter, the lips tighter where they are the player's
/// to choose. A change that nobody hears is left out, for a bore at rest is cheaper.
void Player::trim(double logarithm) noexcept {
  constexpr double kInaudible = 1e-4; // 0.17 cents
  if (std::abs(logarithm - hold_.trim) < kInaudible && logarithm != 0 && trim_scale_ == own_scale_)
    return;
  hold_.trim = logarithm;
  trim_scale_ = own_scale_;
  hold_.reed_scale = parameters_.embouchure > 0 ? own_scale_ * std::exp(logarithm) : own_scale_;
}

} // namespace tactus::reed
