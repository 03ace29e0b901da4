#include "core/reed/playability/growth_map.hpp"

#include "core/reed/playability/distance_transform.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kGrowthScale = 50; // 1/s: a note that speaks in some tens of milliseconds

} // namespace

void GrowthMap::prepare(std::size_t columns, std::size_t rows) {
  for (auto* field : {&working_, &growth_, &height_})
    field->resize(columns, rows);
  sounds_.assign(working_.columns() * working_.rows(), 0);
  squares_.assign(sounds_.size(), 0);
  line_.assign(std::max(working_.columns(), working_.rows()), 0);
  theory_.reset();
  ready_ = false;
}

void GrowthMap::begin(const Playing& playing, const ControlRange& range) noexcept {
  theory_.emplace(playing.valve, playing.length, playing.fingering.end);
  reed_scale_ = playing.reed_scale;
  range_ = range;
  next_ = 0;
}

double GrowthMap::progress() const noexcept {
  return sounds_.empty() ? 0 : static_cast<double>(next_) / static_cast<double>(sounds_.size());
}

bool GrowthMap::advance(std::size_t nodes) noexcept {
  if (!theory_)
    return ready_;
  const std::size_t end = std::min(next_ + nodes, sounds_.size());
  for (; next_ < end; ++next_) {
    const std::size_t i = next_ % working_.columns(), k = next_ / working_.columns();
    const double pressure = range_.pressure(working_.y_of(i));
    const double frequency = reed_scale_ * range_.frequency(working_.z_of(k));
    const Mode mode = theory_->dominant_mode(pressure, frequency);
    const bool free = theory_->equilibrium(pressure, frequency).free;
    working_.node(i, k) = mode.found ? mode.growth_rate : -1e3;
    sounds_[next_] = free && mode.found && mode.growth_rate > 0;
  }
  if (next_ < sounds_.size())
    return false;
  finish();
  return true;
}

void GrowthMap::finish() noexcept {
  const std::size_t columns = working_.columns(), rows = working_.rows();
  bool any = false;
  for (std::size_t n = 0; n < sounds_.size(); ++n) {
    any = any || sounds_[n];
    squares_[n] = sounds_[n] ? 0 : kFarSquared;
  }
  spread_squares(squares_, columns, rows, working_.y_of(1), working_.z_of(1), line_);
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t n = k * columns + i;
      const double g = working_.node(i, k);
      height_.node(i, k) =
          (sounds_[n] ? g / (g + kGrowthScale) : -(any ? std::sqrt(squares_[n]) : 0));
      growth_.node(i, k) = g;
    }
  height_.differentiate();
  growth_.differentiate();
  theory_.reset();
  ready_ = true;
}

} // namespace tactus::reed
