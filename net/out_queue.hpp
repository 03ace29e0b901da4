#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::net {

/// Queue of the bytes to be sent to one client. Events are kept up to the capacity; samples of a
/// stream are left out while more than the stream limit waits, since an old position is worth
/// nothing.
class OutQueue {
public:
  static constexpr std::size_t kCapacity = 1u << 20, kStreamLimit = 1u << 14;

  explicit OutQueue(std::size_t stream_limit = kStreamLimit) noexcept
      : stream_limit_(stream_limit) {}

  /// False when it does not fit: the client does not read.
  [[nodiscard]] bool add_event(std::span<const std::uint8_t> bytes);
  /// False when the sample was left out.
  bool add_sample(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size() - begin_; }
  /// All that waits.
  [[nodiscard]] std::span<const std::uint8_t> front() const noexcept {
    return std::span(bytes_).subspan(begin_);
  }
  /// So many bytes of front() were sent.
  void consume(std::size_t count) noexcept;
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

private:
  void add(std::span<const std::uint8_t> bytes);

  std::size_t stream_limit_;
  std::vector<std::uint8_t> bytes_{};
  std::size_t begin_ = 0; ///< of what was not sent yet
  std::uint64_t dropped_ = 0;
};

} // namespace tactus::net
