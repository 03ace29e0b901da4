#pragma once

#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// Interpolates the numbers of an instrument linearly over kTime while it sounds, stepped once per
/// control period.
class ParameterGlide {
public:
  static constexpr double kTime = 0.016; ///< s

  void prepare(double control_rate) noexcept {
    periods_ = static_cast<int>(kTime * control_rate) + 1;
  }
  /// Takes these parameters at once.
  void jump(const Parameters& parameters) noexcept {
    current_ = target_ = parameters;
    periods_left_ = 0;
  }
  /// Begins the glide to the target.
  void begin(const Parameters& target) noexcept {
    periods_left_ = periods_;
    target_ = target;
  }
  [[nodiscard]] const Parameters& current() const noexcept { return current_; }
  /// The parameters last reached or approached, without the player's lips.
  [[nodiscard]] const Parameters& parameters() const noexcept { return target_; }
  [[nodiscard]] bool is_moving() const noexcept { return periods_left_ > 0; }
  /// To be called once per control period while is_moving(). target: with the player's lips.
  void move(const Parameters& target) noexcept {
    current_ = periods_left_ == 1 ? target : interpolate(current_, target, 1.0 / periods_left_);
    --periods_left_;
  }
  /// Sets the present parameters to those with the player's lips.
  void follow(const Parameters& held) noexcept { current_ = held; }

private:
  Parameters current_{}, target_{};
  int periods_ = 1, periods_left_ = 0;
};

} // namespace tactus::reed
