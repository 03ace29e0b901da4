#pragma once

#include "core/contact/contact_system.hpp"
#include "core/contact/pressed_contacts.hpp"
#include "core/dsp/simd.hpp"

/// Steps of PressedBlocks, written once for any instruction set. They do the operations of Exciter
/// and Impact in the same order, so that a contact gives the same bits in a block as outside one.
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
    return simd::select(x < V(Impact::kMinDepth), V(Impact::kMinDepth),
                        simd::select(x > V(Impact::kMaxDepth), V(Impact::kMaxDepth), x));
  }
  /// TaylorPower of the active lanes; the values of the others are not used.
  [[gnu::always_inline]] static V power(PressedBlock& b, const V& x,
                                        const typename V::MaskType& active_lanes) noexcept {
    V d = x * load(b.power_inverse) - V(1), value = load(b.power_value);
    const auto far = active_lanes & !(simd::absolute(d) < load(b.power_limit));
    if (simd::any(far)) {
      for (int l = 0; l < kLanes; ++l)
        if (simd::lane(far, l)) {
          const auto i = static_cast<std::size_t>(l);
          const double anchor = simd::lane(x, l), power = Power(b.exponent[i])(anchor);
          b.power_value[i] = power;
          b.power_inverse[i] = 1 / anchor;
          simd::set_lane(value, l, power);
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
  /// BodyKernel::check_pressed().
  [[gnu::always_inline]] static void check_pressed(PressedBlock& b, const double* real,
                                                   const double* imaginary, bool measure,
                                                   double h) noexcept {
    V x = load(b.depth), rate = load(b.approach);
    if (measure) {
      const State z = gather(b, real, imaginary);
      const V shape = load(b.shape);
      x = load(b.position) - shape * z.imaginary * load(b.displacement);
      rate = load(b.velocity) - shape * (z.real - load(b.decay_over_omega) * z.imaginary);
      store(b.depth, x);
      store(b.approach, rate);
    }
    const V psi = load(b.psi), level_energy = load(b.level_energy);
    const V energy = V(0.5) * load(b.mass) * rate * rate + V(0.5) * psi * psi;
    const auto level_valid_lanes = (x > V(0)) & (x + V(h) * rate > V(0)) &
                                   (energy <= V(1.1) * level_energy) &
                                   (energy >= V(0.5) * level_energy);
    b.needs_attention = simd::bits(!level_valid_lanes);
  }

  /// BodyKernel::press().
  // One function without branches, so that four contacts stay in registers.
  [[gnu::always_inline]] static void press(PressedBlock& b, const double* from_real,
                                           const double* from_imaginary, double* real,
                                           double* imaginary, double rate_hz) noexcept {
    const double h = 1 / rate_hz;
    const State z = gather(b, from_real, from_imaginary);
    const V shape = load(b.shape), x = load(b.depth), rate = load(b.approach), step(h);
    const V body_free = shape * (load(b.mean_real) * z.real + load(b.mean_imaginary) * z.imaginary);
    const V own_mobility = load(b.own_mobility), velocity = load(b.velocity),
            mobility = load(b.mobility);
    const V own_free_velocity = velocity + own_mobility * load(b.external_force),
            free = own_free_velocity - body_free;

    const V middle = within_reach(x + V(0.5) * (step * rate));
    const V root = power(b, middle, V(0) < V(1));
    const V gamma = load(b.gamma_scale) * root, psi_before = load(b.psi);
    const V offset = gamma * psi_before;
    const V slope = V(0.5 * h) * gamma * gamma + load(b.loss_scale) * middle * root * root;
    const V inverse_denominator = V(1) / (V(1) + mobility * slope);
    const V unclamped_force = (offset + slope * free) * inverse_denominator;
    const auto acts = (slope > V(ContactSystem::kMinSlope)) & !(unclamped_force < V(0));
    const V force = simd::select(acts, unclamped_force, V(0));
    const V mean = simd::select(acts, (free - mobility * offset) * inverse_denominator, free);
    V psi = simd::select(acts, psi_before + gamma * step * mean, psi_before);

    const V own_mean_velocity = own_free_velocity - own_mobility * force, after = x + step * mean;
    const V next_velocity = V(2) * own_mean_velocity - velocity;
    const V next_rate = mean + V(0.5) * (mean - load(b.mean_velocity));
    store(b.before, x);
    store(b.depth, after);
    store(b.position, load(b.position) + step * own_mean_velocity);
    store(b.velocity, next_velocity);
    store(b.approach, next_rate);
    store(b.mean_velocity, mean);
    store(b.step_force, force);
    store(b.force, step * force * V(rate_hz));

    // Impact::leave_step(): psi is set to psi* as far as the energy account allows.
    const auto still_touching = after > V(0);
    const V depth = within_reach(after), energy_account = load(b.energy_account);
    const V target_psi = load(b.psi_scale) * depth * power(b, depth, still_touching);
    const V energy_error = V(0.5) * (target_psi * target_psi - psi * psi);
    const auto affordable = energy_error <= energy_account;
    const V next_psi =
        simd::select(affordable, target_psi, simd::square_root(psi * psi + V(2) * energy_account));
    psi = simd::select(still_touching, next_psi, psi);
    store(b.psi, psi);
    store(b.energy_account,
          simd::select(still_touching,
                       simd::select(affordable, energy_account - energy_error, V(0)),
                       energy_account));

    const V peak = load(b.peak);
    store(b.duration, simd::select(still_touching, load(b.duration) + step, load(b.duration)));
    store(b.impulse, simd::select(still_touching, load(b.impulse) + step * force, load(b.impulse)));
    store(b.peak, simd::select(still_touching & (force > peak), force, peak));
    b.needs_attention = simd::bits(
        !(still_touching & (simd::absolute(next_velocity) < V(kMaxSpeed)) &
          (simd::absolute(force) < V(kMaxState)) & (simd::absolute(mean) < V(kMaxState))));

    const V modal_force = shape * force, cosine = load(b.pole_real), sine = load(b.pole_imaginary);
    alignas(64) Row re, im;
    store(re, cosine * z.real - sine * z.imaginary + load(b.response_real) * modal_force);
    store(im, cosine * z.imaginary + sine * z.real + load(b.response_imaginary) * modal_force);
    for (std::size_t l = 0; l < b.used; ++l) {
      real[b.mode[l]] = re[l];
      imaginary[b.mode[l]] = im[l];
    }
  }
};

} // namespace tactus::contact
