#pragma once

#include "core/modal/body/point_map.hpp"
#include "core/modal/body/timed_queue.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

namespace tactus::modal {

/// The events that wait for their sample, on the clock of StruckBody::process().
///
/// On a large body the events are spread over time, so that a block is computed in time: strikes by
/// their work, new points by their number.
class EventSchedule {
public:
  static constexpr std::size_t kMaxScheduled = 512;
  /// The most work of strikes that begin within kBudgetSamples, in modes plus a quarter of the
  /// modes for each listener. Further strikes begin kBudgetSamples later, in order. With two
  /// listeners: on 20 000 modes one strike, on 10 000 modes two.
  static constexpr std::size_t kMaxStartingWork = 40000;
  static constexpr std::int64_t kBudgetSamples = 64;
  /// A body with more modes than this takes at most one new force point and one new point of the
  /// rub, the newest, within kBudgetSamples.
  static constexpr std::size_t kMaxUnthrottledModes = 4096;

  [[nodiscard]] bool full() const noexcept { return events_.full(); }
  /// Not to be called if the schedule is full.
  void push(const Event& event, std::int64_t sample) noexcept { events_.push(sample, event); }
  /// Removes the first event, which must exist.
  [[nodiscard]] Event pop() noexcept { return events_.pop(); }
  /// Sample of the first event.
  [[nodiscard]] std::int64_t next() const noexcept { return events_.next(); }
  /// Removes the next event that a body (null: there is none) takes at this sample.
  [[nodiscard]] std::optional<Event> take_due(std::int64_t clock, const BodyModel* body) noexcept;
  /// The last event of a type; null if there is none.
  template <class T> [[nodiscard]] const T* last() const noexcept {
    for (std::size_t i = events_.size(); i-- > 0;)
      if (const T* const event = std::get_if<T>(&events_[i]))
        return event;
    return nullptr;
  }
  void move_points(const PointMap& map) noexcept;
  /// Makes all events due.
  void expire_all() noexcept { events_.expire_all(); }

private:
  [[nodiscard]] bool has_by(std::size_t type, std::int64_t sample) const noexcept;

  TimedQueue<Event, kMaxScheduled> events_;
  std::int64_t budget_begin_ = 0;                                            ///< sample
  std::size_t starting_work_ = 0;                                            ///< work since then
  std::int64_t point_moved_ = -kBudgetSamples, rub_moved_ = -kBudgetSamples; ///< samples
};

} // namespace tactus::modal
