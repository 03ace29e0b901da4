#include "core/refusal.hpp"
#include "externals/footstep~/footstep~.hpp"

#include <numbers>
#include <optional>
#include <string>

// The messages turn, jump, scuff and drag, and which foot a message is for.

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

std::optional<std::size_t> Footstep::side_named(std::span<const Atom> arguments) noexcept {
  for (std::size_t side = 0; side < kSides.size(); ++side)
    if (!arguments.empty() && arguments[0].is_word && arguments[0].word == kSides[side])
      return side;
  return std::nullopt;
}

std::size_t Footstep::next_side() noexcept {
  const std::size_t side = value_[kFeet] >= 1.5 ? next_foot_ : 0;
  next_foot_ = 1 - side;
  return side;
}

void Footstep::turn(std::span<const Atom> arguments, Host& host) {
  const auto degrees = number(arguments, 0, kTurnDegrees);
  if (!degrees)
    return host.error(refusal("turn", arguments, "1 to 180 degrees"));
  gait_.turn(*degrees * std::numbers::pi / 180, next_side());
}

void Footstep::jump(std::span<const Atom> arguments, Host& host) {
  const auto height = number(arguments, 0, kJumpHeight);
  if (!height)
    return host.error(refusal("jump", arguments, "a height of 0.01 to 1 m"));
  gait_.jump(*height);
}

void Footstep::scuff(std::span<const Atom> arguments, Host& host) {
  const auto side = side_named(arguments);
  if (!side && !arguments.empty())
    return host.error(refusal("scuff", arguments, "left or right"));
  gait_.scuff(side ? *side : next_side());
}

void Footstep::drag(std::span<const Atom> arguments, Host& host) {
  const auto side = side_named(arguments);
  const auto numbers = arguments.subspan(side ? 1 : 0);
  const auto length = number(numbers, 0, kDragLength), speed = number(numbers, 1, kDragSpeed);
  if (!length || !speed || numbers.size() > 2)
    return host.error(
        refusal("drag", arguments, "left or right, then 0.01 to 20 m and 0.02 to 5 m/s"));
  gait_.drag(side ? *side : next_side(), *length, *speed);
}

} // namespace tactus::footstep
