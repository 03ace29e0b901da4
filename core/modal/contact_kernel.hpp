#pragma once

#include "core/modal/bank_kernel.hpp"

#include <cstddef>
#include <vector>

/// The sums over modes that a contact needs in every step, one copy for each instruction set.
namespace tactus::modal {

inline constexpr std::size_t kContactLanes = 16; ///< arrays are whole multiples of it

/// One number a mode, zeros up to a whole multiple of kContactLanes, aligned for vectors.
class LaneArray {
public:
  explicit LaneArray(std::size_t count = 0)
      : blocks_((count + kContactLanes - 1) / kContactLanes) {}
  [[nodiscard]] double* data() noexcept { return reinterpret_cast<double*>(blocks_.data()); }
  [[nodiscard]] const double* data() const noexcept {
    return reinterpret_cast<const double*>(blocks_.data());
  }
  [[nodiscard]] double& operator[](std::size_t mode) noexcept { return data()[mode]; }
  [[nodiscard]] double operator[](std::size_t mode) const noexcept { return data()[mode]; }
  [[nodiscard]] std::size_t padded() const noexcept { return blocks_.size() * kContactLanes; }

private:
  struct alignas(64) Block {
    double v[kContactLanes] = {};
  };
  std::vector<Block> blocks_;
};

/// Complex numbers of all modes, real and imaginary parts apart.
struct SplitView {
  double* real;
  double* imaginary;
};
struct ConstSplitView {
  const double* real;
  const double* imaginary;
};

/// No two arrays of a call overlap. Sums are always taken in the same order.
class ContactKernel {
public:
  virtual ~ContactKernel() = default;
  /// z <- p z; returns the sum of gain Im(z) afterwards.
  virtual double turn(SplitView z, ConstSplitView p, const double* gain,
                      std::size_t count) const noexcept = 0;
  /// z <- z + force b.
  virtual void push(SplitView z, ConstSplitView b, double force,
                    std::size_t count) const noexcept = 0;
  /// Sum of a b.
  virtual double sum(const double* a, const double* b, std::size_t count) const noexcept = 0;
  /// Sum of Im(w z).
  virtual double hear(ConstSplitView w, ConstSplitView z, std::size_t count) const noexcept = 0;
};

/// The widest that this processor runs.
[[nodiscard]] const ContactKernel& contact_kernel() noexcept;
/// Null where the processor does not run it.
[[nodiscard]] const ContactKernel* contact_kernel(VectorSet) noexcept;

} // namespace tactus::modal
