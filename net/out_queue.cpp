#include "net/out_queue.hpp"

#include <algorithm>

namespace tactus::net {

void OutQueue::add(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes)
    ring_[end_++ % kCapacity] = byte;
}

bool OutQueue::add_event(std::span<const std::uint8_t> bytes) {
  if (size() + bytes.size() > kCapacity)
    return false;
  add(bytes);
  return true;
}

bool OutQueue::add_sample(std::span<const std::uint8_t> bytes) {
  if (size() + bytes.size() > kStreamLimit) {
    ++left_out_;
    return false;
  }
  add(bytes);
  return true;
}

std::span<const std::uint8_t> OutQueue::front() const noexcept {
  const std::size_t from = begin_ % kCapacity;
  return {ring_.data() + from, std::min(size(), kCapacity - from)};
}

} // namespace tactus::net
