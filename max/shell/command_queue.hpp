#pragma once

#include "core/object.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

/// The queue of commands for an object, in order, from any thread.
namespace tactus::max {

/// One call of an object's member. Words point to Max's symbols, which live as long as Max.
struct QueuedCommand {
  enum class Kind {
    kParameter,
    kMessage,
    kScalar,
    kList,
    kTick,
    kPosted,
    kCreated,
    kDumpFirst,
    kDump,
    kGet ///< `get` of a name that is not a parameter
  };
  static constexpr std::size_t kFewAtoms = 8;

  Kind kind = Kind::kMessage;
  bool realtime = false; ///< runs without allocating, so the audio thread may run it
  std::size_t index = 0; ///< index of a parameter, message, inlet or timer
  double value = 0;      ///< value of a parameter or scalar
  std::size_t count = 0; ///< number of atoms in `few`
  std::array<Atom, kFewAtoms> few{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  std::unique_ptr<std::vector<Atom>>
      many{}; ///< used instead of `few`; never for a realtime command

  void set_atoms(std::vector<Atom> atoms) {
    if (atoms.size() > kFewAtoms) {
      many = std::make_unique<std::vector<Atom>>(std::move(atoms));
      realtime = false;
      return;
    }
    count = atoms.size();
    for (std::size_t i = 0; i < count; ++i)
      few[i] = atoms[i];
  }
  [[nodiscard]] std::span<const Atom> atoms() const noexcept {
    return many ? std::span<const Atom>(*many) : std::span<const Atom>(few).first(count);
  }
};

/// Bounded queue: any thread may push, and the holder of the object's token takes commands out. It
/// follows D. Vyukov's bounded queue: each cell stores the turn in which it may be written or read.
class CommandQueue {
public:
  CommandQueue() : cells_(kCapacity) {
    for (std::size_t i = 0; i < kCapacity; ++i)
      cells_[i].turn.store(i, std::memory_order_relaxed);
  }

  /// Moves the command into the queue. False if the queue is full; the command is then unchanged.
  [[nodiscard]] bool push(QueuedCommand& command) noexcept {
    std::size_t position = end_.load(std::memory_order_relaxed);
    for (;;) {
      Cell& cell = cells_[position % kCapacity];
      const auto ahead =
          static_cast<std::ptrdiff_t>(cell.turn.load(std::memory_order_acquire) - position);
      if (ahead < 0)
        return false;
      if (ahead > 0)
        position = end_.load(std::memory_order_relaxed);
      else if (end_.compare_exchange_weak(position, position + 1, std::memory_order_relaxed)) {
        cell.command = std::move(command);
        cell.turn.store(position + 1); // sequentially consistent with the token
        return true;
      }
    }
  }
  /// The oldest command, or null. Only the holder of the token may call front() and pop().
  [[nodiscard]] QueuedCommand* front() noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    Cell& cell = cells_[begin % kCapacity];
    return cell.turn.load() == begin + 1 ? &cell.command : nullptr;
  }
  void pop() noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    cells_[begin % kCapacity].turn.store(begin + kCapacity, std::memory_order_release);
    begin_.store(begin + 1);
  }
  /// True if no command is ready to be taken; callable from any thread.
  [[nodiscard]] bool empty() const noexcept {
    const std::size_t begin = begin_.load();
    return cells_[begin % kCapacity].turn.load() != begin + 1;
  }

private:
  static constexpr std::size_t kCapacity = 256; // a power of two, so that counters may wrap
  struct Cell {
    std::atomic<std::size_t> turn{0};
    QueuedCommand command;
  };
  std::vector<Cell> cells_;
  std::atomic<std::size_t> end_{0}, begin_{0};
};

} // namespace tactus::max
