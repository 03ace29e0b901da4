#pragma once

#include "core/modal/bank_kernel.hpp"

#include <cstddef>

/// The sums over modes that a contact needs in every step, one copy for each instruction set.
namespace tactus::modal {

inline constexpr std::size_t kContactLanes = 8; ///< arrays are whole multiples of it, zeros behind

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
