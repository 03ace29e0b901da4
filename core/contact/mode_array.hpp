#pragma once

#include <cstddef>
#include <vector>

namespace tactus::contact {

inline constexpr std::size_t kModeLanes = 8; ///< arrays are whole multiples of it

[[nodiscard]] constexpr std::size_t whole_lanes(std::size_t count) noexcept {
  return (count + kModeLanes - 1) / kModeLanes * kModeLanes;
}

/// One number a mode, zeros up to a whole multiple of kModeLanes, aligned for vectors.
class ModeArray {
public:
  explicit ModeArray(std::size_t count = 0) : blocks_((count + kModeLanes - 1) / kModeLanes) {}
  [[nodiscard]] double* data() noexcept { return reinterpret_cast<double*>(blocks_.data()); }
  [[nodiscard]] const double* data() const noexcept {
    return reinterpret_cast<const double*>(blocks_.data());
  }
  [[nodiscard]] double& operator[](std::size_t mode) noexcept { return data()[mode]; }
  [[nodiscard]] double operator[](std::size_t mode) const noexcept { return data()[mode]; }
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
