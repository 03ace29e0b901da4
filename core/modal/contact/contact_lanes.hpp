#pragma once

#include "core/dsp/vector.hpp"
#include "core/modal/contact/contact_kernel.hpp"

/// The loops of ContactKernel, written once for any instruction set and precision. They are
/// templates on the set, so that the linker cannot use code for a newer processor in place of code
/// for an older one.
namespace tactus::modal {

template <class Set, class T> class ContactLanes final : public ContactKernel<T> {
  using L = simd::Vectors<Set, T, kContactLanes>;
  using V = typename L::V;
  static constexpr std::size_t kWidth = L::kWidth;
  static constexpr std::size_t kRegisters = L::kRegisters; // in one iteration

  struct Pair {
    V real, imaginary;
  };
  [[gnu::always_inline]] static V fma(V a, V b, V c) noexcept { return L::multiply_add(a, b, c); }
  [[gnu::always_inline]] static V load(const T* from) noexcept { return L::load(from); }
  [[gnu::always_inline]] static Pair load(ConstSplitView<T> from, std::size_t i) noexcept {
    return {load(from.real + i), load(from.imaginary + i)};
  }
  [[gnu::always_inline]] static void store(T* to, V value) noexcept { L::store(to, value); }
  [[gnu::always_inline]] static V all(double x) noexcept { return L::all(x); }
  /// z + force b
  [[gnu::always_inline]] static Pair with_force(const Pair& z, const Pair& b, V force) noexcept {
    return {fma(b.real, force, z.real), fma(b.imaginary, force, z.imaginary)};
  }
  /// z + t z
  [[gnu::always_inline]] static Pair advanced(const Pair& z, const Pair& t) noexcept {
    return {fma(t.real, z.real, fma(-t.imaginary, z.imaginary, z.real)),
            fma(t.real, z.imaginary, fma(t.imaginary, z.real, z.imaginary))};
  }
  /// One sum in several registers, so that additions do not wait for each other.
  struct Sum {
    V part[kRegisters];
    [[gnu::always_inline]] Sum() noexcept {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r)
        part[r] = V{};
    }
    [[gnu::always_inline]] double total() const noexcept {
      return static_cast<double>(L::across(part));
    }
  };

  /// The number of pick-ups, a constant if there are few, so that their sums stay in registers.
  [[gnu::always_inline]] static constexpr std::size_t pickup_bound(std::size_t compiled,
                                                                   std::size_t pickups) noexcept {
    return compiled < ContactPass<T>::kMaxPickups ? compiled : pickups;
  }
  template <std::size_t Pending, std::size_t Steps, std::size_t Pickups>
  static void advance_by(ContactPass<T>& pass) noexcept {
    const SplitView<T> z = pass.z;
    const ConstSplitView<T> pole_minus_one = pass.pole_minus_one, input_gain = pass.input_gain;
    const T* const gain = pass.gain;
    ConstSplitView<T> pickup[Pickups + 1] = {};
    for (std::size_t e = 0; e < Pickups; ++e)
      pickup[e] = pass.pickup[e < pass.pickups ? e : 0];
    Sum first, second, outputs[Pickups + 1];
    const std::size_t listening = pass.pickups < Pickups ? pass.pickups : Pickups;
    const V first_force = all(pass.force[0]), last_force = all(pass.force[Pending - 1]);
    for (std::size_t k = 0; k < pass.count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const std::size_t i = k + r * kWidth;
        Pair state{load(z.real + i), load(z.imaginary + i)};
        const Pair t = load(pole_minus_one, i), b = load(input_gain, i);
        state = advanced(with_force(state, b, first_force), t);
        if constexpr (Pending == 2)
          state = advanced(with_force(state, b, last_force), t);
        store(z.real + i, state.real);
        store(z.imaginary + i, state.imaginary);
        const V g = load(gain + i);
        first.part[r] = fma(g, state.imaginary, first.part[r]);
        if constexpr (Steps == 2) {
          state = advanced(state, t);
          second.part[r] = fma(g, state.imaginary, second.part[r]);
        }
        for (std::size_t e = 0; e < pickup_bound(Pickups, listening); ++e) {
          const V real = load(pickup[e].real + i), imaginary = load(pickup[e].imaginary + i);
          outputs[e].part[r] =
              fma(real, state.imaginary, fma(imaginary, state.real, outputs[e].part[r]));
        }
      }
    }
    pass.displacement[0] = first.total();
    pass.displacement[1] = second.total();
    for (std::size_t e = 0; e < pickup_bound(Pickups, listening); ++e)
      pass.outputs[e] = outputs[e].total();
  }
  template <std::size_t Pending, std::size_t Steps>
  static void advance_with_pickups(ContactPass<T>& pass) noexcept {
    switch (pass.pickups) {
    case 0:
      return advance_by<Pending, Steps, 0>(pass);
    case 1:
      return advance_by<Pending, Steps, 1>(pass);
    case 2:
      return advance_by<Pending, Steps, 2>(pass);
    default:
      return advance_by<Pending, Steps, ContactPass<T>::kMaxPickups>(pass);
    }
  }

public:
  void advance(ContactPass<T>& pass) const noexcept override {
    if (pass.steps == 1)
      return advance_with_pickups<1, 1>(pass);
    if (pass.pending == 1)
      return advance_with_pickups<1, 2>(pass);
    return advance_with_pickups<2, 2>(pass);
  }

  void add_force(SplitView<T> z, ConstSplitView<T> b, double force,
                 std::size_t count) const noexcept override {
    const V f = all(force);
    for (std::size_t i = 0; i < count; i += kWidth) {
      store(z.real + i, fma(load(b.real + i), f, load(z.real + i)));
      store(z.imaginary + i, fma(load(b.imaginary + i), f, load(z.imaginary + i)));
    }
  }

  double sum(const T* a, const T* b, std::size_t count) const noexcept override {
    Sum sums;
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r)
        sums.part[r] = fma(load(a + k + r * kWidth), load(b + k + r * kWidth), sums.part[r]);
    }
    return sums.total();
  }

  double output(ConstSplitView<T> w, ConstSplitView<T> z,
                std::size_t count) const noexcept override {
    Sum sums;
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const Pair a = load(w, k + r * kWidth), b = load(z, k + r * kWidth);
        sums.part[r] = fma(a.real, b.imaginary, fma(a.imaginary, b.real, sums.part[r]));
      }
    }
    return sums.total();
  }
};

} // namespace tactus::modal
