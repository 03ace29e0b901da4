#include "core/modal/radiation/combined_arrivals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tactus::modal {

CombinedArrivals::CombinedArrivals(std::vector<Part> parts, double sample_rate,
                                   std::size_t max_extra_delay)
    : parts_(std::move(parts)) {
  delay_s = std::numeric_limits<double>::infinity();
  for (const Part& part : parts_)
    if (!part.arrivals->silent)
      delay_s = std::min(delay_s, part.arrivals->delay_s);
  silent = !std::isfinite(delay_s);
  if (silent)
    delay_s = 0;
  std::size_t modes = 0;
  for (Part& part : parts_) {
    modes += part.mode.size();
    if (!part.arrivals->silent)
      part.extra_delay = std::min(
          static_cast<std::size_t>(std::lround((part.arrivals->delay_s - delay_s) * sample_rate)),
          max_extra_delay);
  }
  source_.resize(modes);
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::size_t k = 0; k < parts_[p].mode.size(); ++k)
      source_[parts_[p].mode[k]] = {p, k};
}

std::size_t CombinedArrivals::samples() const noexcept {
  std::size_t samples = 0;
  for (const Part& part : parts_)
    samples = std::max(samples, part.extra_delay + part.arrivals->samples());
  return samples;
}

void CombinedArrivals::find(std::size_t motion, std::span<double> pressure) const {
  const Source source = motion < modes()
                            ? source_[motion]
                            : Source{0, parts_[0].arrivals->modes() + motion - modes()};
  const Part& part = parts_[source.part];
  std::fill(pressure.begin(), pressure.end(), 0);
  const std::size_t first = part.extra_delay * BandLimit::kNodes,
                    count = part.arrivals->samples() * BandLimit::kNodes;
  part.arrivals->find(source.motion, pressure.subspan(first, count));
}

} // namespace tactus::modal
