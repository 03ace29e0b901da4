#include "core/refusal.hpp"
#include "externals/footstep~/footstep~.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>

// The messages turn, jump, scuff and drag, and the choice of a message's foot.

namespace tactus::footstep {
namespace {

struct Range {
  double initial, lowest, highest;
};
constexpr Range kTurnDegrees{90, 1, 180}, kJumpHeight{0.3, kMinJump, kMaxJump},
    kDragLength{0.5, kMinDrag, kMaxDrag}, kDragSpeed{0.5, kMinDragSpeed, kMaxDragSpeed};

/// Argument number i, or its default if it is missing; empty if it is out of range.
std::optional<double> number(std::span<const Atom> arguments, std::size_t i, const Range& range) {
  if (i >= arguments.size())
    return range.initial;
  const Atom& word = arguments[i];
  if (word.is_word || !(word.number >= range.lowest && word.number <= range.highest))
    return std::nullopt;
  return word.number;
}

} // namespace

void Footstep::begin_block(double start_ms) noexcept {
  if (!std::isfinite(start_ms))
    return movements_.expire_all();
  const std::int64_t sample = std::llround(1e-3 * start_ms * sample_rate_);
  // Rounding must not open a gap of one sample between consecutive blocks.
  if (std::abs(sample - clock_) > 1)
    clock_ = sample;
}

void Footstep::schedule(const Movement& movement, const Host& host) noexcept {
  if (movements_.full())
    move(movements_.pop());
  movements_.push(std::llround(1e-3 * host.now_ms() * sample_rate_), movement);
}

void Footstep::move(const Movement& movement) noexcept {
  if (const auto* step = std::get_if<Step>(&movement))
    gait_.step(step->foot);
  else if (const auto* turn = std::get_if<Turn>(&movement))
    gait_.turn(turn->angle_rad, turn->foot);
  else if (const auto* jump = std::get_if<Jump>(&movement))
    gait_.jump(jump->height_m);
  else if (const auto* scuff = std::get_if<Scuff>(&movement))
    gait_.scuff(scuff->foot);
  else if (const auto* drag = std::get_if<Drag>(&movement))
    gait_.drag(drag->foot, drag->length_m, drag->speed_m_per_s);
}

std::optional<std::size_t> Footstep::side_named(std::span<const Atom> arguments) noexcept {
  for (std::size_t side = 0; side < kSideNames.size(); ++side)
    if (!arguments.empty() && arguments[0].is_word && arguments[0].word == kSideNames[side])
      return side;
  return std::nullopt;
}

std::size_t Footstep::next_side() noexcept {
  const std::size_t side = settings_.feet >= 1.5 ? next_foot_ : 0;
  next_foot_ = 1 - side;
  return side;
}

void Footstep::step(std::span<const Atom> arguments, Host& host) {
  const auto side = side_named(arguments);
  if (!side && !arguments.empty())
    return host.error(refusal("step", arguments, "left or right"));
  schedule(Step{side.value_or(0)}, host);
}

void Footstep::turn(std::span<const Atom> arguments, Host& host) {
  const auto degrees = number(arguments, 0, kTurnDegrees);
  if (!degrees)
    return host.error(refusal("turn", arguments, "1..180 degrees"));
  schedule(Turn{*degrees * std::numbers::pi / 180, next_side()}, host);
}

void Footstep::jump(std::span<const Atom> arguments, Host& host) {
  const auto height = number(arguments, 0, kJumpHeight);
  if (!height)
    return host.error(refusal("jump", arguments, "a height in 0.01..1 m"));
  schedule(Jump{*height}, host);
}

void Footstep::scuff(std::span<const Atom> arguments, Host& host) {
  const auto side = side_named(arguments);
  if (!side && !arguments.empty())
    return host.error(refusal("scuff", arguments, "left or right"));
  schedule(Scuff{side ? *side : next_side()}, host);
}

void Footstep::drag(std::span<const Atom> arguments, Host& host) {
  const auto side = side_named(arguments);
  const auto numbers = arguments.subspan(side ? 1 : 0);
  const auto length = number(numbers, 0, kDragLength), speed = number(numbers, 1, kDragSpeed);
  if (!length || !speed || numbers.size() > 2)
    return host.error(refusal("drag", arguments, "left or right, then 0.01..20 m and 0.02..5 m/s"));
  schedule(Drag{side ? *side : next_side(), *length, *speed}, host);
}

} // namespace tactus::footstep
