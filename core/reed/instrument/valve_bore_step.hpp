#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/valve_constants.hpp"

#include <array>
#include <cstdint>
#include <type_traits>

/// The time step of valve and jet: from mouth pressure and the wave p- out of the bore to the
/// valve's motion, the flow and the wave p+ into the bore. Equations: docs/theory/greed.md.
///
/// V is double for one reed, or simd::Lanes<T, N, Set> for N reeds that share ValveConstants and
/// bore (so f_b is common) and differ in mouth pressure, reed frequency and state. A lane of
/// doubles gives the same bits as a single reed: every decision is a select, and a branch only
/// skips work whose result no lane would take.
namespace tactus::reed {

/// Coefficients of one step that depend on the reed frequency: one set while f_r is constant, or
/// one per internal sample while it moves.
///
/// Y = 1/(2m/T + d + k T/2) is the valve's discrete mobility (m/s per N), Z = 1/(y_p +
/// (w lambda_b)^2 Y) the impedance of the bore's input with the valve in it (Pa s/m^3).
///
/// The midpoint rule warps a pole s to the frequency of (2/T) atanh(s T/2). Mass m and damping d
/// are therefore those of a valve with the poles s_d = (2/T) tanh(s T/2) = s - s^3 T^2/12 + ...,
///   m = k/|s_d|^2,   d = -2 m Re s_d,
/// at the same stiffness k. Static deflection, resonance and decay are then exact.
template <class V> struct ReedCoefficients {
  V stiffness{0.0};          // k
  V momentum{0.0};           // 2 m/T
  V port_impedance{0.0};     // Z
  V pressure_per_force{0.0}; // Z w lambda_b Y
  // Deflection in one sample per force on the valve, and (subtracted) per flow into the input.
  V deflection_per_force{0.0}; // T Y (1 - w lambda_b Z w lambda_b Y)
  V deflection_per_flow{0.0};  // T w lambda_b Y Z
  V velocity_per_flow{0.0};
  // R = rho lambda/(theta T) + Z A, with A as a linear function of the state.
  V resistance_at_rest{0.0};
  V resistance_per_deflection{0.0}; // Z w
  V resistance_per_velocity{0.0};   // Z w T/2
  V resistance_per_flow{0.0};       // subtracted: per flow of the sample before
  // The jet's driving pressure times 2 rho, as a linear function of the state.
  V drive_per_mouth_pressure{0.0}; // directly, minus the effect through the valve
  V drive_per_source{0.0};         // subtracted: per flow into the input
  V drive_per_bore_pressure{0.0};  // subtracted: per p_b of the sample before (cone and cup)
  V drive_per_deflection{0.0};     // k Z w lambda_b Y
  V drive_per_velocity{0.0};       // subtracted: 2m/T Z w lambda_b Y
  V drive_per_flow{0.0};           // subtracted: per flow of the sample before, through all these

  /// omega = 2 pi f_r, rad/s.
  static ReedCoefficients at(const ValveConstants& c, const V& omega) noexcept {
    ReedCoefficients r;
    r.stiffness = V(c.mass) * omega * omega;
    V mass(c.mass), damping = V(c.damping) * omega;
    if (!c.paper) {
      // (w T)^2, and the same times 1/4Q^2. The bounds keep the series positive out of its range.
      const V omega_t_squared = (V(c.period) * omega) * (V(c.period) * omega),
              decay = V(c.decay) * omega_t_squared;
      const V mass_factor = V(1.0) + (omega_t_squared - (decay + decay)) * V(1.0 / 6) +
                            omega_t_squared * omega_t_squared * V(17.0 / 720);
      const V damping_factor = V(1.0) + omega_t_squared * V(0.25) - decay * V(1.0 / 3);
      mass = mass / simd::maximum(mass_factor, V(0.5));
      damping = V(c.damping / c.mass) * omega * mass * simd::maximum(damping_factor, V(0.5));
    }
    r.momentum = V(2 * c.rate) * mass;
    const V mobility = V(1.0) / (r.momentum + damping + V(0.5 * c.period) * r.stiffness);
    const V swept_mobility = V(c.swept_area) * mobility;
    r.port_impedance = V(1.0) / (V(c.port_admittance) + V(c.swept_area) * swept_mobility);
    r.pressure_per_force = r.port_impedance * swept_mobility;
    r.deflection_per_force =
        V(c.period) * (mobility - V(c.bore_area) * mobility * r.pressure_per_force);
    r.deflection_per_flow = V(c.period * c.bore_area) * mobility * r.port_impedance;
    r.velocity_per_flow = V(2 * c.rate) * r.deflection_per_flow;
    r.resistance_at_rest = V(c.inertia) + r.port_impedance * V(c.width * c.rest_opening + c.leak);
    r.resistance_per_deflection = r.port_impedance * V(c.width);
    r.resistance_per_velocity = r.port_impedance * V(0.5 * c.width * c.period);
    r.resistance_per_flow = r.resistance_per_deflection * r.deflection_per_flow +
                            r.resistance_per_velocity * r.velocity_per_flow;
    const V twice_density(2 * c.density), drive_per_force = twice_density * r.pressure_per_force;
    r.drive_per_mouth_pressure = twice_density - drive_per_force * V(c.mouth_area);
    r.drive_per_source = twice_density * r.port_impedance;
    r.drive_per_bore_pressure = r.drive_per_source * V(2 * (c.compliance_rate - c.inertance_rate));
    r.drive_per_deflection = drive_per_force * r.stiffness;
    r.drive_per_velocity = drive_per_force * r.momentum;
    r.drive_per_flow = (r.drive_per_deflection * r.deflection_per_flow -
                        r.drive_per_velocity * r.velocity_per_flow) +
                       r.drive_per_bore_pressure * r.port_impedance;
    return r;
  }
};

/// State of valve, jet and the lumped elements at the bore's input.
///
/// Deflection, velocity and bore pressure are stored in two parts: base values and the linear
/// effect of the last flow on them. step_valve() gives the reason.
template <class V> struct ValveState {
  V jet{0.0};             // mean of u over the last sample, m/s
  V jet_history{0.0};     // (1 - 1/theta) u at that sample's beginning
  V flow{0.0};            // U = A u, mean over the last sample, m^3/s
  V inertance_flow{0.0};  // U_L of the cone
  V compliance_flow{0.0}; // U_C of the cup
  V port_history{0.0};    // flow of cone and cup into the input, minus 2 (2C/T - T/2M) p_b

  V base_deflection{0.0}, base_velocity{0.0}, base_pressure{0.0};
  V pending_flow{0.0}; // U, or 0 if the base values contain its effect
  V deflection_per_flow{0.0}, velocity_per_flow{0.0}, impedance{0.0}; // effect of U on the above
  V resistance_per_jet{0.0}, drive_per_jet{0.0};                      // effect of u on the next jet

  /// x - x_0 along the valve's direction, m.
  [[nodiscard, gnu::always_inline]] V deflection() const noexcept {
    return base_deflection - deflection_per_flow * pending_flow;
  }
  /// m/s
  [[nodiscard, gnu::always_inline]] V velocity() const noexcept {
    return base_velocity - velocity_per_flow * pending_flow;
  }
  /// p_b, Pa
  [[nodiscard, gnu::always_inline]] V bore_pressure() const noexcept {
    return base_pressure + impedance * pending_flow;
  }
  /// u now, m/s.
  [[nodiscard, gnu::always_inline]] V jet_velocity(const ValveConstants& c) const noexcept {
    return jet_history + V(c.jet_gain) * jet;
  }
  /// Sets deflection (m) and velocity (m/s) of the valve; the air keeps its state.
  void move(const V& deflection, const V& velocity) noexcept {
    base_pressure = bore_pressure();
    base_deflection = deflection;
    base_velocity = velocity;
    pending_flow = resistance_per_jet = drive_per_jet = V(0.0);
  }
  void update_port_history(const ValveConstants& c) noexcept {
    port_history = compliance_flow - inertance_flow -
                   V(c.compliance_rate - c.inertance_rate) * bore_pressure();
  }
};

/// Signals of a block of internal samples. Mouth pressure, noise and wave are inputs; wave and all
/// others are outputs.
template <class V> struct ValveSignals {
  const V* mouth_pressure;
  const double* noise; // null, or a factor of the jet's dynamic pressure, common to all lanes
  V* wave;             // in: p- from the bore, Pa; out: p+ into the bore
  V* angle;            // theta, rad
  V* bore_pressure;
  V* flow;
};

/// The jet velocity u (m/s) that solves R u + (rho/2) u|u| = drive/(2 rho): unique, also for a shut
/// valve. Cancellation in root - R costs an absolute error of some 1e-14 m/s in double, 300 dB
/// below a sounding jet; the form without cancellation would take a tenth more time.
template <class V>
[[nodiscard, gnu::always_inline]] inline V jet_velocity(const V& resistance, const V& drive,
                                                        const V& specific_volume) noexcept {
  const V root = simd::square_root(resistance * resistance + simd::absolute(drive));
  return (root - resistance) * simd::copy_sign(specific_volume, drive);
}

/// Equation (2) of Smyth, Smyth & Kirkpatrick, explicit, with the bore pressure of the sample
/// before:
///   U' = dp A/(lambda rho) - U|U|/(2 lambda A + |U| T).
/// Where the formula would be unstable (Z A T/rho > lambda), lambda is raised to that limit.
template <class V>
[[nodiscard, gnu::always_inline]] inline V
explicit_flow(const ValveConstants& c, const V& impedance, const V& area, const V& pressure_drop,
              const V& flow) noexcept {
  const V channel = simd::maximum(V(c.channel_length), impedance * area * V(c.period / c.density));
  const V size = simd::absolute(flow);
  const V loss = flow * size / (V(2.0) * channel * area + size * V(c.period) + V(1e-30));
  return flow + V(c.period) * (pressure_drop * area / (channel * V(c.density)) - loss);
}

/// Advances the valve by count internal samples. stride is 0 for constant coefficients, else 1.
/// plain: constant coefficients, no noise and ValveConstants::plain_port().
///
/// The scheme is of second order in T.
/// - Valve: implicit midpoint rule with exact poles (ReedCoefficients). It conserves the energy of
///   the linear valve.
/// - Opening A: the mean over the straight path that the present velocity predicts, so that closing
///   and crossing are not quantised to samples. (The error of the path, T^2 x''/6, and that of the
///   midpoint rule nearly cancel.)
/// - Jet: theta rule, u = theta u_new + (1 - theta) u_old, solved in closed form together with the
///   bore's input as the valve sees it, p_b = h + Z A u:
///     (rho lambda/(theta T) + Z A) u + (rho/2) u|u| = p_m - h + (rho lambda/(theta T)) u_old.
///   theta = 1/2 except for very short channels (ValveConstants).
/// - A valve that passes its stop or limit is held there, and the jet is solved again with a rigid
///   wall.
///
/// Speed is limited by the dependency chain jet, square root, valve, next jet. Deflection, velocity
/// and pressure after a sample are linear in its flow U = A u. R and the drive of the next jet are
/// therefore linear in u, and their coefficients are computed while the square root is still in
/// progress. Likewise the set of valves at a stop is assumed to be that of the sample before, until
/// a comparison outside the chain finds it changed.
///
/// One function, because the intermediate values fill the registers and this loop takes over half
/// of the time of an instrument.
template <bool swinging, bool paper, bool plain, class V>
[[gnu::noinline, gnu::flatten]] void
step_valve(const ValveConstants& c, const ReedCoefficients<V>* coefficients, int stride,
           ValveState<V>& state, const ValveSignals<V>& signal, int count) noexcept {
  using simd::absolute, simd::any, simd::copy_sign, simd::select;
  const V zero(0.0), one(1.0), half(0.5), tiny(1e-30);
  const V period(c.period), rate(c.rate), two_over_period(2 * c.rate);
  const V rest_opening(c.rest_opening), width(c.width), leak(c.leak), inertia(c.inertia);
  const V rest_area(c.width * c.rest_opening + c.leak);
  const V area_per_velocity(0.5 * c.width * c.period);
  const V jet_gain(c.jet_gain), jet_history_gain(1 - c.jet_gain);
  const V lowest(c.lowest), highest(c.highest);
  const V mouth_area(c.mouth_area), half_density(0.5 * c.density);
  const V twice_density(2 * c.density), specific_volume(c.specific_volume), wave(c.wave_admittance),
      swept(c.swept_area);
  const V inertial_drive_per_jet(2 * c.density * c.inertia);
  const V rigid_impedance(c.rigid_impedance), restitution(c.restitution);
  const V angle_scale(c.angle_scale);
  const V inertance(c.inertance_rate), compliance(c.compliance_rate);
  const V echo(2 * (c.compliance_rate - c.inertance_rate));
  const V history_admittance(c.compliance_rate + c.inertance_rate);
  const bool has_flow_force = !plain && c.flow_area > 0, moving = !plain && stride > 0;
  const bool lumped = !plain && (c.inertance_rate > 0 || c.compliance_rate > 0);
  const bool noisy = !plain && signal.noise != nullptr;

  ValveState<V> now = state; // a copy that stays in registers
  typename simd::LaneTraits<V>::MaskType at_stop{},
      at_limit{};               // lanes below the stop, and above the limit
  std::uint64_t limit_bits = 0; // the same as bits; 0: none

  for (int i = 0; i < count; ++i) {
    const ReedCoefficients<V>& r = coefficients[plain ? 0 : i * stride];
    const V u = now.jet_velocity(c), x = now.deflection(), v = now.velocity();
    const V bore = now.bore_pressure();
    const V incoming = signal.wave[i];
    V mouth = signal.mouth_pressure[i];
    if (noisy)
      mouth += V(signal.noise[i]) * half_density * u * u;
    const V driving_flow = wave * incoming + now.port_history;

    // Opening A and R over the predicted path, and the side it lies on.
    const V predicted_travel = period * v, y = rest_opening + x, next = y + predicted_travel;
    V side(1.0), area, resistance;
    bool striking = false;
    if constexpr (swinging) {
      const V size = absolute(y), next_size = absolute(next);
      V opening = half * (size + next_size);
      side = copy_sign(one, y + next);
      const auto crossing = (y * next) < zero;
      if (any(crossing)) {
        const V distance = absolute(predicted_travel) + tiny;
        opening =
            select(crossing, half * (size * size + next_size * next_size) / distance, opening);
        side = select(crossing, (y + next) / distance, side); // (|y'| - |y|)/(y' - y)
      }
      area = width * opening + leak;
      resistance = inertia + r.port_impedance * area;
    } else {
      area = (rest_area + width * x) + area_per_velocity * v;
      resistance = (r.resistance_at_rest + (r.resistance_per_deflection * now.base_deflection +
                                            r.resistance_per_velocity * now.base_velocity)) -
                   now.resistance_per_jet * now.jet;
      const auto closing = next < zero;
      if (any(closing)) {
        striking = true;
        area = select(closing, width * (half * y * y / (tiny - predicted_travel)) + leak, area);
        resistance = select(closing, inertia + r.port_impedance * area, resistance);
      }
      if (moving)
        resistance = inertia + r.port_impedance * area;
    }
    // 2 rho (p_m - h + (rho lambda/(theta T)) u)
    V known_drive = r.drive_per_mouth_pressure * mouth - r.drive_per_source * driving_flow;
    V drive;
    if (moving) {
      drive = (known_drive + inertial_drive_per_jet * u) +
              ((r.drive_per_deflection * x - r.drive_per_velocity * v) -
               r.drive_per_bore_pressure * bore);
    } else {
      if (lumped)
        known_drive -= r.drive_per_bore_pressure * now.base_pressure;
      drive = ((known_drive + inertial_drive_per_jet * now.jet_history) +
               (r.drive_per_deflection * now.base_deflection -
                r.drive_per_velocity * now.base_velocity)) +
              (inertial_drive_per_jet * jet_gain - now.drive_per_jet) * now.jet;
    }
    V mouth_force = mouth_area * mouth, flow_force_area = zero,
      predicted_jet = zero; // the jet in the middle of the step
    if (has_flow_force) {
      flow_force_area = side * V(c.flow_area);
      predicted_jet = c.paper ? u : u + half * (u - now.jet);
      const V bernoulli_force =
          flow_force_area * (mouth - (half_density * predicted_jet) * predicted_jet);
      mouth_force += bernoulli_force;
      drive -= (twice_density * r.pressure_per_force) * bernoulli_force;
    }

    const V source = lumped ? driving_flow + echo * bore : driving_flow;
    V jet, volume_flow;
    if constexpr (paper) {
      volume_flow = explicit_flow(c, r.port_impedance, area, mouth - bore, now.flow);
      jet = volume_flow / (area + V(1e-9));
    } else {
      jet = jet_velocity(resistance, drive, specific_volume);
    }

    const V force = (r.momentum * v - r.stiffness * x) + mouth_force;
    const V deflection_step = r.deflection_per_force * force - r.deflection_per_flow * source;
    now.deflection_per_flow = r.deflection_per_flow;
    now.velocity_per_flow = r.velocity_per_flow;
    now.impedance = r.port_impedance;
    now.base_deflection = x + deflection_step;
    now.base_velocity = two_over_period * deflection_step - v;
    now.base_pressure = r.port_impedance * source + r.pressure_per_force * force;
    now.resistance_per_jet = r.resistance_per_flow * area;
    now.drive_per_jet = r.drive_per_flow * area;
    if constexpr (!paper)
      volume_flow = area * jet;
    if (has_flow_force) {
      const V force_correction =
          half_density * flow_force_area * (predicted_jet * predicted_jet - jet * jet); // newtons
      now.base_deflection += r.deflection_per_force * force_correction;
      now.base_velocity += two_over_period * r.deflection_per_force * force_correction;
      now.base_pressure += r.pressure_per_force * force_correction;
    }
    now.pending_flow = volume_flow;
    const auto apply_limit = [&](const auto& beyond, const V& wall, auto allowed_velocity) {
      const V contact = (wall - x) * rate;
      const V limited_pressure = rigid_impedance * (source + swept * contact);
      V limited_jet, limited_flow;
      if constexpr (paper) {
        limited_flow = explicit_flow(c, rigid_impedance, area, mouth - bore, now.flow);
        limited_jet = limited_flow / (area + V(1e-9));
      } else {
        limited_jet = jet_velocity(inertia + rigid_impedance * area,
                                   twice_density * ((mouth - limited_pressure) + inertia * u),
                                   specific_volume);
        limited_flow = area * limited_jet;
      }
      jet = select(beyond, limited_jet, jet);
      volume_flow = select(beyond, limited_flow, volume_flow);
      now.base_deflection = select(beyond, wall, now.base_deflection);
      now.base_velocity = select(beyond, allowed_velocity(restitution * (contact + contact - v)),
                                 now.base_velocity);
      now.base_pressure =
          select(beyond, limited_pressure + rigid_impedance * limited_flow, now.base_pressure);
      now.pending_flow = select(beyond, zero, now.pending_flow);
      now.resistance_per_jet = select(beyond, zero, now.resistance_per_jet);
      now.drive_per_jet = select(beyond, zero, now.drive_per_jet);
    };
    const V moved = now.deflection();
    const auto below = moved < lowest;
    const auto above = moved > highest;
    const std::uint64_t beyond = simd::bits(below) | std::uint64_t{simd::bits(above)} << 32;
    if (striking || beyond != limit_bits) {
      at_stop = below;
      at_limit = above;
      limit_bits = beyond;
      asm volatile(""); // keeps this a branch: masked moves would lengthen the dependency chain
    }
    if (limit_bits != 0) {
      const auto opening_only = [&](const V& rebound) { return simd::maximum(rebound, zero); };
      const auto closing_only = [&](const V& rebound) { return simd::minimum(rebound, zero); };
      if constexpr (std::is_same_v<V, double>) { // one valve: no masks
        at_stop ? apply_limit(true, lowest, opening_only)
                : apply_limit(true, highest, closing_only);
      } else {
        apply_limit(at_stop, lowest, opening_only);
        if (limit_bits >> 32 != 0)
          apply_limit(at_limit, highest, closing_only);
      }
    }

    const V next_bore = now.bore_pressure();
    if (lumped) {
      now.port_history = -(now.compliance_flow + now.inertance_flow + history_admittance * bore);
      now.inertance_flow += inertance * (next_bore + bore);
      now.compliance_flow = compliance * (next_bore - bore) - now.compliance_flow;
    }
    now.jet_history = jet_history_gain * u;
    now.jet = jet;
    now.flow = volume_flow;
    signal.wave[i] = next_bore - incoming;
    signal.angle[i] = (now.deflection() + rest_opening) * angle_scale;
    signal.bore_pressure[i] = next_bore;
    signal.flow[i] = volume_flow;
  }
  state = now;
}

} // namespace tactus::reed
