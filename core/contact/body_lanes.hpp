#pragma once

#include "core/contact/body_kernel.hpp"
#include "core/contact/pressed_lanes.hpp"
#include "core/dsp/vector.hpp"

#include <cmath>

/// BodyKernel, written once for any instruction set. The set is a template parameter, so the linker
/// cannot use code for a newer processor in place of code for an older one. No operations are
/// fused, and sums run over eight lanes, then across the lanes in a fixed order. So every set gives
/// the same bits.
namespace tactus::contact {

/// Vectors of a set, and a group of kModeLanes numbers in them.
template <class Set> using Lanes = simd::Vectors<Set, double, kModeLanes>;

template <class Set> class BodyLanes final : public BodyKernel, Lanes<Set> {
  using L = Lanes<Set>;
  using V = typename L::V;
  using L::across, L::all, L::kRegisters, L::kWidth, L::load, L::store;

  /// Calls work(i, r) for every register of the modes: i is its first mode, r its index within a
  /// group of kModeLanes.
  template <class Work>
  [[gnu::always_inline]] static void for_each_register(std::size_t padded,
                                                       const Work& work) noexcept {
    for (std::size_t k = 0; k < padded; k += kModeLanes) {
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kRegisters; ++r)
        work(k + r * kWidth, r);
    }
  }
  struct State {
    V real, imaginary;
  };
  /// P z.
  [[gnu::always_inline]] static State advanced(const ModesView& m, std::size_t i) noexcept {
    const V real = load(m.real + i), imaginary = load(m.imaginary + i);
    const V cosine = load(m.pole_real + i), sine = load(m.pole_imaginary + i);
    return {cosine * real - sine * imaginary, cosine * imaginary + sine * real};
  }
  [[gnu::always_inline]] static void store(const ModesView& m, std::size_t i,
                                           const State& z) noexcept {
    store(m.real + i, z.real);
    store(m.imaginary + i, z.imaginary);
  }
  /// Sum of the modal forces over sqrt(m).
  [[gnu::always_inline]] static V force_of(std::span<const PointForce> forces,
                                           std::size_t i) noexcept {
    V sum{};
    for (const PointForce& point : forces)
      sum += all(point.force) * load(point.shape + i);
    return sum;
  }
  /// Advances the state by a step under a force at the point, and updates the prediction.
  [[gnu::always_inline]] static void advance_state(const ModesView& m, const PointView& point,
                                                   double force, Prediction& next) noexcept {
    const double free = next.base + point.next_mobility * force;
    const V point_force = all(force);
    V sums[kRegisters] = {};
    for_each_register(m.padded, [&](std::size_t i, std::size_t r) {
      State z = advanced(m, i);
      z.real += point_force * load(point.response_at_point_real + i);
      z.imaginary += point_force * load(point.response_at_point_imaginary + i);
      store(m, i, z);
      sums[r] += load(point.next_mean_real + i) * z.real +
                 load(point.next_mean_imaginary + i) * z.imaginary;
    });
    next = {free, across(sums)};
  }

  [[gnu::always_inline]] static double velocity_at(const double* shape, const double* real,
                                                   const double* imaginary,
                                                   const double* decay_over_omega,
                                                   std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    for_each_register(padded, [&](std::size_t i, std::size_t r) {
      sums[r] +=
          load(shape + i) * (load(real + i) - load(decay_over_omega + i) * load(imaginary + i));
    });
    return across(sums);
  }

  /// Impulse of a contact that is too short even for the finest steps, N s, with the restitution of
  /// its law; 0 if the mass does not approach the surface.
  [[gnu::noinline, gnu::cold]] static double impulse_step(const ModesView& m,
                                                          const PointView& contact_point,
                                                          Prediction& next, Exciter& e,
                                                          double mass_velocity, double h) noexcept {
    const double rate = mass_velocity - velocity_at(contact_point.shape, m.real, m.imaginary,
                                                    m.decay_over_omega, m.padded);
    if (!(rate > 0))
      return 0;
    const double restitution_coefficient = restitution(e.impact.law().dissipation_s_per_m * rate);
    const double impulse = (1 + restitution_coefficient) * rate * e.effective_mass_kg;
    for_each_register(m.padded, [&](std::size_t i, std::size_t) {
      store(m.real + i, load(m.real + i) + all(impulse) * load(contact_point.shape + i));
    });
    next = predicted(m, contact_point);
    e.record_impulse(impulse, h);
    return impulse;
  }

  /// Writes the outputs of one sample of a batch.
  [[gnu::always_inline]] static void write_outputs(const ModesView& m, const SampleBatch& batch,
                                                   std::size_t sample, double force) noexcept {
    if (batch.force)
      batch.force[sample] = force;
    if (batch.output)
      batch.output[sample] =
          sums(batch.pickup_real, m.real, batch.pickup_imaginary, m.imaginary, m.padded);
  }

  /// Advances an impact by the samples of a batch.
  // One function, so that the state of mass and contact stays in registers over all steps of the
  // batch.
  template <bool compliant>
  [[gnu::always_inline]] static std::size_t
  strike(const ModesView& m, const PointView& contact_point, Prediction& prediction, Exciter& e,
         Steps steps, const SampleBatch& batch) noexcept {
    const double h = steps.length_s;
    const double own_mobility = 0.5 * h * e.inverse_mass, mobility = e.mobility[steps.level];
    const double sample_rate_hz = 1 / (h * static_cast<double>(std::size_t{1} << steps.level));
    double x = e.depth_m, rate = e.approach_m_per_s, position = e.position_m,
           velocity = e.velocity_m_per_s, impulse = 0, mean = e.mean_velocity_m_per_s;
    Impact impact = e.impact;
    Prediction next = prediction;
    std::size_t done = 0;
    for (bool continuing = true; continuing && done < batch.count; ++done) {
      const double external =
          own_mobility * (e.external_force_n = bounded(batch.drive[done], kMaxForce));
      impulse = 0;
      for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
        double own_free_velocity = velocity + external, free = own_free_velocity - next.free;
        bool in_contact = Impact::in_contact(x, rate, h);
        if (in_contact && e.impulsive && !impact.touching() && rate > 0) {
          const double step_impulse = impulse_step(m, contact_point, next, e, velocity, h);
          velocity -= step_impulse * e.inverse_mass;
          impulse += step_impulse;
          own_free_velocity = velocity + external;
          mean = rate = free = own_free_velocity - next.free;
          in_contact = Impact::in_contact(x, rate, h);
        }
        double force = 0;
        const double mean_before = mean;
        mean = free;
        if (in_contact) {
          const LinearForce law = impact.template enter_step<compliant>(x, rate, h);
          const double inverse_denominator = 1 / (1 + mobility * law.slope_ns_per_m);
          force = (law.offset_n + law.slope_ns_per_m * free) * inverse_denominator;
          if (force > 0) {
            mean = (free - mobility * law.offset_n) * inverse_denominator;
            impact.pass_step(mean, h);
          } else {
            force = 0;
          }
        }
        const double from = x;
        x += h * mean;
        rate = extrapolate_velocity(mean, mean_before);
        impact.template leave_step<compliant>(x);
        advance_state(m, contact_point, force, next);
        const double own_mean_velocity = own_free_velocity - own_mobility * force;
        position += h * own_mean_velocity;
        velocity = 2 * own_mean_velocity - velocity;
        e.record_step(from, x, force, h);
        impulse += h * force;
      }
      const double force = impulse * sample_rate_hz;
      write_outputs(m, batch, done, force);
      continuing = impact.touching() &&
                   e.level_valid(0.5 * e.effective_mass_kg * rate * rate + impact.stored_j()) &&
                   std::abs(velocity) < kMaxSpeed && std::abs(force) < kMaxState &&
                   std::abs(mean) < kMaxState;
    }
    e.impact = impact;
    e.position_m = position;
    e.velocity_m_per_s = velocity;
    e.depth_m = x;
    e.approach_m_per_s = rate;
    e.mean_velocity_m_per_s = mean;
    e.force_n = impulse * sample_rate_hz;
    prediction = next;
    return done;
  }

  /// Advances friction by the samples of a batch; with the random part of the force if `rough`.
  template <bool rough>
  [[gnu::always_inline]] static std::size_t rub(const ModesView& m, const PointView& contact_point,
                                                Prediction& prediction, Exciter& e, Steps steps,
                                                const SampleBatch& batch) noexcept {
    const double h = steps.length_s;
    const double mobility = e.mobility[steps.level];
    const double sample_rate_hz = 1 / (h * static_cast<double>(std::size_t{1} << steps.level));
    double last_force = e.last_force_n, rubbing = e.rubbing_m_per_s, normal = e.normal_force_n,
           impulse = 0, dissipated = 0, mean = e.mean_velocity_m_per_s;
    Friction friction = e.friction;
    Prediction next = prediction;
    std::size_t done = 0;
    for (bool continuing = true; continuing && done < batch.count; ++done) {
      const double surface = bounded(batch.drive[done], kMaxSpeed);
      normal = bounded(batch.normal[done], kMaxForce);
      mean += surface - rubbing;
      rubbing = surface;
      if (!(normal > 0)) // the surfaces have separated
        break;
      impulse = dissipated = 0;
      for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
        const double free = rubbing - next.free;
        const double rate = initial_velocity(free - mobility * last_force, mean);
        friction.enter_step(normal, rate, rough ? e.noise.normal() : 0.0, h);
        friction.refine(friction.mean(free, mobility));
        mean = friction.mean(free, mobility);
        const double force = friction.force(free, mobility);
        const double stored = friction.stored_j();
        friction.pass_step(mean);
        dissipated += h * force * mean + (stored - friction.stored_j());
        advance_state(m, contact_point, force, next);
        last_force = force;
        impulse += h * force;
      }
      const double force = impulse * sample_rate_hz;
      write_outputs(m, batch, done, force);
      continuing = std::abs(force) < kMaxState && std::abs(mean) < kMaxState;
    }
    e.friction = friction;
    e.approach_m_per_s = mean;
    e.last_force_n = last_force;
    e.rubbing_m_per_s = rubbing;
    e.normal_force_n = normal;
    e.dissipated_j = dissipated;
    e.mean_velocity_m_per_s = mean;
    e.force_n = impulse * sample_rate_hz;
    prediction = next;
    return done;
  }
  [[gnu::always_inline]] static double sum(const double* a, const double* b,
                                           std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    for_each_register(padded,
                      [&](std::size_t i, std::size_t r) { sums[r] += load(a + i) * load(b + i); });
    return across(sums);
  }
  [[gnu::always_inline]] static double sums(const double* a, const double* b, const double* c,
                                            const double* d, std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    for_each_register(padded, [&](std::size_t i, std::size_t r) {
      sums[r] += load(a + i) * load(b + i) + load(c + i) * load(d + i);
    });
    return across(sums);
  }
  [[gnu::always_inline]] static Prediction predicted(const ModesView& m,
                                                     const PointView& point) noexcept {
    V free[kRegisters] = {}, base[kRegisters] = {};
    for_each_register(m.padded, [&](std::size_t i, std::size_t r) {
      const V real = load(m.real + i), imaginary = load(m.imaginary + i);
      free[r] += load(point.shape + i) *
                 (load(m.mean_real + i) * real + load(m.mean_imaginary + i) * imaginary);
      base[r] +=
          load(point.next_mean_real + i) * real + load(point.next_mean_imaginary + i) * imaginary;
    });
    return {across(free), across(base)};
  }

public:
  void ring(const ModesView& m) const noexcept override {
    for_each_register(m.padded, [&](std::size_t i, std::size_t) { store(m, i, advanced(m, i)); });
  }
  double ring_with_output(const ModesView& m, const double* pickup_real,
                          const double* pickup_imaginary) const noexcept override {
    V sums[kRegisters] = {};
    for_each_register(m.padded, [&](std::size_t i, std::size_t r) {
      const State z = advanced(m, i);
      store(m, i, z);
      sums[r] += load(pickup_real + i) * z.real + load(pickup_imaginary + i) * z.imaginary;
    });
    return across(sums);
  }
  Prediction predict(const ModesView& m, const PointView& point) const noexcept override {
    return predicted(m, point);
  }
  std::size_t advance_contact(const ModesView& m, const PointView& point, Prediction& next,
                              Exciter& e, Steps steps,
                              const SampleBatch& batch) const noexcept override {
    if (e.kind == Exciter::Kind::kImpact)
      return e.impact.compliant() ? strike<true>(m, point, next, e, steps, batch)
                                  : strike<false>(m, point, next, e, steps, batch);
    return e.friction.law().roughness > 0 ? rub<true>(m, point, next, e, steps, batch)
                                          : rub<false>(m, point, next, e, steps, batch);
  }
  void mean(const ModesView& m, std::span<const PointForce> forces,
            double* mean) const noexcept override {
    for_each_register(m.padded, [&](std::size_t i, std::size_t) {
      const V z = load(m.mean_real + i) * load(m.real + i) +
                  load(m.mean_imaginary + i) * load(m.imaginary + i);
      store(mean + i, z + load(m.mobility + i) * force_of(forces, i));
    });
  }
  void free_mean(const ModesView& m, double* mean) const noexcept override {
    for_each_register(m.padded, [&](std::size_t i, std::size_t) {
      store(mean + i, load(m.mean_real + i) * load(m.real + i) +
                          load(m.mean_imaginary + i) * load(m.imaginary + i));
    });
  }
  void advance(const ModesView& m, std::span<const PointForce> forces) const noexcept override {
    for_each_register(m.padded, [&](std::size_t i, std::size_t) {
      State z = advanced(m, i);
      const V f = force_of(forces, i);
      z.real += load(m.response_real + i) * f;
      z.imaginary += load(m.response_imaginary + i) * f;
      store(m, i, z);
    });
  }
  void check_pressed(std::span<PressedBlock> blocks, const double* real, const double* imaginary,
                     bool measure, double h) const noexcept override {
    for (PressedBlock& block : blocks)
      PressedLanes<Set>::check_pressed(block, real, imaginary, measure, h);
  }
  void press(std::span<PressedBlock> blocks, const double* from_real, const double* from_imaginary,
             double* real, double* imaginary, double sample_rate) const noexcept override {
    for (PressedBlock& block : blocks)
      PressedLanes<Set>::press(block, from_real, from_imaginary, real, imaginary, sample_rate);
  }
  void add(double* to, const double* from, double factor,
           std::size_t padded) const noexcept override {
    const V times = all(factor);
    for_each_register(padded, [&](std::size_t i, std::size_t) {
      store(to + i, load(to + i) + times * load(from + i));
    });
  }
  double dot(const double* a, const double* b, std::size_t padded) const noexcept override {
    return sum(a, b, padded);
  }
  double dot(const double* a, const double* b, const double* c,
             std::size_t padded) const noexcept override {
    V sums[kRegisters] = {};
    for_each_register(padded, [&](std::size_t i, std::size_t r) {
      sums[r] += load(a + i) * load(b + i) * load(c + i);
    });
    return across(sums);
  }
  double dots(const double* a, const double* b, const double* c, const double* d,
              std::size_t padded) const noexcept override {
    return sums(a, b, c, d, padded);
  }
  double velocity(const double* shape, const double* real, const double* imaginary,
                  const double* decay_over_omega, std::size_t padded) const noexcept override {
    return velocity_at(shape, real, imaginary, decay_over_omega, padded);
  }
};

} // namespace tactus::contact
