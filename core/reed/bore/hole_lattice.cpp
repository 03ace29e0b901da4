#include "core/reed/bore/hole_lattice.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/bore/radiation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;
constexpr double kSliceLength = 4e-3;   // m, of a cone
constexpr double kMinHoleRadius = 2e-4; // m, about the thickness of the boundary layers; a narrower
                                        // hole counts as closed

double square(double x) { return x * x; }

/// Transfer matrix of a lossy cylinder, from (p, U) at its end to (p, U) at its beginning.
struct Tube {
  Complex cosh, z_sinh, sinh_over_z; // cosh, Z sinh, sinh/Z

  Tube(Complex s, const Air& air, double radius, double length) {
    const double area = pi * square(radius);
    const Complex boundary_layer = 2.0 * math::sqrt(kKinematicViscosity / s) / radius;
    const double thermal_factor = (kHeatCapacityRatio - 1) / std::sqrt(kPrandtlNumber);
    const Complex series = s * air.density / area * (1.0 + boundary_layer);
    const Complex shunt = s * area / (air.density * square(air.sound_speed)) *
                          (1.0 + thermal_factor * boundary_layer);
    const Complex gamma = math::sqrt(series * shunt), z = series / gamma;
    const Complex exp_forward = math::exp(gamma * length), exp_backward = 1.0 / exp_forward;
    const Complex sinh = 0.5 * (exp_forward - exp_backward);
    cosh = 0.5 * (exp_forward + exp_backward);
    z_sinh = z * sinh;
    sinh_over_z = sinh / z;
  }
};

/// Impedance of an unflanged opening.
Complex opening(Complex s, const Air& air, double radius) {
  const Complex r = OpenEnd::reflection(s * radius / air.sound_speed);
  return air.density * air.sound_speed / (pi * square(radius)) * (1.0 + r) / (1.0 - r);
}

/// sin(x)/x
double sinc(double x) { return x < 1e-6 ? 1 : math::sin(x) / x; }

} // namespace

HoleLattice::HoleLattice(const Woodwind& instrument, std::span<const double> closed) noexcept
    : instrument_(instrument), key_(instrument.lowest_key),
      end_(instrument.position(instrument.lowest_key)) {
  start_ = end_;
  for (std::size_t i = 0; i < std::min(closed.size(), instrument.tone_holes()); ++i) {
    const Woodwind::Hole hole = instrument.tone_hole(i);
    const double radius = hole.radius * std::sqrt(std::clamp(1 - closed[i], 0.0, 1.0));
    if (radius < kMinHoleRadius)
      continue;
    if (count_ == 0) {
      key_ = instrument.key_of(i);
      start_ = hole.position;
    }
    const double bore = instrument.radius(hole.position), ratio = radius / bore;
    const double inner =
        radius * (0.82 + ratio * (-0.193 + ratio * (-1.09 + ratio * (1.27 - 0.71 * ratio))));
    const double matching = radius * ratio / 8 * (1 + 0.207 * ratio * ratio * ratio);
    const double series_length = -radius * square(ratio) /
                                 (1.78 / math::tanh(1.84 * hole.height / radius) + 0.940 +
                                  0.540 * ratio + 0.285 * square(ratio));
    open_holes_[count_++] = {hole.position, radius, hole.height + inner + matching, bore,
                             series_length};
  }
}

HoleLattice::PressureFlow HoleLattice::through_bore(Complex s, double from, double to,
                                                    PressureFlow far_end) const noexcept {
  const Air air = air_at(20);
  const int slices = instrument_.apex > 0
                         ? std::max(1, static_cast<int>(std::ceil((to - from) / kSliceLength)))
                         : 1;
  for (int i = slices; i-- > 0;) {
    const Tube tube(s, air, instrument_.radius(from + (i + 0.5) / slices * (to - from)),
                    (to - from) / slices);
    far_end = {tube.cosh * far_end.pressure + tube.z_sinh * far_end.flow,
               tube.sinh_over_z * far_end.pressure + tube.cosh * far_end.flow};
  }
  return far_end;
}

HoleLattice::PressureFlow HoleLattice::bell_state(Complex s, Source& source) const noexcept {
  const Air air = air_at(20);
  const double bore = instrument_.radius(end_);
  const auto& last =
      instrument_.bell[static_cast<std::size_t>(std::max(0, instrument_.bell_corners - 1))];
  const Complex mouth = opening(s, air, bore * last.ratio);
  PressureFlow state{mouth, 1.0};
  source = {end_ + last.distance, 1.0, mouth.real()};
  for (int k = instrument_.bell_corners - 1; k-- > 0;) {
    const auto& near = instrument_.bell[static_cast<std::size_t>(k)];
    const auto& far = instrument_.bell[static_cast<std::size_t>(k) + 1];
    const double length = far.distance - near.distance;
    const int slices = std::max(1, static_cast<int>(std::ceil(length / kSliceLength)));
    for (int i = slices; i-- > 0;) {
      const double ratio = near.ratio + (i + 0.5) / slices * (far.ratio - near.ratio);
      const Tube tube(s, air, bore * ratio, length / slices);
      state = {tube.cosh * state.pressure + tube.z_sinh * state.flow,
               tube.sinh_over_z * state.pressure + tube.cosh * state.flow};
    }
  }
  return state;
}

HoleLattice::PressureFlow HoleLattice::across_hole(Complex s, const OpenHole& hole,
                                                   PressureFlow state, Source& source) noexcept {
  const Air air = air_at(20);
  const Complex series_impedance =
      s * air.density * hole.series_length / (2 * pi * square(hole.bore));
  state.pressure += series_impedance * state.flow;
  const Complex load = opening(s, air, hole.radius);
  const Tube chimney(s, air, hole.radius, hole.height);
  const Complex out = state.pressure / (chimney.cosh * load + chimney.z_sinh);
  source = {hole.position, out, load.real()};
  state.flow += (chimney.sinh_over_z * load + chimney.cosh) * out;
  state.pressure += series_impedance * state.flow;
  return state;
}

/// The strength of a source is the root of its power, so that a wide opening radiates all it
/// receives.
double HoleLattice::radiated_pressure(double omega, Complex scale, const Sources& sources,
                                      std::size_t count) noexcept {
  const Air air = air_at(20);
  std::array<Complex, Woodwind::kMaxToneHoles + 1> amplitudes;
  double total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    amplitudes[i] =
        scale * sources[i].flow *
        std::sqrt(std::max(sources[i].resistance, 0.0) * air.density * air.sound_speed / (4 * pi));
    total += math::norm(amplitudes[i]);
    for (std::size_t j = 0; j < i; ++j)
      total += 2 *
               sinc(omega / air.sound_speed * std::abs(sources[i].position - sources[j].position)) *
               (amplitudes[i] * math::conj(amplitudes[j])).real();
  }
  return std::sqrt(std::max(total, 0.0));
}

HoleLattice::Response HoleLattice::at(double omega) const noexcept {
  const Air air = air_at(20);
  const Complex s(0, omega);
  Sources sources;
  std::size_t source_count = 0;
  PressureFlow state = bell_state(s, sources[source_count++]);
  double current_position = end_;
  for (std::size_t k = count_; k-- > 0;) {
    const OpenHole& hole = open_holes_[k];
    state = through_bore(s, hole.position, current_position, state);
    current_position = hole.position;
    state = across_hole(s, hole, state, sources[source_count++]);
  }

  const double radius = instrument_.radius(start_);
  const double characteristic_admittance = pi * square(radius) / (air.density * air.sound_speed);
  const Complex wavefront_curvature =
      instrument_.apex > 0 ? air.sound_speed / (s * start_) : Complex(0);
  const Complex admittance = state.flow / state.pressure / characteristic_admittance;
  const Complex reflected =
      (1.0 + wavefront_curvature - admittance) / (admittance + 1.0 - wavefront_curvature);
  const Complex scale = (1.0 + reflected) / state.pressure;
  return {reflected, radiated_pressure(omega, scale, sources, source_count) / radius};
}

} // namespace tactus::reed
