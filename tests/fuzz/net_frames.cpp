// The haptic protocol's frames: three framings, OSC and FUDI.
#include "net/framing.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace tactus::net;

namespace {

FrameReader whole, cut, again;

void check_message(Framing framing, const Message& message) {
  using tactus::fuzz::check;
  for (std::size_t i = 0; i < message.size(); ++i)
    check(std::isfinite(message.number_at(i).value_or(0)),
          "a number that is not finite was let through");
  if (message.address() == Address::kUnknown)
    return;
  // What was read can be written and read again, and is the same.
  static std::array<std::uint8_t, 4 * kMaxSent> bytes;
  const std::size_t size = encode_frame(framing, message, bytes);
  if (size == 0)
    return; // longer than what this side sends
  again = FrameReader{};
  std::span<const std::uint8_t> rest(bytes.data(), size);
  Message back;
  check(again.next(rest, back) == FrameReader::Outcome::kMessage, "what was written is not read");
  check(back.address() == message.address() && back.size() == message.size(),
        "what was written is read as another message");
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  whole = FrameReader{};
  cut = FrameReader{};
  Message one, other;
  std::span<const std::uint8_t> rest = input;
  std::size_t at = 0;
  for (;;) {
    const auto outcome = whole.next(rest, one);
    // The same bytes one at a time give the same outcomes.
    auto single = FrameReader::Outcome::kNeedMore;
    const std::size_t end = input.size() - rest.size();
    while (at < end && single == FrameReader::Outcome::kNeedMore) {
      auto byte = input.subspan(at++, 1);
      single = cut.next(byte, other);
    }
    std::span<const std::uint8_t> nothing;
    if (single != outcome) // the next of a bundle, or broken for ever
      single = cut.next(nothing, other);
    check(single == outcome, "the outcome depends on how the stream is cut");
    check(at == end, "a frame ends elsewhere when the stream is cut");
    if (outcome == FrameReader::Outcome::kMessage) {
      check(one == other, "the message depends on how the stream is cut");
      check_message(*whole.framing(), one);
    }
    if (outcome == FrameReader::Outcome::kNeedMore || outcome == FrameReader::Outcome::kBroken)
      break;
  }
}
