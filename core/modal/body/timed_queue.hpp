#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace tactus::modal {

/// A bounded queue of events ordered by time; events of equal time keep their order of arrival.
/// Does not allocate.
template <class Event, std::size_t Capacity> class TimedQueue {
public:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] bool full() const noexcept { return count_ == Capacity; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  /// Time of the first event; kNever if there is none.
  [[nodiscard]] std::int64_t next() const noexcept { return empty() ? kNever : at(0).time; }
  /// Inserts an event; the queue must not be full.
  void push(std::int64_t time, const Event& event) noexcept {
    std::size_t i = count_++;
    for (; i > 0 && at(i - 1).time > time; --i)
      at(i) = at(i - 1);
    at(i) = {time, event};
  }
  /// Removes the first event; the queue must not be empty.
  Event pop() noexcept {
    Event event = std::move(at(0).event);
    begin_ = (begin_ + 1) % Capacity;
    --count_;
    return event;
  }
  [[nodiscard]] Event& operator[](std::size_t i) noexcept { return at(i).event; }
  [[nodiscard]] const Event& operator[](std::size_t i) const noexcept { return at(i).event; }
  [[nodiscard]] std::int64_t time(std::size_t i) const noexcept { return at(i).time; }
  /// Makes all events due.
  void expire_all() noexcept {
    for (std::size_t i = 0; i < count_; ++i)
      at(i).time = std::numeric_limits<std::int64_t>::min();
  }

private:
  struct Timed {
    std::int64_t time = 0;
    Event event{};
  };
  [[nodiscard]] Timed& at(std::size_t i) noexcept { return timed_[(begin_ + i) % Capacity]; }
  [[nodiscard]] const Timed& at(std::size_t i) const noexcept {
    return timed_[(begin_ + i) % Capacity];
  }
  std::array<Timed, Capacity> timed_{};
  std::size_t begin_ = 0, count_ = 0;
};

} // namespace tactus::modal
