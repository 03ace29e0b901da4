#include "core/modal/body/event_schedule.hpp"

namespace tactus::modal {

std::optional<Event> EventSchedule::take_due(std::int64_t clock, const BodyModel* body) noexcept {
  if (clock - budget_begin_ >= kBudgetSamples || clock < budget_begin_) {
    budget_begin_ = clock;
    starting_work_ = 0;
  }
  const std::size_t modes = body ? body->mode.size() : 0;
  const std::size_t work = modes + (body ? modes * body->settings.listeners / 4 : 0);
  while (events_.next() <= clock) {
    const Event event = events_.pop();
    if (std::holds_alternative<Strike>(event)) {
      if (starting_work_ > 0 && starting_work_ + work > kMaxStartingWork) {
        events_.push(budget_begin_ + kBudgetSamples, event);
        continue;
      }
      starting_work_ += work;
    } else if (!std::holds_alternative<Reset>(event) && modes > kMaxUnthrottledModes) {
      std::int64_t& moved = std::holds_alternative<ForcePoint>(event) ? point_moved_ : rub_moved_;
      const std::int64_t free_at = moved + kBudgetSamples;
      if (clock < free_at && clock >= moved) {
        if (!has_by(event.index(), free_at)) // else a newer event replaces this one
          events_.push(free_at, event);
        continue;
      }
      moved = clock;
    }
    return event;
  }
  return {};
}

bool EventSchedule::has_by(std::size_t type, std::int64_t sample) const noexcept {
  for (std::size_t i = 0; i < events_.size() && events_.time(i) <= sample; ++i)
    if (events_[i].index() == type)
      return true;
  return false;
}

void EventSchedule::move_points(const PointMap& map) noexcept {
  for (std::size_t i = 0; i < events_.size(); ++i)
    std::visit([&](auto& event) { map.move(event); }, events_[i]);
}

} // namespace tactus::modal
