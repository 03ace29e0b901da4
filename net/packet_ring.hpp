#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

namespace tactus::net {

/// A ring buffer of packets, each with a time and a flag, from one writing thread to one reading
/// thread. Both sides are wait-free and allocate nothing. Each packet is contiguous: a packet that
/// does not fit before the end starts at the front.
class PacketRing {
public:
  struct Packet {
    double time_s = 0;
    bool late = false;
    std::span<const std::uint8_t> bytes{};
  };

  /// capacity: in bytes, including the packets' headers; a multiple of 8.
  explicit PacketRing(std::size_t capacity)
      : capacity_(capacity), memory_(new std::uint8_t[capacity]) {}

  /// Writer only. Returns false if the packet does not fit or would leave less than `reserve` bytes
  /// free.
  [[nodiscard]] bool push(double time_s, std::span<const std::uint8_t> bytes, bool late = false,
                          std::size_t reserve = 0) noexcept {
    const std::size_t needed = size_of(bytes.size());
    const std::size_t head = head_.load(std::memory_order_relaxed);
    const std::size_t left = capacity_ - head % capacity_; // to the end of the memory
    const std::size_t skipped = left < needed ? left : 0;
    const std::size_t used = head - tail_.load(std::memory_order_acquire);
    if (used + skipped + needed + reserve > capacity_)
      return false;
    if (skipped >= sizeof(Header))
      put(head, {0, kSkipped, false});
    const std::size_t at = head + skipped;
    put(at, {time_s, static_cast<std::uint32_t>(bytes.size()), late});
    if (!bytes.empty())
      std::memcpy(memory_.get() + at % capacity_ + sizeof(Header), bytes.data(), bytes.size());
    head_.store(at + needed, std::memory_order_release);
    return true;
  }

  /// Reader only: the oldest packet, valid until pop().
  [[nodiscard]] std::optional<Packet> front() noexcept {
    std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire))
      return {};
    const std::size_t left = capacity_ - tail % capacity_;
    if (left < sizeof(Header) || get(tail).size == kSkipped) {
      tail += left;
      tail_.store(tail, std::memory_order_release);
    }
    const Header head = get(tail);
    return Packet{
        head.time_s, head.late, {memory_.get() + tail % capacity_ + sizeof(Header), head.size}};
  }
  /// Reader only: removes the packet that front() returned.
  void pop() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    tail_.store(tail + size_of(get(tail).size), std::memory_order_release);
  }
  /// Reader only: discards all packets.
  void clear() noexcept {
    tail_.store(head_.load(std::memory_order_acquire), std::memory_order_release);
  }

private:
  struct Header {
    double time_s;
    std::uint32_t size;
    bool late;
  };
  static constexpr std::uint32_t kSkipped = ~std::uint32_t{0};

  [[nodiscard]] static std::size_t size_of(std::size_t bytes) noexcept {
    return sizeof(Header) + (bytes + 7) / 8 * 8;
  }
  void put(std::size_t at, const Header& head) noexcept {
    std::memcpy(memory_.get() + at % capacity_, &head, sizeof head);
  }
  [[nodiscard]] Header get(std::size_t at) const noexcept {
    Header head;
    std::memcpy(&head, memory_.get() + at % capacity_, sizeof head);
    return head;
  }

  std::size_t capacity_;
  std::unique_ptr<std::uint8_t[]> memory_;
  std::atomic<std::size_t> head_{0},
      tail_{0}; ///< increasing counts; positions are modulo the capacity
};

} // namespace tactus::net
