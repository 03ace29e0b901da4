#include "core/reed/player.hpp"

#include "core/reed/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {

void Player::set(const Parameters& parameters, const BoreDesign& bore) noexcept {
  parameters_ = parameters;
  bore_ = bore;
  lengths_.set(parameters);
  ear_.forget();
  due_ = true;
}

const Player::Hold& Player::control(double bore_frequency, double reed_frequency) noexcept {
  hold_.valve_changed = false;
  if (listens_)
    ear_.hear();
  const bool moved = !(bore_frequency == bore_frequency_); // true also for a first NaN
  if (moved)
    bore_frequency_ = bore_frequency > 0 && bore_frequency < 1e9 ? bore_frequency : 0;
  if (moved || due_) {
    const double f =
        std::clamp(bore_frequency_, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
    const bool played = plays_;
    plays_ = parameters_.tune && bore_frequency_ > 0 && !(parameters_.length_override > 0);
    listens_ = plays_ && parameters_.ear;
    if (plays_) {
      const bool leap = due_ || !(std::abs(f - note_) < Ear::kLeap * note_);
      note_ = f;
      if (listens_)
        ear_.mean(f);
      Playing lips = player_lips(parameters_, f);
      hold_.length = lengths_.length(f, reed_frequency, leap);
      hold_.valve_changed = due_ || !played || parameters_.embouchure > 0;
      if (hold_.valve_changed)
        hold_.valve = lips.valve;
      own_scale_ = lips.reed_scale;
    } else {
      note_ = 0;
      hold_.valve = parameters_;
      hold_.valve_changed = true;
      hold_.length = parameters_.length_override > 0 ? parameters_.length_override
                     : bore_frequency_ > 0           ? bore_.length_for(f)
                                                     : parameters_.length;
      own_scale_ = 1;
    }
    hold_.length = std::clamp(hold_.length, 5e-3, bore_.longest());
    due_ = false;
    set_trim(listens_ ? ear_.trim() : 0, true);
  } else if (listens_) {
    ear_.mean(note_);
    set_trim(ear_.trim(), false);
  }
  return hold_;
}

/// Plays sharper by exp(logarithm): the bore shorter, the lips tighter where they are the player's
/// to choose. A change that nobody hears is left out, for a bore at rest is cheaper.
void Player::set_trim(double logarithm, bool moved) noexcept {
  constexpr double kInaudible = 1e-4; // 0.17 cents
  if (!moved && std::abs(logarithm - hold_.trim) < kInaudible && logarithm != 0)
    return;
  hold_.trim = logarithm;
  hold_.reed_scale = parameters_.embouchure > 0 ? own_scale_ * std::exp(logarithm) : own_scale_;
}

} // namespace tactus::reed
