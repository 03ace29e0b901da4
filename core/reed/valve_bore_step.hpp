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
  V stiffness{0.0};      // k
  V mobility{0.0};       // Y = 1/(2m/T + m w_r/Q + k T/2): mean velocity for each newton
  V bore_mobility{0.0};  // w lambda_b Y
  V swept_mobility{0.0}; // the same, 0 without sweep
  V port_impedance{0.0}; // Z = 1/(y_p + (w lambda_b)^2 Y)
  // Products for the shortest way from one sample's jet to the next one's.
  V swept_pressure{0.0};       // Z w lambda_b Y: bore pressure for each newton on the valve
  V pressure_by_place{0.0};    // its share by the displacement, k Z w lambda_b Y
  V pressure_by_motion{0.0};   // and by the velocity, 2m/T Z w lambda_b Y
  V resistance_at_rest{0.0};   // rho lambda/T + Z A at rest
  V resistance_by_place{0.0};  // Z w
  V resistance_by_motion{0.0}; // Z w T/2

  static ReedCoefficients at(const ValveConstants& c, const V& omega) noexcept {
    ReedCoefficients r;
    r.stiffness = V(c.mass) * omega * omega;
    r.mobility = V(1.0) / (V(c.momentum) + V(c.damping) * omega + V(0.5 * c.period) * r.stiffness);
    r.bore_mobility = V(c.bore_area) * r.mobility;
    r.swept_mobility = V(c.swept_area) * r.mobility;
    r.port_impedance = V(1.0) / (V(c.port_admittance) + V(c.swept_area) * r.swept_mobility);
    r.swept_pressure = r.port_impedance * r.swept_mobility;
    r.pressure_by_place = r.swept_pressure * r.stiffness;
    r.pressure_by_motion = r.swept_pressure * V(c.momentum);
    r.resistance_at_rest = V(c.inertia) + r.port_impedance * V(c.width * c.rest_opening + c.leak);
    r.resistance_by_place = r.port_impedance * V(c.width);
    r.resistance_by_motion = r.port_impedance * V(0.5 * c.width * c.period);
    return r;
  }
};

/// State of valve, jet and the lumped elements at the bore's input.
template <class V> struct ValveState {
  V deflection{0.0};      // x - x_0 along the valve's direction, m
  V velocity{0.0};        // m/s
  V jet_velocity{0.0};    // u, m/s
  V flow{0.0};            // U = A u, m^3/s
  V bore_pressure{0.0};   // p_b, Pa
  V inertance_flow{0.0};  // U_L of the cone
  V compliance_flow{0.0}; // U_C of the cup
  V past{0.0};            // what cone and cup drive into the port, less 2 (2C/T - T/2M) p_b

  void remember(const ValveConstants& c) noexcept {
    past =
        compliance_flow - inertance_flow - V(c.compliance_rate - c.inertance_rate) * bore_pressure;
  }
};

/// Signals of one stretch of internal samples. Mouth pressure and noise go in.
template <class V> struct ValveSignals {
  const V* mouth_pressure;
  const double* noise; // null, or a factor of the jet's dynamic pressure, common to all lanes
  V* wave;             // in: p-, what the bore sends back; out: p+
  V* deflection;
  V* bore_pressure;
  V* flow;
};

/// Root of (resistance) u + (rho/2) u|u| = drive: unique, and defined for a shut valve. The
/// difference of root and resistance costs an absolute error of some 1e-14 m/s in double, 300 dB
/// below a sounding jet; the quotient without cancellation would cost a tenth more time.
template <class V>
[[nodiscard, gnu::always_inline]] inline V jet_velocity(const V& resistance, const V& drive,
                                                        const V& twice_density,
                                                        const V& specific_volume) noexcept {
  const V root = simd::square_root(resistance * resistance + twice_density * simd::absolute(drive));
  return (root - resistance) * simd::copy_sign(specific_volume, drive);
}

/// The paper's equation (2), explicit, with the bore pressure of the sample before:
///   U' = dp A/(lambda rho) - U|U|/(2 lambda A + |U| T).
/// Where one step would outrun the port (Z A T/rho > lambda), lambda counts as long as stability
/// wants it.
template <class V>
[[nodiscard, gnu::always_inline]] inline V explicit_flow(const ValveConstants& c,
                                                         const V& impedance, const V& area,
                                                         const V& drop, const V& flow) noexcept {
  const V channel = simd::maximum(V(c.channel_length), impedance * area * V(c.period / c.density));
  const V size = simd::absolute(flow);
  const V loss = flow * size / (V(2.0) * channel * area + size * V(c.period) + V(1e-30));
  return flow + V(c.period) * (drop * area / (channel * V(c.density)) - loss);
}

/// Advances the valve by count internal samples. stride is 0 for constant coefficients, else 1.
///
/// Valve: implicit midpoint rule, exactly energy-conserving for the linear valve. Opening: averaged
/// over the straight path that the present velocity predicts for the step, so that closing and
/// crossing are not quantised to samples. Jet: backward Euler in u, in closed form together with
/// the port seen by the valve, p_b = h + Z A u:
///   (rho lambda/T + Z A) u + (rho/2) u|u| = p_m - h + (rho lambda/T) u_old.
/// A valve that meets its stop or limit is solved again as the rigid wall it then is.
///
/// The loop is bound by the way from one u over square root and valve to the next u: the sums on it
/// are written with what is known early in front.
template <bool swinging, bool paper, class V>
void step_valve(const ValveConstants& c, const ReedCoefficients<V>* coefficients, int stride,
                ValveState<V>& state, const ValveSignals<V>& signal, int count) noexcept {
  using simd::absolute, simd::any, simd::copy_sign, simd::select, simd::square_root;
  const V zero(0.0), one(1.0), half(0.5), tiny(1e-30);
  const V period(c.period), rate(1 / c.period);
  const V rest(c.rest_opening), width(c.width), leak(c.leak), inertia(c.inertia);
  const V rest_area(c.width * c.rest_opening + c.leak), area_by_motion(0.5 * c.width * c.period);
  const V lowest(c.lowest), highest(c.highest), momentum(c.momentum);
  const V mouth_area(c.mouth_area), flow_area(c.flow_area), half_density(0.5 * c.density);
  const V twice_density(2 * c.density), specific_volume(1 / c.density), wave(c.wave_admittance),
      swept(c.swept_area);
  const V rigid_impedance(1 / c.port_admittance), restitution(c.restitution);
  const V inertance(c.inertance_rate), compliance(c.compliance_rate);
  const V echo(2 * (c.compliance_rate - c.inertance_rate));
  const V memory(c.compliance_rate + c.inertance_rate);
  const bool pushed_by_flow = c.flow_area > 0;

  V x = state.deflection, v = state.velocity, u = state.jet_velocity, flow = state.flow;
  V bore = state.bore_pressure, inertance_flow = state.inertance_flow;
  V compliance_flow = state.compliance_flow;
  V past = state.past;

  for (int i = 0; i < count; ++i) {
    const ReedCoefficients<V>& r = coefficients[i * stride];
    const V returning = signal.wave[i];
    V mouth = signal.mouth_pressure[i];
    if (signal.noise != nullptr)
      mouth += V(signal.noise[i]) * half_density * u * u;

    // Opening A and rho lambda/T + Z A over the predicted path, and the side it lies on.
    const V travel = period * v, y = rest + x, next = y + travel;
    V side(1.0), area, resistance;
    if constexpr (swinging) {
      const V size = absolute(y), next_size = absolute(next);
      V opening = half * (size + next_size);
      side = copy_sign(one, y + next);
      const auto crossing = (y * next) < zero;
      if (any(crossing)) {
        const V distance = absolute(travel) + tiny;
        opening =
            select(crossing, half * (size * size + next_size * next_size) / distance, opening);
        side = select(crossing, (next_size - size) * copy_sign(one, travel) / distance, side);
      }
      area = width * opening + leak;
      resistance = inertia + r.port_impedance * area;
    } else {
      area = (rest_area + width * x) + area_by_motion * v;
      resistance = r.resistance_at_rest + (r.resistance_by_place * x + r.resistance_by_motion * v);
      const auto closing = next < zero;
      if (any(closing)) {
        area = select(closing, width * (half * y * y / (y - next + tiny)) + leak, area);
        resistance = select(closing, inertia + r.port_impedance * area, resistance);
      }
    }

    // The port as a source: p_b = open + Z U, open = Z (source + w lambda_b Y force).
    V push = mouth_area * mouth, lift = zero;
    if (pushed_by_flow) {
      lift = side * flow_area;
      push += lift * (mouth - (half_density * u) * u);
    }
    const V given = wave * returning + past;
    const V source = given + echo * bore;
    const V force = (momentum * v - r.stiffness * x) + push;
    const V open = r.port_impedance * source + r.swept_pressure * force;

    // U = scale * solved: what depends on the scale is known before the jet is.
    V solved, scale, jet;
    if constexpr (paper) {
      solved = explicit_flow(c, r.port_impedance, area, mouth - bore, flow);
      scale = one;
      jet = solved / (area + V(1e-9));
    } else {
      const V known = (mouth - r.port_impedance * given) - r.swept_pressure * push;
      const V drive = ((known + inertia * u) - (r.port_impedance * echo) * bore) +
                      (r.pressure_by_place * x - r.pressure_by_motion * v);
      jet = solved = jet_velocity(resistance, drive, twice_density, specific_volume);
      scale = area;
    }
    V through = scale * solved;
    const V impedance = r.port_impedance * scale;
    V pressure = open + impedance * solved;
    // Mean velocity of the step: without the new jet, and for each m/s of it.
    V still = r.mobility * force - r.bore_mobility * open;
    const V brake = r.bore_mobility * impedance;
    if (pushed_by_flow) {
      const V kinetic = (r.mobility * half_density) * lift;
      still += (kinetic * u) * u - (kinetic * jet) * jet;
    }
    const V moved = (x + period * still) - (period * brake) * solved;
    V next_x = moved, next_v = (still + still - v) - (brake + brake) * solved;
    const auto hold = [&](const auto& beyond, const V& wall, auto inward) {
      const V contact = (wall - x) * rate;
      const V held_open = rigid_impedance * (source + swept * contact);
      V held_jet, held_through;
      if constexpr (paper) {
        held_through = explicit_flow(c, rigid_impedance, area, mouth - bore, flow);
        held_jet = held_through / (area + V(1e-9));
      } else {
        held_jet = jet_velocity(inertia + rigid_impedance * area, (mouth - held_open) + inertia * u,
                                twice_density, specific_volume);
        held_through = area * held_jet;
      }
      jet = select(beyond, held_jet, jet);
      through = select(beyond, held_through, through);
      pressure = select(beyond, held_open + rigid_impedance * held_through, pressure);
      next_x = select(beyond, wall, next_x);
      next_v = select(beyond, inward(restitution * (contact + contact - v)), next_v);
    };
    const auto above = moved > highest, below = moved < lowest;
    if (any(below))
      hold(below, lowest, [&](const V& rebound) { return simd::maximum(rebound, zero); });
    if (any(above))
      hold(above, highest, [&](const V& rebound) { return simd::minimum(rebound, zero); });

    x = next_x;
    v = next_v;
    u = jet;
    flow = through;
    past = -(compliance_flow + inertance_flow + memory * bore);
    inertance_flow += inertance * (pressure + bore);
    compliance_flow = compliance * (pressure - bore) - compliance_flow;
    bore = pressure;
    signal.wave[i] = pressure - returning;
    signal.deflection[i] = x;
    signal.bore_pressure[i] = pressure;
    signal.flow[i] = through;
  }
  state = {x, v, u, flow, bore, inertance_flow, compliance_flow, past};
}

/// Filters of the bore's round trip. Because the wave takes at least `delay` samples for it, a
/// stretch of that many samples can be filtered before the valve computes them.
template <class V> struct RoundTripFilter {
  std::array<V, RoundTrip::kSections> state{};

  /// From the delay line's output to what comes back (p-, in place of the input) and what reaches
  /// the open end and leaves it: a - returning_share * b.
  void run(const RoundTrip& trip, V* wave, V* leaving, double returning_share,
           int count) noexcept {
    std::array<V, RoundTrip::kSections> s = state, pole, excess;
    for (std::size_t k = 0; k < s.size(); ++k) {
      pole[k] = V(trip.pole[k]);
      excess[k] = V(trip.excess[k]);
    }
    const V arriving_gain(trip.arriving_gain), returning_gain(trip.returning_gain);
    const V share(returning_share);
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
      leaving[i] = arriving - share * wave[i];
    }
    state = s;
  }
};

} // namespace tactus::reed
