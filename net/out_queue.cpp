#include "net/out_queue.hpp"

namespace tactus::net {

/// Removes the sent bytes once they are the larger half, so that each byte is moved at most once.
void OutQueue::add(std::span<const std::uint8_t> bytes) {
  if (begin_ > size()) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

bool OutQueue::add_event(std::span<const std::uint8_t> bytes) {
  if (size() + bytes.size() > kCapacity)
    return false;
  add(bytes);
  return true;
}

bool OutQueue::add_sample(std::span<const std::uint8_t> bytes) {
  if (size() + bytes.size() > stream_limit_) {
    ++dropped_;
    return false;
  }
  add(bytes);
  return true;
}

void OutQueue::consume(std::size_t count) noexcept {
  begin_ += count;
  if (begin_ == bytes_.size()) {
    bytes_.clear();
    begin_ = 0;
  }
}

} // namespace tactus::net
