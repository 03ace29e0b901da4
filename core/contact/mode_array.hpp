#pragma once

#include <cstddef>
#include <vector>

namespace tactus::contact {

inline constexpr std::size_t kModeLanes = 8; ///< array lengths are multiples of this

/// `count` rounded up to a multiple of kModeLanes.
[[nodiscard]] constexpr std::size_t whole_lanes(std::size_t count) noexcept {
  return (count + kModeLanes - 1) / kModeLanes * kModeLanes;
}

/// An array of one double per mode, aligned to 64 bytes for vector loads and padded with zeros to a
/// multiple of kModeLanes.
class ModeArray {
public:
  explicit ModeArray(std::size_t count = 0) : blocks_((count + kModeLanes - 1) / kModeLanes) {}
  [[nodiscard]] double* data() noexcept { return reinterpret_cast<double*>(blocks_.data()); }
  [[nodiscard]] const double* data() const noexcept {
    return reinterpret_cast<const double*>(blocks_.data());
  }
  [[nodiscard]] double& operator[](std::size_t mode) noexcept { return data()[mode]; }
  [[nodiscard]] double operator[](std::size_t mode) const noexcept { return data()[mode]; }
  /// Length with the padding.
  [[nodiscard]] std::size_t padded() const noexcept { return blocks_.size() * kModeLanes; }
  void clear() noexcept {
    for (Block& block : blocks_)
      block = {};
  }

private:
  struct alignas(64) Block {
    double v[kModeLanes] = {};
  };
  std::vector<Block> blocks_;
};

} // namespace tactus::contact
