#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/valve_bore_step.hpp"
#include "core/reed/instrument/valve_constants.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

namespace tactus::reed {

/// The valve of a ReedBank over time: its state, and its constants while reed frequency and lips
/// move.
///
/// Within a control period omega_r runs linearly from sample to sample. When mass, opening or other
/// constants move too, all of them are interpolated in kSubsteps steps per control period, each
/// with the values at its middle. V is double or simd::Lanes, as in valve_bore_step.hpp.
template <class V, int max_count> class MovingValve {
public:
  [[nodiscard]] const ValveState<V>& state() const noexcept { return state_; }
  [[nodiscard]] const ValveConstants& constants() const noexcept { return constants_; }
  /// omega_r at the end of this control period, rad/s.
  [[nodiscard]] const V& omega() const noexcept { return omega_to_; }

  /// Sets deflection, velocity and all flows to 0.
  void reset() noexcept { state_ = {}; }
  /// Sets whether nothing sounds. Lips that move in silence carry the valve along without moving
  /// air.
  void rest(bool still) noexcept { still_ = still; }
  /// Sets pressures and flows to 0; the valve keeps deflection and velocity.
  void clear_air() noexcept {
    const V deflection = state_.deflection(), velocity = state_.velocity();
    state_ = {};
    state_.move(deflection, velocity);
  }
  /// Calls change(V&) for each number of the state that decays.
  template <class Change> void each(Change change) noexcept {
    for (V* value : {&state_.jet, &state_.jet_history, &state_.flow, &state_.inertance_flow,
                     &state_.compliance_flow, &state_.port_history, &state_.base_deflection,
                     &state_.base_velocity, &state_.base_pressure, &state_.pending_flow})
      change(*value);
  }
  /// False when bore pressure, jet flow or valve velocity is NaN or above 1e9, 1e6, 1e9 in any
  /// lane.
  [[nodiscard]] bool is_bounded() const noexcept {
    const auto beyond = [](const V& value, double limit) {
      return simd::any(!(simd::absolute(value) < V(limit)));
    };
    return !beyond(state_.bore_pressure(), 1e9) && !beyond(state_.jet, 1e6) &&
           !beyond(state_.velocity(), 1e9);
  }

  /// Takes these constants at once. The valve keeps its position, within the new stops; at_rest: it
  /// starts at rest.
  void jump_to(const ValveConstants& constants, bool at_rest) noexcept {
    const ValveConstants old = constants_;
    from_ = to_ = constants_ = constants;
    coefficients_due_ = true;
    reposition(old, at_rest);
  }
  /// As jump_to(), and also ends a movement and takes over the coefficients of the present
  /// frequency.
  void restart_at(const ValveConstants& constants, bool at_rest) noexcept {
    jump_to(constants, at_rest);
    constants_move_ = false;
    steady_coefficients_ = ReedCoefficients<V>::at(constants_, omega_to_);
  }
  /// Reaches these constants within the control period that begins now.
  void move_to(const ValveConstants& constants) noexcept {
    from_ = constants_;
    to_ = constants;
    constants_move_ = coefficients_due_ = true;
  }
  /// To be called at the end of a control period: completes move_to().
  void end_period(bool at_rest) noexcept {
    if (!constants_move_)
      return;
    constants_move_ = false;
    coefficients_due_ = true;
    const ValveConstants old = constants_;
    from_ = constants_ = to_;
    reposition(old, at_rest);
  }
  /// omega_r at the beginning and at the end of the control period that begins now. with_constants:
  /// it moves in substeps, as the constants do; starting: nothing was computed before.
  void set_omega(const V& from, const V& to, bool with_constants, bool starting) noexcept {
    omega_from_ = from;
    omega_to_ = to;
    const bool moving = simd::any((omega_from_ < omega_to_) | (omega_to_ < omega_from_));
    const bool moved = omega_moves_;
    omega_moves_ = moving && !with_constants && !constants_move_;
    constants_move_ = constants_move_ || (moving && with_constants);
    if (!omega_moves_ && !constants_move_ && (moved || coefficients_due_ || starting)) {
      steady_coefficients_ = ReedCoefficients<V>::at(constants_, omega_to_);
      coefficients_due_ = false;
    }
  }

  /// Advances count internal samples. `phase` internal samples of this control period, which has
  /// kControlPeriod * oversampling, have passed.
  void run(const ValveSignals<V>& signal, int phase, int count, int oversampling) noexcept {
    const auto period = static_cast<double>(kControlPeriod * oversampling);
    if (omega_moves_)
      for (int i = 0; i < count; ++i)
        moving_coefficients_[static_cast<std::size_t>(i)] = ReedCoefficients<V>::at(
            constants_, omega_from_ + V((phase + i + 1) / period) * (omega_to_ - omega_from_));
    const int substep_size = constants_move_ ? kControlPeriod / kSubsteps * oversampling : count;
    for (int i = 0; i < count;) {
      const int offset = constants_move_ ? (phase + i) % substep_size : 0;
      if (constants_move_ && offset == 0)
        begin_substep((phase + i) / substep_size);
      const int size = std::min(count - i, substep_size - offset);
      step({signal.mouth_pressure + i, signal.noise != nullptr ? signal.noise + i : nullptr,
            signal.wave + i, signal.angle + i, signal.bore_pressure + i, signal.flow + i},
           size);
      i += size;
    }
  }

private:
  static constexpr int kSubsteps = 4; // substeps of the constants, in a control period

  /// Keeps the position that the valve had under the constants `old`, limited by the new stops and
  /// by the new side.
  void reposition(const ValveConstants& old, bool at_rest) noexcept {
    if (at_rest) {
      state_ = {};
      return;
    }
    const double turn = old.direction * constants_.direction;
    const V target =
        still_ ? V(turn) * state_.deflection()
               : V(turn) * (state_.deflection() + V(old.rest_opening)) - V(constants_.rest_opening);
    const V low(constants_.lowest), high(constants_.highest);
    state_.move(
        simd::minimum(simd::maximum(target, low), high),
        simd::select((target < low) | (target > high), V(0.0), V(turn) * state_.velocity()));
    // The flow through an inertance is kept; the flow into a compliance C is C dp/dt, so it scales
    // with C.
    if (!(constants_.inertance_rate > 0) || !(old.inertance_rate > 0))
      state_.inertance_flow = V(0.0);
    if (constants_.compliance_rate != old.compliance_rate)
      state_.compliance_flow =
          old.compliance_rate > 0
              ? state_.compliance_flow * V(constants_.compliance_rate / old.compliance_rate)
              : V(0.0);
    state_.update_port_history(constants_);
  }

  /// The constants in the middle of one of the kSubsteps parts of the control period.
  void begin_substep(int step) noexcept {
    const double share = (step + 0.5) / kSubsteps;
    const ValveConstants old = constants_;
    constants_ = ValveConstants::interpolate(from_, to_, share);
    if (constants_.rest_opening != old.rest_opening || constants_.lowest != old.lowest ||
        constants_.highest != old.highest || constants_.inertance_rate != old.inertance_rate ||
        constants_.compliance_rate != old.compliance_rate)
      reposition(old, false);
    steady_coefficients_ =
        ReedCoefficients<V>::at(constants_, omega_from_ + V(share) * (omega_to_ - omega_from_));
  }

  /// Calls step_valve() in the version for this kind of valve.
  void step(const ValveSignals<V>& signal, int count) noexcept {
    using Yes = std::true_type;
    using No = std::false_type;
    const ReedCoefficients<V>* coefficients =
        omega_moves_ ? moving_coefficients_.data() : &steady_coefficients_;
    const int stride = omega_moves_ ? 1 : 0;
    const auto dispatch = [&](auto swinging, auto paper, auto plain) {
      step_valve<decltype(swinging)::value, decltype(paper)::value, decltype(plain)::value>(
          constants_, coefficients, stride, state_, signal, count);
    };
    if (constants_.swinging)
      constants_.paper ? dispatch(Yes{}, Yes{}, No{}) : dispatch(Yes{}, No{}, No{});
    else if (constants_.paper)
      dispatch(No{}, Yes{}, No{});
    else if (constants_.plain_port() && stride == 0 && signal.noise == nullptr)
      dispatch(No{}, No{}, Yes{});
    else
      dispatch(No{}, No{}, No{});
  }

  ValveState<V> state_{};
  ValveConstants constants_{};
  ValveConstants from_{}, to_{}; // constants at both ends of a control period in which they move
  V omega_from_{1.0}, omega_to_{1.0};
  bool still_ = false;
  bool omega_moves_ = false, constants_move_ = false, coefficients_due_ = true;
  ReedCoefficients<V> steady_coefficients_{};                        // coefficients while omega_r
                                                                     // is constant
  std::array<ReedCoefficients<V>, max_count> moving_coefficients_{}; // one per sample while omega_r
                                                                     // moves
};

} // namespace tactus::reed
