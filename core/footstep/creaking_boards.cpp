#include "core/footstep/creaking_boards.hpp"

#include "core/footstep/floor_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::footstep {
namespace {

constexpr double kReferenceShift = 10;  // reference weights a second
constexpr double kWobbleTime = 0.02;    // s
constexpr double kSettlingTime = 0.3;   // s, in which the boards ring out under the pressed joint
constexpr double kLeastLoad = 0.01;     // reference weights; less presses nothing together

} // namespace

CreakingBoards::CreakingBoards() : body_(kModes + kJoint, 1, 1) {}

void CreakingBoards::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  body_.prepare(sample_rate);
  wobble_kept_ = std::exp(-1 / (kWobbleTime * sample_rate));
}

void CreakingBoards::seed(std::uint64_t value) noexcept {
  random_.seed(value);
  body_.seed(0, random_.next());
}

void CreakingBoards::reset() noexcept {
  body_.reset();
  body_.rub(0, 0, 0);
  wobble_ = 0;
  settling_ = 0;
}

void CreakingBoards::set(const FrictionRecipe& friction) noexcept {
  body_.set_friction(0, friction.law);
}

void CreakingBoards::move_to(const FrictionRecipe& friction, std::span<const double> detune,
                             double frequency, double decay) noexcept {
  const std::array<contact::Mode, kJoint> joint{
      contact::Mode{friction.joint_hz * frequency, friction.joint_t60_s, friction.joint_kg}};
  tune(body_, friction.modes, detune.first(std::min(detune.size(), kModes)), frequency, decay,
       joint);
  std::array<double, kModes + kJoint> shape{};
  const auto places = place_shape(friction.modes, random_);
  std::copy_n(places.begin(), kModes, shape.begin() + kJoint);
  shape[0] = 1;
  body_.set_place(0, shape);
  speed_factor_ = drawn(friction.scatter.level, random_);
}

double CreakingBoards::next(const FrictionRecipe& friction, double load, double shift) noexcept {
  if (load > kLeastLoad) {
    wobble_ =
        wobble_kept_ * wobble_ + std::sqrt(1 - wobble_kept_ * wobble_kept_) * random_.normal();
    const double uneven = std::max(0.0, 1 + friction.wobble * wobble_);
    body_.rub(0, (friction.pressed_n + friction.load_n * load) * uneven,
              friction.slip_m_per_s * speed_factor_ * shift / kReferenceShift * uneven);
    settling_ = kSettlingTime * sample_rate_;
  } else if (settling_ > 0) {
    body_.rub(0, friction.pressed_n, 0);
    settling_ -= 1;
  }
  if (!active())
    return 0;
  body_.step();
  return body_.hear(0);
}

} // namespace tactus::footstep
