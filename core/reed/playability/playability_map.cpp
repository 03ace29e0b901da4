#include "core/reed/playability/playability_map.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {

void PlayabilityMap::begin(const PlayabilityMapSettings& settings, std::size_t columns,
                           std::size_t rows) {
  settings_ = settings;
  field_.resize(columns, rows);
  ensemble_->set(settings.parameters);
  ensemble_->set(settings.estimator);
  ensemble_->prepare(settings.sample_rate);
  ensemble_->process({}, {}, settings.bore_frequency, 1, {}); // one sample sets the length
  length_ = ensemble_->length();
}

std::size_t PlayabilityMap::advance(std::size_t first) noexcept {
  const std::size_t end = std::min(first + ReedEnsemble::kLanes, size());
  ReedEnsemble::PerLane pressure{}, frequency{}, sum{};
  for (std::size_t lane = 0; lane < ReedEnsemble::kLanes; ++lane) {
    const std::size_t node = std::min(first + lane, end - 1);
    pressure[lane] = settings_.range.pressure(field_.y_of(node % field_.columns()));
    frequency[lane] = settings_.range.frequency(field_.z_of(node / field_.columns()));
  }
  constexpr double kRamp = 20e-3;
  const auto frames = [this](double seconds) {
    return static_cast<std::size_t>(std::lround(seconds * settings_.sample_rate));
  };
  const std::size_t settle = frames(settings_.settle_s);
  const std::size_t total =
      std::max(settle, frames(kRamp)) + std::max<std::size_t>(frames(settings_.listen_s), 1);
  const std::size_t ramp = std::max<std::size_t>(frames(kRamp), 1);

  ensemble_->reset();
  std::size_t averaged_blocks = 0;
  ReedEnsemble::Pressure mouth;
  for (std::size_t lane = 0; lane < pressure.size(); ++lane)
    mouth.slope[lane] = pressure[lane] / static_cast<double>(ramp);
  for (std::size_t sample = 0; sample < total;) {
    const std::size_t next_break = sample < ramp ? ramp : total;
    const std::size_t count = std::min(ReedEnsemble::kMaxFrames, next_break - sample);
    sample += count;
    ensemble_->process(mouth, frequency, settings_.bore_frequency, count, {});
    if (sample == ramp)
      mouth.slope.fill(0);
    mouth.start = sample < ramp ? mouth.start : pressure;
    mouth.first = sample < ramp ? sample : 0;
    if (sample <= settle)
      continue;
    ++averaged_blocks;
    for (std::size_t lane = 0; lane < sum.size(); ++lane)
      sum[lane] += ensemble_->playability(lane);
  }
  for (std::size_t node = first; node < end; ++node)
    field_.node(node % field_.columns(), node / field_.columns()) =
        sum[node - first] / static_cast<double>(averaged_blocks);
  return end;
}

} // namespace tactus::reed
