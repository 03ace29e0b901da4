#pragma once

#include "core/modal/bank/bank_kernel.hpp"

#include <cstddef>
#include <vector>

/// The interface to the loops over modes that a contact runs in every step. Each instruction set
/// has its own copy, in double and in single precision.
namespace tactus::modal {

inline constexpr std::size_t kContactLanes = 16; ///< the length of arrays is a multiple of this

/// One number for each mode, padded with zeros to a multiple of kContactLanes, aligned for vectors.
template <class T> class LaneArray {
public:
  explicit LaneArray(std::size_t count = 0)
      : blocks_((count + kContactLanes - 1) / kContactLanes) {}
  [[nodiscard]] T* data() noexcept { return reinterpret_cast<T*>(blocks_.data()); }
  [[nodiscard]] const T* data() const noexcept {
    return reinterpret_cast<const T*>(blocks_.data());
  }
  [[nodiscard]] T& operator[](std::size_t mode) noexcept { return data()[mode]; }
  [[nodiscard]] T operator[](std::size_t mode) const noexcept { return data()[mode]; }
  [[nodiscard]] std::size_t padded() const noexcept { return blocks_.size() * kContactLanes; }

private:
  struct alignas(64) Block {
    T v[kContactLanes] = {};
  };
  std::vector<Block> blocks_;
};

/// A complex number for each mode, real and imaginary parts in separate arrays.
template <class T> struct SplitView {
  T* real;
  T* imaginary;
};
template <class T> struct ConstSplitView {
  const T* real;
  const T* imaginary;
};

/// The arguments and results of one pass over all modes. z = q' + alpha q + j omega_d q is a mode's
/// state, p = exp(s h) its pole for a step h. No two arrays overlap.
template <class T> struct ContactPass {
  static constexpr std::size_t kMaxPending = 2;
  static constexpr std::size_t kMaxPickups = 12;
  std::size_t count = 0; ///< a multiple of kContactLanes
  SplitView<T> z{};
  ConstSplitView<T> pole_minus_one{}; ///< p - 1: a step's change of the state
  ConstSplitView<T> input_gain{};     ///< b (p - 1)/s, of the contact that the forces belong to
  const T* gain = nullptr;            ///< b/omega_d of that contact
  const ConstSplitView<T>* pickup = nullptr;
  std::size_t pending = 1;        ///< forces that the state does not contain yet, 1 or 2
  double force[kMaxPending] = {}; ///< N
  std::size_t steps = 1;          ///< number of steps to look ahead, 1 or 2
  double displacement[kMaxPending] =
      {};                           ///< sum of gain Im(z) after each step, without new forces; m
  std::size_t pickups = 0;          ///< outputs to compute after the last step
  double outputs[kMaxPickups] = {}; ///< sum of Im(w z) after the last step
};

/// All sums run in the same order, whatever the arguments.
template <class T> class ContactKernel {
public:
  virtual ~ContactKernel() = default;
  /// For each pending force: z <- z + force input_gain, then z <- p z. Fills displacement and
  /// outputs for the steps ahead; a second step ahead does not change z.
  virtual void advance(ContactPass<T>& pass) const noexcept = 0;
  /// z <- z + force b.
  virtual void add_force(SplitView<T> z, ConstSplitView<T> b, double force,
                         std::size_t count) const noexcept = 0;
  /// The sum of a b.
  virtual double sum(const T* a, const T* b, std::size_t count) const noexcept = 0;
  /// The sum of Im(w z).
  virtual double output(ConstSplitView<T> w, ConstSplitView<T> z,
                        std::size_t count) const noexcept = 0;
};

struct ContactKernels {
  const ContactKernel<float>* single_precision = nullptr;
  const ContactKernel<double>* double_precision = nullptr;

  template <class T> [[nodiscard]] const ContactKernel<T>* of() const noexcept {
    if constexpr (sizeof(T) == sizeof(float))
      return single_precision;
    else
      return double_precision;
  }
};
/// The implementations for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] ContactKernels contact_kernels(VectorSet widest) noexcept;
[[nodiscard]] ContactKernels contact_kernels(simd::Baseline) noexcept;
[[nodiscard]] ContactKernels contact_kernels(simd::Avx2) noexcept;
[[nodiscard]] ContactKernels contact_kernels(simd::Avx512) noexcept;

} // namespace tactus::modal
