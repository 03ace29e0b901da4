#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::net {

/// Queue of the bytes to be sent to one client. Events are kept up to the capacity. Stream samples
/// are dropped while more than the stream limit is queued, since an old position is useless.
class OutQueue {
public:
  static constexpr std::size_t kCapacity = 1u << 20, kStreamLimit = 1u << 14;

  explicit OutQueue(std::size_t stream_limit = kStreamLimit) noexcept
      : stream_limit_(stream_limit) {}

  /// Returns false if the event does not fit, because the client does not read.
  [[nodiscard]] bool add_event(std::span<const std::uint8_t> bytes);
  /// Returns false if the sample was dropped.
  bool add_sample(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size() - begin_; }
  /// All queued bytes.
  [[nodiscard]] std::span<const std::uint8_t> front() const noexcept {
    return std::span(bytes_).subspan(begin_);
  }
  /// Removes bytes of front() that were sent.
  void consume(std::size_t count) noexcept;
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

private:
  void add(std::span<const std::uint8_t> bytes);

  std::size_t stream_limit_;
  std::vector<std::uint8_t> bytes_{};
  std::size_t begin_ = 0; ///< first byte that was not sent
  std::uint64_t dropped_ = 0;
};

} // namespace tactus::net
