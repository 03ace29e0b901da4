#include "core/reed/bore/hole_lattice.hpp"

#include "core/reed/bore/air.hpp"
#include "core/reed/bore/radiation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using Complex = HoleLattice::Complex;
constexpr double kPi = std::numbers::pi;
constexpr double kSlice = 4e-3;    // m, of a cone
constexpr double kSmallest = 2e-4; // m: a hole narrower than its boundary layers is shut

double square(double x) { return x * x; }

/// Matrix of a lossy cylinder, from (p, U) at its end to (p, U) at its beginning.
struct Tube {
  Complex cosh, over, under; // cosh, Z sinh, sinh/Z

  Tube(Complex s, const Air& air, double radius, double length) {
    const double area = kPi * square(radius);
    const Complex layer = 2.0 * std::sqrt(kKinematicViscosity / s) / radius;
    const double heat = (kHeatCapacityRatio - 1) / std::sqrt(kPrandtlNumber);
    const Complex series = s * air.density / area * (1.0 + layer);
    const Complex shunt = s * area / (air.density * square(air.sound_speed)) * (1.0 + heat * layer);
    const Complex gamma = std::sqrt(series * shunt), z = series / gamma;
    const Complex grown = std::exp(gamma * length), shrunk = 1.0 / grown;
    const Complex sinh = 0.5 * (grown - shrunk);
    cosh = 0.5 * (grown + shrunk);
    over = z * sinh;
    under = sinh / z;
  }
};

/// Impedance of an unflanged opening.
Complex opening(Complex s, const Air& air, double radius) {
  const Complex r = OpenEnd::reflection(s * radius / air.sound_speed);
  return air.density * air.sound_speed / (kPi * square(radius)) * (1.0 + r) / (1.0 - r);
}

/// sin(x)/x
double spread(double x) { return x < 1e-6 ? 1 : std::sin(x) / x; }

} // namespace

HoleLattice::HoleLattice(const Woodwind& instrument, std::span<const double> closed) noexcept
    : instrument_(instrument), key_(instrument.lowest_key),
      end_(instrument.place(instrument.lowest_key)) {
  start_ = end_;
  for (std::size_t i = 0; i < std::min(closed.size(), instrument.tone_holes()); ++i) {
    const Woodwind::Hole hole = instrument.tone_hole(i);
    const double radius = hole.radius * std::sqrt(std::clamp(1 - closed[i], 0.0, 1.0));
    if (radius < kSmallest)
      continue;
    if (count_ == 0) {
      key_ = instrument.key_of(i);
      start_ = hole.place;
    }
    const double bore = instrument.radius(hole.place), ratio = radius / bore;
    const double inner =
        radius * (0.82 + ratio * (-0.193 + ratio * (-1.09 + ratio * (1.27 - 0.71 * ratio))));
    const double matching = radius * ratio / 8 * (1 + 0.207 * ratio * ratio * ratio);
    const double along = -radius * square(ratio) /
                         (1.78 / std::tanh(1.84 * hole.height / radius) + 0.940 + 0.540 * ratio +
                          0.285 * square(ratio));
    open_[count_++] = {hole.place, radius, hole.height + inner + matching, bore, along};
  }
}

HoleLattice::Flow HoleLattice::through_bore(Complex s, double from, double to,
                                            Flow beyond) const noexcept {
  const Air air = air_at(20);
  const int slices =
      instrument_.apex > 0 ? std::max(1, static_cast<int>(std::ceil((to - from) / kSlice))) : 1;
  for (int i = slices; i-- > 0;) {
    const Tube tube(s, air, instrument_.radius(from + (i + 0.5) / slices * (to - from)),
                    (to - from) / slices);
    beyond = {tube.cosh * beyond.pressure + tube.over * beyond.flow,
              tube.under * beyond.pressure + tube.cosh * beyond.flow};
  }
  return beyond;
}

HoleLattice::Response HoleLattice::at(double omega) const noexcept {
  const Air air = air_at(20);
  const Complex s(0, omega);
  struct Source {
    double place;
    Complex flow;
    double load; // resistance
  };
  std::array<Source, Woodwind::kMaxToneHoles + 1> sources;
  std::size_t heard = 0;

  // The bell, from its mouth back to where it begins.
  const double bore = instrument_.radius(end_);
  const auto& last =
      instrument_.bell[static_cast<std::size_t>(std::max(0, instrument_.bell_corners - 1))];
  const Complex mouth = opening(s, air, bore * last.ratio);
  Flow now{mouth, 1.0};
  sources[heard++] = {end_ + last.distance, 1.0, mouth.real()};
  for (int k = instrument_.bell_corners - 1; k-- > 0;) {
    const auto& near = instrument_.bell[static_cast<std::size_t>(k)];
    const auto& far = instrument_.bell[static_cast<std::size_t>(k) + 1];
    const double length = far.distance - near.distance;
    const int slices = std::max(1, static_cast<int>(std::ceil(length / kSlice)));
    for (int i = slices; i-- > 0;) {
      const double ratio = near.ratio + (i + 0.5) / slices * (far.ratio - near.ratio);
      const Tube tube(s, air, bore * ratio, length / slices);
      now = {tube.cosh * now.pressure + tube.over * now.flow,
             tube.under * now.pressure + tube.cosh * now.flow};
    }
  }
  double here = end_;
  for (std::size_t k = count_; k-- > 0;) {
    const Open& hole = open_[k];
    now = through_bore(s, hole.place, here, now);
    here = hole.place;
    const Complex extra = s * air.density * hole.along / (2 * kPi * square(hole.bore));
    now.pressure += extra * now.flow;
    const Complex load = opening(s, air, hole.radius);
    const Tube chimney(s, air, hole.radius, hole.height);
    const Complex out = now.pressure / (chimney.cosh * load + chimney.over);
    sources[heard++] = {hole.place, out, load.real()};
    now.flow += (chimney.under * load + chimney.cosh) * out;
    now.pressure += extra * now.flow;
  }

  const double radius = instrument_.radius(start_);
  const double unit = kPi * square(radius) / (air.density * air.sound_speed);
  const Complex bend = instrument_.apex > 0 ? air.sound_speed / (s * start_) : Complex(0);
  const Complex admittance = now.flow / now.pressure / unit;
  const Complex reflected = (1.0 + bend - admittance) / (admittance + 1.0 - bend);
  const Complex scale = (1.0 + reflected) / now.pressure;
  // Each source's size is the root of its power, so that a wide opening sends out all it gets.
  std::array<Complex, Woodwind::kMaxToneHoles + 1> sized;
  double total = 0;
  for (std::size_t i = 0; i < heard; ++i) {
    sized[i] =
        scale * sources[i].flow *
        std::sqrt(std::max(sources[i].load, 0.0) * air.density * air.sound_speed / (4 * kPi));
    total += std::norm(sized[i]);
    for (std::size_t j = 0; j < i; ++j)
      total += 2 * spread(omega / air.sound_speed * std::abs(sources[i].place - sources[j].place)) *
               (sized[i] * std::conj(sized[j])).real();
  }
  return {reflected, std::sqrt(std::max(total, 0.0)) / radius};
}

} // namespace tactus::reed
