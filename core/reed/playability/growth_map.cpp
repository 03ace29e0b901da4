#include "core/reed/playability/growth_map.hpp"

#include "core/reed/playability/distance_transform.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kGrowthScale = 50; // 1/s, of a note that starts in some tens of milliseconds

} // namespace

void GrowthMap::prepare(std::size_t columns, std::size_t rows) {
  for (auto* field : {&in_progress_, &growth_, &height_})
    field->resize(columns, rows);
  grows_.assign(in_progress_.columns() * in_progress_.rows(), 0);
  squared_distances_.assign(grows_.size(), 0);
  scratch_.assign(std::max(in_progress_.columns(), in_progress_.rows()), 0);
  theory_.reset();
  ready_ = false;
}

void GrowthMap::begin(const PlayingSetup& playing, const ControlRange& range) noexcept {
  theory_.emplace(playing.valve, playing.length, playing.fingering.end);
  reed_scale_ = playing.reed_scale;
  range_ = range;
  next_ = 0;
}

double GrowthMap::progress() const noexcept {
  return grows_.empty() ? 0 : static_cast<double>(next_) / static_cast<double>(grows_.size());
}

bool GrowthMap::advance(std::size_t nodes) noexcept {
  if (!theory_)
    return ready_;
  const std::size_t end = std::min(next_ + nodes, grows_.size());
  for (; next_ < end; ++next_) {
    const std::size_t i = next_ % in_progress_.columns(), k = next_ / in_progress_.columns();
    const double pressure = range_.pressure(in_progress_.y_of(i));
    const double frequency = reed_scale_ * range_.frequency(in_progress_.z_of(k));
    const Mode mode = theory_->dominant_mode(pressure, frequency);
    const bool free = theory_->equilibrium(pressure, frequency).free;
    in_progress_.node(i, k) = mode.found ? mode.growth_rate : -1e3;
    grows_[next_] = free && mode.found && mode.growth_rate > 0;
  }
  if (next_ < grows_.size())
    return false;
  finish();
  return true;
}

void GrowthMap::finish() noexcept {
  const std::size_t columns = in_progress_.columns(), rows = in_progress_.rows();
  bool any = false;
  for (std::size_t n = 0; n < grows_.size(); ++n) {
    any = any || grows_[n];
    squared_distances_[n] = grows_[n] ? 0 : kUnreachedSquared;
  }
  distance_transform(squared_distances_, columns, rows, in_progress_.y_of(1), in_progress_.z_of(1),
                     scratch_);
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t n = k * columns + i;
      const double g = in_progress_.node(i, k);
      height_.node(i, k) =
          (grows_[n] ? g / (g + kGrowthScale) : -(any ? std::sqrt(squared_distances_[n]) : 0));
      growth_.node(i, k) = g;
    }
  height_.differentiate();
  growth_.differentiate();
  theory_.reset();
  ready_ = true;
}

} // namespace tactus::reed
