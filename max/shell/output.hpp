#pragma once

#include "core/object.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Outputs that an object sends while its token is held. They are stored until the token is free,
/// because the receivers at the outlets may send to the object again.
namespace tactus::max {

/// One output: atoms to an outlet, or one word to Max's console.
struct Output {
  enum class Kind : std::uint32_t { kOutlet, kError, kLog };
  Kind kind;
  std::uint32_t outlet;
  std::vector<Atom> atoms; ///< words are views into the stored bytes
};

/// Size of a stored output, bytes, a multiple of 8.
[[nodiscard]] std::size_t stored_size(std::span<const Atom> atoms) noexcept;
/// Stores an output in that many bytes; allocates nothing.
void store(std::byte* bytes, Output::Kind kind, std::size_t outlet,
           std::span<const Atom> atoms) noexcept;
/// Reads one output back; returns its size in bytes.
std::size_t load(const std::byte* bytes, Output& output);

/// Outputs of a message thread, without a limit.
class Outbox {
public:
  void add(Output::Kind kind, std::size_t outlet, std::span<const Atom> atoms);
  template <class Receive> void deliver(Receive&& receive) const {
    Output output{};
    for (std::size_t at = 0; at < bytes_.size();) {
      at += load(bytes_.data() + at, output);
      receive(output);
    }
  }

private:
  std::vector<std::byte> bytes_;
};

/// Outputs of the audio thread: the holder of the token writes, one other thread reads.
class OutputRing {
public:
  OutputRing() : bytes_(kCapacity) {}
  /// Allocates nothing; returns false if there is no room.
  [[nodiscard]] bool add(Output::Kind kind, std::size_t outlet,
                         std::span<const Atom> atoms) noexcept;
  [[nodiscard]] bool empty() const noexcept {
    return read_.load(std::memory_order_relaxed) == written_.load(std::memory_order_acquire);
  }
  /// Passes the oldest output to `receive`; false if there is none.
  template <class Receive> bool deliver_one(Receive&& receive) {
    const std::size_t read = skip_to_record();
    if (read == written_.load(std::memory_order_acquire))
      return false;
    Output output{};
    const std::size_t size = load(bytes_.data() + read % kCapacity, output);
    receive(output);
    read_.store(read + size, std::memory_order_release);
    return true;
  }

private:
  static constexpr std::size_t kCapacity = 1U << 16; // a power of two
  [[nodiscard]] std::size_t skip_to_record() noexcept;
  std::vector<std::byte> bytes_;
  std::atomic<std::size_t> written_{0}, read_{0}; // bytes since the beginning
};

} // namespace tactus::max
