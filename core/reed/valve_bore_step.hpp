#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore_design.hpp"
#include "core/reed/valve_constants.hpp"

#include <array>

/// The inner step of the reed, written once for one reed and for several side by side: V is double,
/// or simd::Lanes<T, N, Set> for N reeds that share the instrument (ValveConstants, RoundTrip: the
/// same bore, so f_b is common) and differ in mouth pressure, reed frequency and state. A lane of
/// doubles gives the same bits as the reed alone: every decision is a select, and a branch only
/// skips work whose result no lane would take.
namespace tactus::reed {

/// What the reed frequency enters into; constant, or one for each internal sample while f_r moves.
template <class V> struct ReedCoefficients {
  V stiffness{0.0};       // k
  V mobility{0.0};        // 1/(2m/T + m w_r/Q + k T/2): mean velocity for each newton
  V swept_mobility{0.0};  // w lambda_b mobility, 0 without sweep
  V bore_mobility{0.0};   // w lambda_b mobility
  V port_impedance{0.0};  // Z = 1/(y_p + (w lambda_b)^2 mobility)

  static ReedCoefficients at(const ValveConstants& c, const V& omega) noexcept {
    ReedCoefficients r;
    r.stiffness = V(c.mass) * omega * omega;
    r.mobility =
        V(1.0) / (V(c.momentum) + V(c.damping) * omega + V(0.5 * c.period) * r.stiffness);
    r.swept_mobility = V(c.swept_area) * r.mobility;
    r.bore_mobility = V(c.bore_area) * r.mobility;
    r.port_impedance = V(1.0) / (V(c.port_admittance) + V(c.swept_area) * r.swept_mobility);
    return r;
  }
};

/// State of valve, jet and the lumped elements at the bore's input.
template <class V> struct ValveState {
  V deflection{0.0};    // x - x_0 along the valve's direction, m
  V velocity{0.0};      // m/s
  V jet_velocity{0.0};  // u, m/s
  V flow{0.0};          // U = A u, m^3/s
  V bore_pressure{0.0}; // p_b, Pa
  V inertance_flow{0.0};  // U_L of the cone
  V compliance_flow{0.0}; // U_C of the cup
};

/// Signals of one stretch of internal samples. Mouth pressure and noise go in.
template <class V> struct ValveSignals {
  const V* mouth_pressure;
  const double* noise;  // null, or a factor of the jet's dynamic pressure, common to all lanes
  const V* returning;   // p-: what the bore sends back
  V* outgoing;          // p+
  V* deflection;
  V* bore_pressure;
  V* flow;
};

/// Advances the valve by count internal samples. stride is 0 for constant coefficients, else 1.
///
/// Valve: implicit midpoint rule, exactly energy-conserving for the linear valve. Opening: averaged
/// over the straight path that the present velocity predicts for the step, so that closing and
/// crossing are not quantised to samples. Jet: backward Euler in u, in closed form together with
/// the port seen by the valve, p_b = h + Z A u:
///   (rho lambda/T + Z A) u + (rho/2) u|u| = p_m - h + (rho lambda/T) u_old.
/// A valve that meets its stop or limit is solved again as the rigid wall it then is.
template <bool swinging, bool paper, class V>
void step_valve(const ValveConstants& c, const ReedCoefficients<V>* coefficients, int stride,
                ValveState<V>& state, const ValveSignals<V>& signal, int count) noexcept {
  using simd::absolute, simd::any, simd::copy_sign, simd::select, simd::square_root;
  const V zero(0.0), one(1.0), half(0.5), two(2.0), tiny(1e-30);
  const V period(c.period), rate(1 / c.period), rest(c.rest_opening), width(c.width), leak(c.leak);
  const V lowest(c.lowest), highest(c.highest), inertia(c.inertia), momentum(c.momentum);
  const V mouth_area(c.mouth_area), flow_area(c.flow_area), half_density(0.5 * c.density);
  const V twice_density(2 * c.density), wave(c.wave_admittance), swept(c.swept_area);
  const V rigid_impedance(1 / c.port_admittance), restitution(c.restitution);
  const V inertance(c.inertance_rate), compliance(c.compliance_rate);
  const bool pushed_by_flow = c.flow_area > 0;
  const bool lumped = c.inertance_rate > 0 || c.compliance_rate > 0;

  V x = state.deflection, v = state.velocity, u = state.jet_velocity, flow = state.flow;
  V bore = state.bore_pressure, inertance_flow = state.inertance_flow;
  V compliance_flow = state.compliance_flow;
  // Current that the lumped elements' history drives into the port.
  V history = (compliance - inertance) * bore + compliance_flow - inertance_flow;

  for (int i = 0; i < count; ++i) {
    const ReedCoefficients<V>& r = coefficients[i * stride];
    V mouth = signal.mouth_pressure[i];
    if (signal.noise != nullptr)
      mouth += V(signal.noise[i]) * half_density * u * u;

    // Opening, and the side on which it lies, over the predicted path.
    const V travel = period * v, y = rest + x, next = y + travel;
    V opening, side(1.0);
    if constexpr (swinging) {
      const V size = absolute(y), next_size = absolute(next);
      opening = half * (size + next_size);
      side = copy_sign(one, y + next);
      const auto crossing = (y * next) < zero;
      if (any(crossing)) {
        const V distance = absolute(travel) + tiny;
        opening = select(crossing, (size * size + next_size * next_size) / (two * distance),
                         opening);
        side = select(crossing, (next_size - size) * copy_sign(one, travel) / distance, side);
      }
    } else {
      opening = half * (y + next);
      const auto closing = next < zero;
      if (any(closing))
        opening = select(closing, half * y * y / (y - next + tiny), opening);
    }
    const V area = width * opening + leak;

    // The port as a source: p_b = pressure_open + Z U.
    V force = momentum * v - r.stiffness * x + mouth_area * mouth;
    const V jet_pressure = mouth - half_density * u * u;
    if (pushed_by_flow)
      force += side * flow_area * jet_pressure;
    const V source = wave * signal.returning[i] + history;
    const V pressure_open = r.port_impedance * (source + r.swept_mobility * force);

    const auto solve_jet = [&](const V& impedance, const V& open) {
      if constexpr (paper) {
        // Equation (2) of the paper, explicit, with the last sample's bore pressure. Where the
        // explicit step would outrun the port, the channel counts as long as stability wants it.
        const V channel = simd::maximum(V(c.channel_length),
                                        impedance * area * V(c.period / c.density));
        const V drive = (mouth - bore) * area / (channel * V(c.density));
        const V loss = flow * absolute(flow) / (two * channel * area + absolute(flow) * period +
                                                tiny);
        return flow + period * (drive - loss);
      } else {
        const V resistance = inertia + impedance * area;
        const V drive = mouth - open + inertia * u;
        const V size = absolute(drive);
        return copy_sign(two * size /
                             (resistance + square_root(resistance * resistance +
                                                       twice_density * size) + tiny),
                         drive);
      }
    };
    const auto velocity_of = [&](const V& solved) {
      if constexpr (paper)
        return solved / (area + V(1e-9));
      else
        return solved;
    };
    const auto flow_of = [&](const V& solved) {
      if constexpr (paper)
        return solved;
      else
        return area * solved;
    };

    const V solved = solve_jet(r.port_impedance, pressure_open);
    V jet = velocity_of(solved), through = flow_of(solved);
    V pressure = pressure_open + r.port_impedance * through;
    V mean = r.mobility * force - r.bore_mobility * pressure;
    if (pushed_by_flow)
      mean += r.mobility * side * flow_area * (mouth - half_density * jet * jet - jet_pressure);

    V moved = x + period * mean, velocity = mean + mean - v;
    const auto above = moved > highest, below = moved < lowest;
    if (any(above | below)) {
      const auto held = above | below;
      const V wall = select(above, highest, lowest);
      const V contact = (wall - x) * rate;
      const V open = rigid_impedance * (source + swept * contact);
      const V again = solve_jet(rigid_impedance, open);
      jet = select(held, velocity_of(again), jet);
      through = select(held, flow_of(again), through);
      pressure = select(held, open + rigid_impedance * flow_of(again), pressure);
      const V rebound = restitution * (contact + contact - v);
      velocity = select(above, simd::minimum(rebound, zero),
                        select(below, simd::maximum(rebound, zero), velocity));
      moved = select(held, wall, moved);
    }
    x = moved;
    v = velocity;
    u = jet;
    flow = through;
    if (lumped) {
      inertance_flow += inertance * (pressure + bore);
      compliance_flow = compliance * (pressure - bore) - compliance_flow;
      history = (compliance - inertance) * pressure + compliance_flow - inertance_flow;
    }
    bore = pressure;
    signal.outgoing[i] = pressure - signal.returning[i];
    signal.deflection[i] = x;
    signal.bore_pressure[i] = pressure;
    signal.flow[i] = through;
  }
  state = {x, v, u, flow, bore, inertance_flow, compliance_flow};
}

/// Filters of the bore's round trip. Because the wave takes at least `delay` samples for it, a
/// stretch of that many samples can be filtered before the valve computes them.
template <class V> struct RoundTripFilter {
  std::array<V, RoundTrip::kSections> state{};

  /// From the delay line's output to what comes back (p-) and what the open end radiates
  /// (arriving + returning inverted: a - b), in place of the input.
  void run(const RoundTrip& trip, V* wave, V* radiated, int count) noexcept {
    std::array<V, RoundTrip::kSections> s = state, pole, excess;
    for (std::size_t k = 0; k < s.size(); ++k) {
      pole[k] = V(trip.pole[k]);
      excess[k] = V(trip.excess[k]);
    }
    const V arriving_gain(trip.arriving_gain), returning_gain(trip.returning_gain);
    for (int i = 0; i < count; ++i) {
      V signal = wave[i];
      const auto section = [&](std::size_t k) {
        const V out = signal + s[k];
        s[k] = pole[k] * s[k] + excess[k] * signal;
        signal = out;
      };
      for (std::size_t k = 0; k < RoundTrip::kLossSections; ++k)
        section(k);
      const V arriving = arriving_gain * signal;
      for (std::size_t k = RoundTrip::kLossSections; k < RoundTrip::kSections; ++k)
        section(k);
      wave[i] = returning_gain * signal;
      radiated[i] = arriving - wave[i];
    }
    state = s;
  }
};

} // namespace tactus::reed
