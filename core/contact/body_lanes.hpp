#pragma once

#include "core/contact/body_kernel.hpp"
#include "core/contact/pressed_lanes.hpp"
#include "core/dsp/vector.hpp"

#include <cmath>

/// The kernel, written once for any instruction set; a template on the set, so that the linker
/// never takes a newer processor's code for an older one's. Without fused operations, and sums run
/// over eight lanes and then over these in one order: every set gives the same bits.
namespace tactus::contact {

/// Vectors of a set, and a group of kModeLanes numbers in them.
template <class Set> using Lanes = simd::Vectors<Set, double, kModeLanes>;

template <class Set> class BodyLanes final : public BodyKernel, Lanes<Set> {
  using L = Lanes<Set>;
  using V = typename L::V;
  using L::across, L::all, L::kRegisters, L::kWidth, L::load, L::store;

  /// Calls work(i, r) for all registers of the modes, r counting those of a group of lanes.
  template <class Work>
  [[gnu::always_inline]] static void over(std::size_t padded, const Work& work) noexcept {
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
  [[gnu::always_inline]] static State turned(const ModesView& m, std::size_t i) noexcept {
    const V real = load(m.real + i), imaginary = load(m.imaginary + i);
    const V cosine = load(m.turn_real + i), sine = load(m.turn_imaginary + i);
    return {cosine * real - sine * imaginary, cosine * imaginary + sine * real};
  }
  [[gnu::always_inline]] static void store(const ModesView& m, std::size_t i,
                                           const State& z) noexcept {
    store(m.real + i, z.real);
    store(m.imaginary + i, z.imaginary);
  }
  /// Forces over sqrt(m) on the modes, together.
  [[gnu::always_inline]] static V force_of(const double* outer, std::span<const Push> pushes,
                                           std::size_t i) noexcept {
    V sum = outer ? load(outer + i) : V{};
    for (const Push& push : pushes)
      sum += all(push.force) * load(push.shape + i);
    return sum;
  }
  /// A step on under a force at the place, and what it foresees.
  [[gnu::always_inline]] static void go_on(const ModesView& m, const PlaceView& place, double force,
                                           Foresight& next) noexcept {
    const double free = next.base + place.answer * force;
    const V push = all(force);
    V sums[kRegisters] = {};
    over(m.padded, [&](std::size_t i, std::size_t r) {
      State z = turned(m, i);
      z.real += push * load(place.push_real + i);
      z.imaginary += push * load(place.push_imaginary + i);
      store(m, i, z);
      sums[r] +=
          load(place.ahead_real + i) * z.real + load(place.ahead_imaginary + i) * z.imaginary;
    });
    next = {free, across(sums)};
  }

  [[gnu::always_inline]] static double velocity_at(const double* shape, const double* real,
                                                   const double* imaginary, const double* slowing,
                                                   std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    over(padded, [&](std::size_t i, std::size_t r) {
      sums[r] += load(shape + i) * (load(real + i) - load(slowing + i) * load(imaginary + i));
    });
    return across(sums);
  }

  /// What an impulse does instead of steps that would be too long.
  [[gnu::noinline, gnu::cold]] static double knock(const ModesView& m, const PlaceView& spot,
                                                   Foresight& next, Exciter& e, double own_velocity,
                                                   double h) noexcept {
    const double rate =
        own_velocity - velocity_at(spot.shape, m.real, m.imaginary, m.slowing, m.padded);
    if (!(rate > 0))
      return 0;
    const double kept = restitution(e.impact.law().dissipation_s_per_m * rate);
    const double impulse = (1 + kept) * rate * e.effective_mass_kg;
    over(m.padded, [&](std::size_t i, std::size_t) {
      store(m.real + i, load(m.real + i) + all(impulse) * load(spot.shape + i));
    });
    next = foreseen(m, spot);
    e.book_impulse(impulse, h);
    return impulse;
  }

  template <bool yields>
  [[gnu::always_inline]] static std::size_t strike(const ModesView& m, const PlaceView& spot,
                                                   Foresight& foresight, Exciter& e, Steps steps,
                                                   const Stretch& stretch) noexcept {
    const double h = steps.length_s;
    const double own = 0.5 * h * e.per_mass, mobility = e.mobility[steps.level];
    const double rate_of_samples = 1 / (h * static_cast<double>(std::size_t{1} << steps.level));
    double x = e.depth_m, rate = e.approach_m_per_s, place = e.place_m,
           velocity = e.velocity_m_per_s, impulse = 0, mean = e.mean_velocity_m_per_s;
    Impact impact = e.impact;
    Foresight next = foresight;
    std::size_t done = 0;
    for (bool goes_on = true; goes_on && done < stretch.count; ++done) {
      const double outer = own * (e.outer_force_n = bounded(stretch.drive[done], kMostForce));
      impulse = 0;
      for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
        double own_free = velocity + outer, free = own_free - next.free;
        bool meets = Impact::meets(x, rate, h);
        if (meets && e.impulsive && !impact.touching() && rate > 0) {
          const double jolt = knock(m, spot, next, e, velocity, h);
          velocity -= jolt * e.per_mass;
          impulse += jolt;
          own_free = velocity + outer;
          mean = rate = free = own_free - next.free;
          meets = Impact::meets(x, rate, h);
        }
        double force = 0;
        const double mean_before = mean;
        mean = free;
        if (meets) {
          const LinearForce law = impact.template enter_step<yields>(x, rate, h);
          const double under = 1 / (1 + mobility * law.slope_ns_per_m);
          force = (law.offset_n + law.slope_ns_per_m * free) * under;
          if (force > 0) {
            mean = (free - mobility * law.offset_n) * under;
            impact.pass_step(mean, h);
          } else {
            force = 0;
          }
        }
        const double from = x;
        x += h * mean;
        rate = continued(mean, mean_before);
        impact.template leave_step<yields>(x);
        go_on(m, spot, force, next);
        const double own_mean = own_free - own * force;
        place += h * own_mean;
        velocity = 2 * own_mean - velocity;
        e.book(from, x, force, h);
        impulse += h * force;
      }
      const double force = impulse * rate_of_samples;
      if (stretch.force)
        stretch.force[done] = force;
      if (stretch.heard)
        stretch.heard[done] =
            sums(stretch.ear_real, m.real, stretch.ear_imaginary, m.imaginary, m.padded);
      goes_on = impact.touching() &&
                e.judged(0.5 * e.effective_mass_kg * rate * rate + impact.stored_j()) &&
                std::abs(velocity) < kFastest && std::abs(force) < kMostState &&
                std::abs(mean) < kMostState;
    }
    e.impact = impact;
    e.place_m = place;
    e.velocity_m_per_s = velocity;
    e.depth_m = x;
    e.approach_m_per_s = rate;
    e.mean_velocity_m_per_s = mean;
    e.force_n = impulse * rate_of_samples;
    foresight = next;
    return done;
  }

  template <bool rough>
  [[gnu::always_inline]] static std::size_t rub(const ModesView& m, const PlaceView& spot,
                                                Foresight& foresight, Exciter& e, Steps steps,
                                                const Stretch& stretch) noexcept {
    const double h = steps.length_s;
    const double mobility = e.mobility[steps.level];
    const double rate_of_samples = 1 / (h * static_cast<double>(std::size_t{1} << steps.level));
    double last_force = e.last_force_n, rubbing = e.rubbing_m_per_s, normal = e.normal_force_n,
           impulse = 0, dissipated = 0, mean = e.mean_velocity_m_per_s;
    Friction friction = e.friction;
    Foresight next = foresight;
    std::size_t done = 0;
    for (bool goes_on = true; goes_on && done < stretch.count; ++done) {
      const double speed = bounded(stretch.drive[done], kFastest);
      normal = bounded(stretch.normal[done], kMostForce);
      mean += speed - rubbing;
      rubbing = speed;
      if (!(normal > 0)) // it has let go
        break;
      impulse = dissipated = 0;
      for (std::size_t n = std::size_t{1} << steps.level; n-- > 0;) {
        const double free = rubbing - next.free;
        const double rate = expected(free - mobility * last_force, mean);
        friction.enter_step(normal, rate, rough ? e.noise.normal() : 0.0, h);
        friction.refine(friction.mean(free, mobility));
        mean = friction.mean(free, mobility);
        const double force = friction.force(free, mobility);
        const double stored = friction.stored_j();
        friction.pass_step(mean);
        dissipated += h * force * mean + (stored - friction.stored_j());
        go_on(m, spot, force, next);
        last_force = force;
        impulse += h * force;
      }
      const double force = impulse * rate_of_samples;
      if (stretch.force)
        stretch.force[done] = force;
      if (stretch.heard)
        stretch.heard[done] =
            sums(stretch.ear_real, m.real, stretch.ear_imaginary, m.imaginary, m.padded);
      goes_on = std::abs(force) < kMostState && std::abs(mean) < kMostState;
    }
    e.friction = friction;
    e.approach_m_per_s = mean;
    e.last_force_n = last_force;
    e.rubbing_m_per_s = rubbing;
    e.normal_force_n = normal;
    e.dissipated_j = dissipated;
    e.mean_velocity_m_per_s = mean;
    e.force_n = impulse * rate_of_samples;
    foresight = next;
    return done;
  }
  [[gnu::always_inline]] static double sum(const double* a, const double* b,
                                           std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    over(padded, [&](std::size_t i, std::size_t r) { sums[r] += load(a + i) * load(b + i); });
    return across(sums);
  }
  [[gnu::always_inline]] static double sums(const double* a, const double* b, const double* c,
                                            const double* d, std::size_t padded) noexcept {
    V sums[kRegisters] = {};
    over(padded, [&](std::size_t i, std::size_t r) {
      sums[r] += load(a + i) * load(b + i) + load(c + i) * load(d + i);
    });
    return across(sums);
  }
  [[gnu::always_inline]] static Foresight foreseen(const ModesView& m,
                                                   const PlaceView& place) noexcept {
    V free[kRegisters] = {}, base[kRegisters] = {};
    over(m.padded, [&](std::size_t i, std::size_t r) {
      const V real = load(m.real + i), imaginary = load(m.imaginary + i);
      free[r] += load(place.shape + i) *
                 (load(m.mean_real + i) * real + load(m.mean_imaginary + i) * imaginary);
      base[r] += load(place.ahead_real + i) * real + load(place.ahead_imaginary + i) * imaginary;
    });
    return {across(free), across(base)};
  }

public:
  void ring(const ModesView& m) const noexcept override {
    over(m.padded, [&](std::size_t i, std::size_t) { store(m, i, turned(m, i)); });
  }
  double ring_heard(const ModesView& m, const double* ear_real,
                    const double* ear_imaginary) const noexcept override {
    V sums[kRegisters] = {};
    over(m.padded, [&](std::size_t i, std::size_t r) {
      const State z = turned(m, i);
      store(m, i, z);
      sums[r] += load(ear_real + i) * z.real + load(ear_imaginary + i) * z.imaginary;
    });
    return across(sums);
  }
  Foresight foresee(const ModesView& m, const PlaceView& place) const noexcept override {
    return foreseen(m, place);
  }
  std::size_t touch(const ModesView& m, const PlaceView& place, Foresight& next, Exciter& e,
                    Steps steps, const Stretch& stretch) const noexcept override {
    if (e.kind == Exciter::Kind::kImpact)
      return e.impact.yields() ? strike<true>(m, place, next, e, steps, stretch)
                               : strike<false>(m, place, next, e, steps, stretch);
    return e.friction.law().roughness > 0 ? rub<true>(m, place, next, e, steps, stretch)
                                          : rub<false>(m, place, next, e, steps, stretch);
  }
  void mean(const ModesView& m, const double* outer, std::span<const Push> pushes,
            double* mean) const noexcept override {
    over(m.padded, [&](std::size_t i, std::size_t) {
      const V z = load(m.mean_real + i) * load(m.real + i) +
                  load(m.mean_imaginary + i) * load(m.imaginary + i);
      store(mean + i, z + load(m.mobility + i) * force_of(outer, pushes, i));
    });
  }
  void free_mean(const ModesView& m, double* mean) const noexcept override {
    over(m.padded, [&](std::size_t i, std::size_t) {
      store(mean + i, load(m.mean_real + i) * load(m.real + i) +
                          load(m.mean_imaginary + i) * load(m.imaginary + i));
    });
  }
  void advance(const ModesView& m, const double* outer,
               std::span<const Push> pushes) const noexcept override {
    over(m.padded, [&](std::size_t i, std::size_t) {
      State z = turned(m, i);
      const V f = force_of(outer, pushes, i);
      z.real += load(m.response_real + i) * f;
      z.imaginary += load(m.response_imaginary + i) * f;
      store(m, i, z);
    });
  }
  void look_at(std::span<PressedBlock> blocks, const double* real, const double* imaginary,
               bool look, double h) const noexcept override {
    for (PressedBlock& block : blocks)
      PressedLanes<Set>::look_at(block, real, imaginary, look, h);
  }
  void press(std::span<PressedBlock> blocks, const double* from_real, const double* from_imaginary,
             double* real, double* imaginary, double sample_rate) const noexcept override {
    for (PressedBlock& block : blocks)
      PressedLanes<Set>::press(block, from_real, from_imaginary, real, imaginary, sample_rate);
  }
  void add(double* to, const double* from, double factor,
           std::size_t padded) const noexcept override {
    const V times = all(factor);
    over(padded,
         [&](std::size_t i, std::size_t) { store(to + i, load(to + i) + times * load(from + i)); });
  }
  double dot(const double* a, const double* b, std::size_t padded) const noexcept override {
    return sum(a, b, padded);
  }
  double dot(const double* a, const double* b, const double* c,
             std::size_t padded) const noexcept override {
    V sums[kRegisters] = {};
    over(padded,
         [&](std::size_t i, std::size_t r) { sums[r] += load(a + i) * load(b + i) * load(c + i); });
    return across(sums);
  }
  double dots(const double* a, const double* b, const double* c, const double* d,
              std::size_t padded) const noexcept override {
    return sums(a, b, c, d, padded);
  }
  double velocity(const double* shape, const double* real, const double* imaginary,
                  const double* slowing, std::size_t padded) const noexcept override {
    return velocity_at(shape, real, imaginary, slowing, padded);
  }
};

} // namespace tactus::contact
