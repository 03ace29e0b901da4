#pragma once

#include "core/modal/bank/bank_kernel.hpp"

#include <cstddef>
#include <vector>

/// The sums over modes that a contact needs in every step, one copy for each instruction set, in
/// double and in single precision.
namespace tactus::modal {

inline constexpr std::size_t kContactLanes = 16; ///< arrays are whole multiples of it

/// One number a mode, zeros up to a whole multiple of kContactLanes, aligned for vectors.
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

/// Complex numbers of all modes, real and imaginary parts apart.
template <class T> struct SplitView {
  T* real;
  T* imaginary;
};
template <class T> struct ConstSplitView {
  const T* real;
  const T* imaginary;
};

/// A pass over all modes: what it reads and writes, forces, and what it finds out. No two arrays
/// overlap.
template <class T> struct ContactPass {
  static constexpr std::size_t kMaxPending = 2;
  static constexpr std::size_t kMaxPickups = 12;
  std::size_t count = 0; ///< a whole multiple of kContactLanes
  SplitView<T> z{};
  ConstSplitView<T> pole_minus_one{}; ///< p - 1: a step's change of the state
  ConstSplitView<T> push{};           ///< b
  const T* gain = nullptr;
  const ConstSplitView<T>* pickup = nullptr;
  std::size_t pushes = 1;         ///< forces that are still to be taken into the state, 1 or 2
  double force[kMaxPending] = {}; ///< N
  std::size_t steps = 1;          ///< to look ahead, 1 or 2
  double displacement[kMaxPending] =
      {};                           ///< sum of gain Im(z) after each of them, without new forces
  std::size_t pickups = 0;          ///< that listen after the pass's last step
  double outputs[kMaxPickups] = {}; ///< sum of Im(w z) there
};

/// Sums are always taken in the same order.
template <class T> class ContactKernel {
public:
  virtual ~ContactKernel() = default;
  /// For each force: z <- z + force b, z <- z + turn z. Then, without changing z further, what the
  /// next steps would be without forces.
  virtual void advance(ContactPass<T>& pass) const noexcept = 0;
  /// z <- z + force b.
  virtual void push(SplitView<T> z, ConstSplitView<T> b, double force,
                    std::size_t count) const noexcept = 0;
  /// Sum of a b.
  virtual double sum(const T* a, const T* b, std::size_t count) const noexcept = 0;
  /// Sum of Im(w z).
  virtual double output(ConstSplitView<T> w, ConstSplitView<T> z,
                        std::size_t count) const noexcept = 0;
};

/// One instruction set's; null where the processor does not run it.
struct ContactKernels {
  const ContactKernel<float>* single_precision = nullptr;
  const ContactKernel<double>* double_precision = nullptr;
};

/// Null where the processor does not run it.
template <class T> [[nodiscard]] const ContactKernel<T>* contact_kernel(VectorSet) noexcept;
template <> const ContactKernel<float>* contact_kernel<float>(VectorSet) noexcept;
template <> const ContactKernel<double>* contact_kernel<double>(VectorSet) noexcept;

} // namespace tactus::modal
