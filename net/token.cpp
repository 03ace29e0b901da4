#include "net/token.hpp"

#include <algorithm>

namespace tactus::net {

bool equal_in_constant_time(std::string_view expected, std::string_view given) noexcept {
  if (expected.empty())
    return given.empty();
  std::size_t difference = expected.size() ^ given.size();
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto byte = static_cast<unsigned char>(expected[i % expected.size()] ^ given[i]);
    difference |= byte;
  }
  return difference == 0;
}

bool LockOut::locks(const Entry& entry, double now_s) noexcept {
  return entry.failures >= kMaxFailures && now_s - entry.last_s < kLocked_s;
}

/// True for an entry that no longer counts, because its lock-out is over or its failures are long
/// ago.
bool LockOut::expired(const Entry& entry, double now_s) noexcept {
  return entry.failures == 0 || now_s - entry.last_s >= kExpiry_s ||
         (entry.failures >= kMaxFailures && now_s - entry.last_s >= kLocked_s);
}

bool LockOut::locked(std::string_view peer, double now_s) const noexcept {
  const auto* found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.failures > 0 && entry.peer == peer;
  });
  return locks(found != entries_.end() ? *found : overflow_, now_s);
}

void LockOut::fail(std::string_view peer, double now_s) {
  auto* found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.failures > 0 && entry.peer == peer;
  });
  if (found == entries_.end())
    found = std::find_if(entries_.begin(), entries_.end(),
                         [now_s](const Entry& entry) { return expired(entry, now_s); });
  Entry& entry = found != entries_.end() ? *found : overflow_;
  if (expired(entry, now_s))
    entry.failures = 0;
  entry.peer = peer;
  ++entry.failures;
  entry.last_s = now_s;
}

void LockOut::succeed(std::string_view peer) noexcept {
  for (Entry& entry : entries_)
    if (entry.peer == peer)
      entry.failures = 0;
}

} // namespace tactus::net
