#pragma once

#include "net/message.hpp"

namespace tactus::net {

/// How a topic of the modules' bus (docs/audiohaptics.md) is transmitted.
struct BusTopic {
  /// An event is never dropped while its connection lasts; an old sample of a stream may be.
  bool is_event = true;
  /// The first field is a time in ms by the sender's bus. On the wire this time counts from the
  /// message's own time.
  bool has_time = false;
};
/// Looks up a topic; a topic that is not in the table is an event without a time.
[[nodiscard]] BusTopic bus_topic(std::string_view name) noexcept;

/// True for 1 to 32 letters, digits, `_` and `-`.
[[nodiscard]] bool is_topic_name(std::string_view name) noexcept;

/// A topic's message begins with its sequence number and its time.
inline constexpr std::size_t kTopicHead = 2;
inline constexpr std::size_t kMaxTopicFields = Message::kMaxArguments - kTopicHead;

} // namespace tactus::net
