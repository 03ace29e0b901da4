#pragma once

#include "core/contact/contact_system.hpp"
#include "core/contact/pressed_contacts.hpp"
#include "core/dsp/simd.hpp"

/// The steps of PressedBlocks, written once for any instruction set: the operations of Exciter and
/// Impact in the same order, so that a contact has the same bits here and there.
namespace tactus::contact {

template <class Set> class PressedLanes {
  static constexpr int kLanes = PressedBlock::kLanes;
  using V = simd::Lanes<double, kLanes, Set>;
  using Row = PressedBlock::Row;

  [[gnu::always_inline]] static V load(const Row& row) noexcept {
    V v;
    for (int i = 0; i < v.registers; ++i)
      v.v[i] = *reinterpret_cast<const Vector*>(row.data() + i * V::R::width);
    return v;
  }
  [[gnu::always_inline]] static void store(Row& row, const V& v) noexcept {
    for (int i = 0; i < v.registers; ++i)
      *reinterpret_cast<Vector*>(row.data() + i * V::R::width) = v.v[i];
  }
  using Vector [[gnu::vector_size(Set::register_bytes), gnu::may_alias]] = double;

  [[gnu::always_inline]] static V within_reach(const V& x) noexcept {
    return simd::select(x < V(Impact::kLeastDepth), V(Impact::kLeastDepth),
                        simd::select(x > V(Impact::kMostDepth), V(Impact::kMostDepth), x));
  }
  /// FollowedPower of the lanes that are asked for; of others any number.
  [[gnu::always_inline]] static V power(PressedBlock& b, const V& x,
                                        const typename V::MaskType& asked) noexcept {
    V d = x * load(b.power_over) - V(1), value = load(b.power_value);
    const auto far = asked & !(simd::absolute(d) < load(b.power_limit));
    if (simd::any(far)) {
      for (int l = 0; l < kLanes; ++l)
        if (simd::lane(far, l)) {
          const auto i = static_cast<std::size_t>(l);
          const double at = simd::lane(x, l), taken = Power(b.exponent[i])(at);
          b.power_value[i] = taken;
          b.power_over[i] = 1 / at;
          simd::set_lane(value, l, taken);
          simd::set_lane(d, l, 0.0);
        }
    }
    const auto term = [&](std::size_t k) { return load(b.power_term[k]); };
    const V d2 = d * d;
    return value * (((V(1) + term(0) * d) + d2 * (term(1) + term(2) * d)) +
                    (d2 * d2) * ((term(3) + term(4) * d) + term(5) * d2));
  }
  struct State {
    V real, imaginary;
  };
  [[gnu::always_inline]] static State gather(const PressedBlock& b, const double* real,
                                             const double* imaginary) noexcept {
    alignas(64) Row re{}, im{};
    for (std::size_t l = 0; l < b.used; ++l) {
      re[l] = real[b.mode[l]];
      im[l] = imaginary[b.mode[l]];
    }
    return {load(re), load(im)};
  }

public:
  /// BodyKernel::look_at().
  [[gnu::always_inline]] static void look_at(PressedBlock& b, const double* real,
                                             const double* imaginary, bool look,
                                             double h) noexcept {
    V x = load(b.depth), rate = load(b.approach);
    if (look) {
      const State z = gather(b, real, imaginary);
      const V shape = load(b.shape);
      x = load(b.place) - shape * z.imaginary * load(b.displacement);
      rate = load(b.velocity) - shape * (z.real - load(b.slowing) * z.imaginary);
      store(b.depth, x);
      store(b.approach, rate);
    }
    const V psi = load(b.psi), judged = load(b.judged);
    const V energy = V(0.5) * load(b.mass) * rate * rate + V(0.5) * psi * psi;
    const auto steady = (x > V(0)) & (x + V(h) * rate > V(0)) & (energy <= V(1.1) * judged) &
                        (energy >= V(0.5) * judged);
    b.attention = simd::bits(!steady);
  }

  /// BodyKernel::press().
  [[gnu::always_inline]] static void press(PressedBlock& b, const double* from_real,
                                           const double* from_imaginary, double* real,
                                           double* imaginary, double rate_hz) noexcept {
    const double h = 1 / rate_hz;
    const State z = gather(b, from_real, from_imaginary);
    const V shape = load(b.shape), x = load(b.depth), rate = load(b.approach), step(h);
    const V body_free = shape * (load(b.mean_real) * z.real + load(b.mean_imaginary) * z.imaginary);
    const V own = load(b.own), velocity = load(b.velocity), mobility = load(b.mobility);
    const V own_free = velocity + own * load(b.outer_force), free = own_free - body_free;

    const V middle = within_reach(x + V(0.5) * (step * rate));
    const V root = power(b, middle, V(0) < V(1));
    const V gamma = load(b.gamma_scale) * root, psi_before = load(b.psi);
    const V offset = gamma * psi_before;
    const V slope = V(0.5 * h) * gamma * gamma + load(b.loss_scale) * middle * root * root;
    const V under = V(1) / (V(1) + mobility * slope);
    const V full_force = (offset + slope * free) * under;
    const auto acts = (slope > V(ContactSystem::kLeastSlope)) & !(full_force < V(0));
    const V force = simd::select(acts, full_force, V(0));
    const V mean = simd::select(acts, (free - mobility * offset) * under, free);
    V psi = simd::select(acts, psi_before + gamma * step * mean, psi_before);

    const V own_mean = own_free - own * force, after = x + step * mean;
    const V next_velocity = V(2) * own_mean - velocity;
    const V next_rate = mean + V(0.5) * (mean - load(b.mean_velocity));
    store(b.before, x);
    store(b.depth, after);
    store(b.place, load(b.place) + step * own_mean);
    store(b.velocity, next_velocity);
    store(b.approach, next_rate);
    store(b.mean_velocity, mean);
    store(b.step_force, force);
    store(b.force, step * force * V(rate_hz));

    // What the contact stores is put back to what the depth asks for.
    const auto stays = after > V(0);
    const V depth = within_reach(after), bank = load(b.bank);
    const V wanted = load(b.psi_scale) * depth * power(b, depth, stays);
    const V surplus = V(0.5) * (wanted * wanted - psi * psi);
    const auto paid = surplus <= bank;
    const V rest = simd::select(paid, wanted, simd::square_root(psi * psi + V(2) * bank));
    psi = simd::select(stays, rest, psi);
    store(b.psi, psi);
    store(b.bank, simd::select(stays, simd::select(paid, bank - surplus, V(0)), bank));

    const V highest = load(b.highest);
    store(b.duration, simd::select(stays, load(b.duration) + step, load(b.duration)));
    store(b.impulse, simd::select(stays, load(b.impulse) + step * force, load(b.impulse)));
    store(b.highest, simd::select(stays & (force > highest), force, highest));
    b.attention = simd::bits(!(stays & (simd::absolute(next_velocity) < V(kFastest)) &
                               (simd::absolute(force) < V(kMostState)) &
                               (simd::absolute(mean) < V(kMostState))));

    const V push = shape * force, cosine = load(b.turn_real), sine = load(b.turn_imaginary);
    alignas(64) Row re, im;
    store(re, cosine * z.real - sine * z.imaginary + load(b.response_real) * push);
    store(im, cosine * z.imaginary + sine * z.real + load(b.response_imaginary) * push);
    for (std::size_t l = 0; l < b.used; ++l) {
      real[b.mode[l]] = re[l];
      imaginary[b.mode[l]] = im[l];
    }
  }
};

} // namespace tactus::contact
