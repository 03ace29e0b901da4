#pragma once

#include "core/modal/radiation/arrivals.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// The Arrivals of several bodies in one: the sounds add, no body shadows another. The motions are
/// the modes of all bodies in one list, then the rigid motions of the first.
class CombinedArrivals final : public Arrivals {
public:
  struct Part {
    std::unique_ptr<Arrivals> arrivals;
    std::span<const std::size_t>
        mode; ///< index of each of its modes in the common list; must outlive this object
    std::size_t extra_delay = 0; ///< samples after the first part's delay
  };
  /// The parts' delays must differ by whole samples (TravelTime).
  CombinedArrivals(std::vector<Part> parts, double sample_rate, std::size_t max_extra_delay);
  [[nodiscard]] std::size_t modes() const noexcept override { return source_.size(); }
  [[nodiscard]] std::size_t samples() const noexcept override;
  void find(std::size_t motion, std::span<double> pressure) const override;

private:
  struct Source {
    std::size_t part = 0, motion = 0;
  };
  std::vector<Part> parts_;
  std::vector<Source> source_; ///< sources of each mode in the list
};

} // namespace tactus::modal
