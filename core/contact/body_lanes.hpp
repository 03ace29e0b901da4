#pragma once

#include "core/contact/body_kernel.hpp"
#include "core/dsp/simd.hpp"

#include <cmath>
#include <cstring>

/// The kernel, written once for any instruction set; a template on the set, so that the linker
/// never takes a newer processor's code for an older one's. Sums run over eight lanes and then over
/// these, always in that order.
namespace tactus::contact {

template <class Set> class BodyLanes final : public BodyKernel {
  using V = simd::Lanes<double, static_cast<int>(kModeLanes), Set>;

  [[gnu::always_inline]] static V load(const double* from) noexcept {
    V v;
    std::memcpy(&v, from, sizeof(V));
    return v;
  }
  [[gnu::always_inline]] static void store(double* to, const V& v) noexcept {
    std::memcpy(to, &v, sizeof(V));
  }
  [[gnu::always_inline]] static double across(const V& v) noexcept {
    double part[kModeLanes];
    std::memcpy(part, &v, sizeof(V));
    return ((part[0] + part[4]) + (part[2] + part[6])) +
           ((part[1] + part[5]) + (part[3] + part[7]));
  }

  /// Mean velocity of a step under a force over sqrt(m); `outer` includes h/2.
  [[gnu::always_inline]] static V mean_of(const ModesView& m, std::size_t i,
                                          const V& half_outer) noexcept {
    return load(m.mean + i) * ((load(m.velocity + i) - load(m.turn + i) * load(m.potential + i)) +
                               half_outer * load(m.outer + i));
  }
  [[gnu::always_inline]] static void turn(const ModesView& m, std::size_t i,
                                          const V& mean) noexcept {
    const V twice = mean + mean;
    store(m.potential + i, load(m.potential + i) + load(m.turn + i) * twice);
    store(m.velocity + i, twice - load(m.velocity + i));
  }
  [[gnu::always_inline]] static double meet(const ModesView& m, const double* shape,
                                            const V& half) noexcept {
    V sum(0.0);
    for (std::size_t i = 0; i < m.padded; i += kModeLanes)
      sum += load(shape + i) * mean_of(m, i, half);
    return across(sum);
  }
  [[gnu::always_inline]] static void go_on(const ModesView& m, const double* shape, double force,
                                           double half_step, const V& half) noexcept {
    const V push(half_step * force);
    for (std::size_t i = 0; i < m.padded; i += kModeLanes)
      turn(m, i, mean_of(m, i, half) + load(m.mean + i) * (push * load(shape + i)));
  }

  [[gnu::always_inline]] static void strike(const ModesView& m, const double* shape, Exciter& e,
                                            Steps steps) noexcept {
    const double h = steps.length_s, half_step = 0.5 * h;
    const V half(half_step);
    const double own = half_step / e.mass_kg, mobility = e.mobility[steps.level];
    double x = e.depth_m, rate = e.approach_m_per_s, impulse = 0;
    double place = e.place_m, velocity = e.velocity_m_per_s;
    for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
      bool meets = Impact::meets(x, rate, h);
      if (meets && e.impulsive && !e.impact.touching() && rate > 0) {
        const double knocked =
            (1 + restitution(e.impact.law().dissipation_s_per_m * rate)) * rate / e.quick_mobility;
        const V all(knocked);
        for (std::size_t i = 0; i < m.padded; i += kModeLanes)
          store(m.velocity + i, load(m.velocity + i) + all * load(shape + i));
        velocity -= knocked / e.mass_kg;
        rate -= knocked * e.quick_mobility;
        meets = Impact::meets(x, rate, h);
        impulse += knocked;
        e.book_impulse(knocked, h);
      }
      const double own_free = velocity + own * e.outer_force_n;
      const double free = own_free - meet(m, shape, half);
      double force = 0, mean = free;
      if (meets) {
        const LinearForce law = e.impact.enter_step(x, rate, h);
        const double over = 1 / (1 + mobility * law.slope_ns_per_m);
        force = (law.offset_n + law.slope_ns_per_m * free) * over;
        if (force > 0) {
          mean = (free - mobility * law.offset_n) * over;
          e.impact.pass_step(mean, h);
        } else {
          force = 0;
        }
      }
      go_on(m, shape, force, half_step, half);
      const double own_mean = own_free - own * force;
      place += h * own_mean;
      velocity = 2 * own_mean - velocity;
      const double before = x;
      x += h * mean;
      rate = 2 * mean - rate;
      e.impact.leave_step(x);
      e.book(before, x, force, h);
      impulse += h * force;
      e.mean_velocity_m_per_s = mean;
    }
    e.place_m = place;
    e.velocity_m_per_s = velocity;
    e.depth_m = x;
    e.approach_m_per_s = rate;
    e.impulse_ns = impulse;
  }

  [[gnu::always_inline]] static void rub(const ModesView& m, const double* shape, Exciter& e,
                                         Steps steps) noexcept {
    const double h = steps.length_s, half_step = 0.5 * h;
    const V half(half_step);
    const double mobility = e.mobility[steps.level];
    double rate = e.approach_m_per_s, impulse = 0, dissipated = 0;
    for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
      const double free = e.rubbing_m_per_s - meet(m, shape, half);
      e.friction.enter_step(e.normal_force_n, rate,
                            e.friction.law().roughness > 0 ? e.noise.normal() : 0.0, h);
      LinearForce law = e.friction.stage();
      double over = 1 / (1 + mobility * law.slope_ns_per_m);
      e.friction.refine((free - mobility * law.offset_n) * over);
      law = e.friction.stage();
      over = 1 / (1 + mobility * law.slope_ns_per_m);
      const double mean = (free - mobility * law.offset_n) * over;
      const double force = (law.offset_n + law.slope_ns_per_m * free) * over;
      const double stored = e.friction.stored_j();
      e.friction.pass_step(mean);
      dissipated += h * force * mean + (stored - e.friction.stored_j());
      go_on(m, shape, force, half_step, half);
      rate = 2 * mean - rate;
      impulse += h * force;
      e.mean_velocity_m_per_s = mean;
    }
    e.approach_m_per_s = rate;
    e.impulse_ns = impulse;
    e.dissipated_j = dissipated;
  }

public:
  void ring(const ModesView& m, Steps steps) const noexcept override {
    const V half(0.5 * steps.length_s);
    for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;)
      for (std::size_t i = 0; i < m.padded; i += kModeLanes)
        turn(m, i, mean_of(m, i, half));
  }
  void touch(const ModesView& m, const double* shape, Exciter& e,
             Steps steps) const noexcept override {
    e.kind == Exciter::Kind::kFriction ? rub(m, shape, e, steps) : strike(m, shape, e, steps);
  }
  void free_mean(const ModesView& m, double* mean, double h) const noexcept override {
    const V half(0.5 * h);
    for (std::size_t i = 0; i < m.padded; i += kModeLanes)
      store(mean + i, mean_of(m, i, half));
  }
  void advance(const ModesView& m, const double* mean) const noexcept override {
    for (std::size_t i = 0; i < m.padded; i += kModeLanes)
      turn(m, i, load(mean + i));
  }
  void add(double* to, const double* from, double factor,
           std::size_t padded) const noexcept override {
    const V all(factor);
    for (std::size_t i = 0; i < padded; i += kModeLanes)
      store(to + i, load(to + i) + all * load(from + i));
  }
  void add_product(double* to, const double* from, const double* by, double factor,
                   std::size_t padded) const noexcept override {
    const V all(factor);
    for (std::size_t i = 0; i < padded; i += kModeLanes)
      store(to + i, load(to + i) + all * load(from + i) * load(by + i));
  }
  double dot(const double* a, const double* b, std::size_t padded) const noexcept override {
    V sum(0.0);
    for (std::size_t i = 0; i < padded; i += kModeLanes)
      sum += load(a + i) * load(b + i);
    return across(sum);
  }
  double dot(const double* a, const double* b, const double* c,
             std::size_t padded) const noexcept override {
    V sum(0.0);
    for (std::size_t i = 0; i < padded; i += kModeLanes)
      sum += load(a + i) * load(b + i) * load(c + i);
    return across(sum);
  }
};

} // namespace tactus::contact
