#pragma once

#include "core/dsp/random.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/bore/tone_hole_end.hpp"
#include "core/reed/instrument/halfband.hpp"
#include "core/reed/instrument/parameter_glide.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/instrument/valve_bore_step.hpp"
#include "core/reed/player/player.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>

namespace tactus::reed {

/// One reed instrument (V = double), or several copies side by side (V = simd::Lanes) that share
/// parameters and bore and differ in mouth pressure and reed frequency; see valve_bore_step.hpp.
///
/// Controls are looked at once every kControlPeriod samples, counted from reset() whatever the
/// blocks are, follow with 5 ms and are interpolated for each sample in between:
///
///   while samples are left:
///     if (bank.until_control() == 0) bank.control(reed frequency now, bore frequency now);
///     bank.run(mouth pressures, outputs, at most bank.until_control());
///
/// prepare() allocates; nothing else does.
template <class V> class ReedBank {
public:
  static constexpr int kControlPeriod = 32;
  static constexpr double kHighestPressure = 50e3; ///< Pa, of the mouth

  /// count samples each: radiated pressure at 1 m (Pa; of the first lane), theta (rad), p_b (Pa),
  /// U (m^3/s).
  struct Outputs {
    double* radiated;
    V* angle;
    V* bore_pressure;
    V* flow;
  };

  /// Makes room for the longest bore at this rate. The same rate again changes nothing; another
  /// rate starts the air from rest.
  void prepare(double sample_rate) {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    line_.prepare(max_delay(sample_rate * kMaxOversampling));
    below_.prepare(max_delay(sample_rate * kMaxOversampling));
    radiation_.prepare(sample_rate * kMaxOversampling);
    slew_ = 1 - std::exp(-kControlPeriod / (kSlewTime * sample_rate));
    max_immediate_step_ = kMaxImmediateRate * kControlPeriod / sample_rate;
    player_.prepare(sample_rate);
    glide_.prepare(sample_rate / kControlPeriod);
    starting_ = true;
    apply(parameters_);
    reset();
  }

  /// Takes the nearest usable parameters. While one reed sounds, numbers get there within some
  /// 16 ms, and switches in a short fade (ParameterGlide); several side by side have them at once.
  /// The state goes on, within the new stops.
  void set(const Parameters& parameters) noexcept {
    requested_ = clamped(parameters);
    const Parameters target = with_brass_tube(requested_);
    if (kSeveral || starting_ || !(sample_rate_ > 0))
      return apply(target);
    if (target == parameters_)
      return;
    parameters_ = target;
    glide_.begin(parameters_);
    if (!glide_.fades_out())
      update_player();
  }
  [[nodiscard]] const Parameters& parameters() const noexcept { return requested_; }
  /// Holes fingered one by one (Player::finger).
  void finger(const Termination* holes, double vent = 0) noexcept { player_.finger(holes, vent); }
  /// What the player was asked for and does not play.
  [[nodiscard]] const Refusal& refusal() const noexcept { return player_.refusal(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return length_to_; }

  void reset() noexcept {
    starting_ = true;
    phase_ = kControlPeriod;
    random_.seed(parameters_.seed);
    state_ = {};
    mouth_ = V(0.0);
    player_.reset();
    peak_pressure_ = 0;
    glide_.end_silence();
    if (sample_rate_ > 0)
      apply(parameters_);
    clear_air();
  }

  /// reset() of one reed that sounds, without a click: the sound fades out, and it is blown anew.
  void restart() noexcept {
    if (kSeveral || starting_)
      return reset();
    glide_.restart();
  }

  /// Whether the sound fades out for a change that has no way in between.
  [[nodiscard]] bool fades_out() const noexcept { return glide_.fades_out(); }
  /// The player's tongue stops the breath and lets it go.
  void articulate() noexcept { player_.articulate(); }
  /// Samples that run() may compute before control() is due.
  [[nodiscard]] int until_control() const noexcept { return kControlPeriod - phase_; }

  /// f_r in Hz for each lane (not above 0: the parameters' own), f_b in Hz (not above 0: the
  /// parameters' length).
  /// breath: the mouth pressure that the player's lips follow, Pa; below 0 they follow none.
  void control(const V& reed_frequency, double bore_frequency, double breath = -1) noexcept {
    using simd::absolute, simd::any, simd::select;
    phase_ = 0;
    flush_denormals();
    const bool silent =
        !kSeveral && peak_pressure_ < kSilencePressure && simd::lane(mouth_, 0) < kSilencePressure;
    peak_pressure_ = 0;
    if (glide_.fade() || (silent && glide_.fades_out()))
      change();
    if (silent)
      glide_.end_silence();
    constexpr double kTwoPi = 2 * std::numbers::pi;
    const V nominal_frequency = select((reed_frequency > V(0.0)) & (reed_frequency < V(1e9)),
                                       reed_frequency, V(glide_.current().reed_frequency));
    const Player::Configuration& configuration = player_.control(
        bore_frequency, static_cast<double>(simd::lane(nominal_frequency, 0)), breath);
    if (configuration.end != design_.end()) {
      design_.set_end(configuration.end);
      holes_.finger(configuration.end);
      trip_due_ = true;
    }
    move_vent(configuration.vent);
    end_substeps();
    if (gliding_)
      radiation_.set(radiation_to_);
    gliding_ = false;
    if (glide_.is_moving())
      move_parameters(configuration.valve);
    else if (configuration.valve_changed)
      apply_valve(configuration.valve);
    if (configuration.trim != trim_ || configuration.valve_changed || gliding_)
      trim(configuration.trim, configuration.length);
    const V target =
        V(kTwoPi * configuration.reed_scale) *
        simd::minimum(simd::maximum(nominal_frequency, V(1.0)), V(0.45 * sample_rate_));
    const bool played = player_.plays();
    omega_from_ = starting_ ? target : omega_to_;
    omega_to_ = omega_from_ + slewed(target - omega_from_, omega_from_, played);
    omega_to_ = select(absolute(target - omega_to_) < V(1e-6) * target, target, omega_to_);
    const bool moving = any((omega_from_ < omega_to_) | (omega_to_ < omega_from_));
    const bool moved = reed_moves_;
    reed_moves_ = moving && !played && !valve_moves_;
    valve_moves_ = valve_moves_ || (moving && played);
    if (!reed_moves_ && !valve_moves_ && (moved || steady_due_ || starting_)) {
      steady_coefficients_ = ReedCoefficients<V>::at(constants_, omega_to_);
      steady_due_ = false;
    }

    const double next = starting_
                            ? configuration.length
                            : length_to_ + simd::lane(slewed(V(configuration.length - length_to_),
                                                             V(length_to_), played),
                                                      0);
    set_bore_length(std::abs(configuration.length - next) < 1e-7 * configuration.length
                        ? configuration.length
                        : next);
    if (starting_)
      delay_from_ = trip_.delay;
    update_steepening_length(player_.note());
    starting_ = false;
  }

  /// Computes count <= until_control() samples; mouth pressures in Pa, finite, within +-50 kPa.
  void run(const V* mouth_pressure, const Outputs& out, int count) noexcept {
    const int max_samples = kChunk / oversampling_;
    const double from = glide_.fade_from(), to = glide_.fade_to();
    const int before = phase_;
    const auto share = [before](int i) { return (before + i + 1.0) / kControlPeriod; };
    std::array<V, kControlPeriod> breath;
    std::copy_n(mouth_pressure, count, breath.begin());
    player_.apply_tongue(breath.data(), count, kHighestPressure);
    const double breath_start = glide_.breath_gain_from(), breath_end = glide_.breath_gain_to();
    if (breath_start < 1 || breath_end < 1)
      for (int i = 0; i < count; ++i)
        breath[index(i)] =
            V(breath_start + (breath_end - breath_start) * share(i)) * breath[index(i)];
    mouth_pressure = breath.data();
    for (int done = 0; done < count;) {
      const int samples = std::min(count - done, max_samples);
      chunk(mouth_pressure + done,
            {out.radiated + done, out.angle + done, out.bore_pressure + done, out.flow + done},
            samples);
      done += samples;
      phase_ += samples;
    }
    if (from < 1 || to < 1)
      for (int i = 0; i < count; ++i) {
        const double fade_gain = from + (to - from) * share(i);
        out.radiated[i] *= fade_gain;
        for (V* signal : {out.angle, out.bore_pressure, out.flow})
          signal[i] = V(fade_gain) * signal[i];
      }
  }

private:
  static constexpr bool kSeveral = !std::is_same_v<V, double>;
  static constexpr int kChunk = 64; // internal samples computed in one go
  static constexpr int kMaxOversampling = 4;
  static constexpr double kSlewTime = 5e-3; // s
  static constexpr int kSubsteps = 4;       // of the valve, in a control period
  static constexpr double kMaxImmediateRate =
      25; // 1/s: an octave in 30 ms is followed without delay
  /// Up to here noise is a share of the mouth pressure and even; it need not stop when the valve
  /// shuts, and costs a fraction of what the jet's own does.
  static constexpr double kFaintNoise = kSeveral ? 1e-3 : 1e-5;
  static constexpr double kSilencePressure = 0.1; // Pa in the bore and the mouth: nothing sounds
  static constexpr double kVentTime = 5e-3;       // s
  static constexpr double kMinLengthBelowVent = 0.03; // m of line that it needs beyond it
  static constexpr double kDenormalLimit = 1e-20; // below, a state is nothing: denormals are dear
  using Signal = std::array<V, kChunk>;

  /// Takes over clamped parameters at once.
  void apply(const Parameters& parameters) noexcept {
    const int before = oversampling_;
    parameters_ = parameters;
    if (!(sample_rate_ > 0))
      return;
    glide_.jump(parameters_);
    oversampling_ = oversampling_of(parameters_);
    const double rate = sample_rate_ * oversampling_;
    design_.set(parameters_, rate);
    const ValveConstants old = constants_;
    constants_ = ValveConstants::from(parameters_, design_, rate);
    radiation_to_ = RadiationConstants::from(parameters_, design_, rate);
    radiation_.set(radiation_to_);
    gliding_ = false;
    holes_.set(rate, design_.air().sound_speed / air_at(20).sound_speed, parameters_.input_radius);
    vent_ = RegisterVent::of(parameters_);
    vent_filter_.set(vent_, rate);
    update_player();
    reposition_valve(old);
    from_ = to_ = constants_;
    valve_moves_ = false;
    steady_coefficients_ = ReedCoefficients<V>::at(constants_, omega_to_);
    steady_due_ = trip_due_ = true;
    if (oversampling_ != before)
      clear_air();
    length_to_ = std::clamp(length_to_, 5e-3, design_.max_length());
    set_bore_length(length_to_);
    delay_from_ = trip_.delay;
  }

  /// What has no way in between, when nothing is heard.
  void change() noexcept {
    const bool restarted = glide_.restarts() || !can_continue(glide_.parameters(), parameters_);
    if (glide_.restarts()) {
      random_.seed(parameters_.seed);
      player_.reset();
    }
    apply(parameters_);
    if (restarted) {
      state_ = {};
      clear_air();
    }
    glide_.proceed(restarted);
  }

  void update_player() noexcept {
    BoreDesign bore;
    bore.set(parameters_, sample_rate_ * oversampling_);
    player_.set(parameters_, bore);
  }

  /// Valve, bore and radiation go a step of the way to what they are to be.
  void move_parameters(const Parameters& target) noexcept {
    glide_.move(target);
    const double rate = sample_rate_ * oversampling_;
    design_.set(glide_.current(), rate);
    trip_from_ = trip_;
    radiation_from_ = radiation_to_;
    radiation_to_ = RadiationConstants::from(glide_.current(), design_, rate);
    trip_due_ = gliding_ = true;
    set_valve(glide_.current(), true);
  }

  /// The valve stays where it was, unless the new stops or the new side are in its way.
  void reposition_valve(const ValveConstants& old) noexcept {
    if (starting_) {
      state_ = {};
      return;
    }
    const double turn = old.direction * constants_.direction;
    const V target =
        V(turn) * (state_.deflection() + V(old.rest_opening)) - V(constants_.rest_opening);
    const V low(constants_.lowest), high(constants_.highest);
    state_.move(
        simd::minimum(simd::maximum(target, low), high),
        simd::select((target < low) | (target > high), V(0.0), V(turn) * state_.velocity()));
    // A cone's flow goes on; a cup's, C dp/dt, grows with the cup.
    if (!(constants_.inertance_rate > 0) || !(old.inertance_rate > 0))
      state_.inertance_flow = V(0.0);
    if (constants_.compliance_rate != old.compliance_rate)
      state_.compliance_flow =
          old.compliance_rate > 0
              ? state_.compliance_flow * V(constants_.compliance_rate / old.compliance_rate)
              : V(0.0);
    state_.update_port_history(constants_);
  }

  /// How far something goes within a control period towards what it is to be. What a player moves
  /// steadily is there in time, so that glides and vibrato do not lag behind; the rest of a leap
  /// takes its time.
  [[nodiscard]] V slewed(const V& difference, const V& size, bool played) const noexcept {
    const V part = V(slew_) * difference;
    if (!played)
      return part;
    const V room =
        simd::minimum(simd::absolute(difference), V(max_immediate_step_) * simd::absolute(size));
    return simd::copy_sign(simd::maximum(simd::absolute(part), room), difference);
  }

  void apply_valve(const Parameters& valve) noexcept {
    glide_.follow(valve);
    set_valve(valve, player_.plays() && !starting_);
  }

  /// The valve is to be held so: at once, or in kSubsteps within this control period.
  void set_valve(const Parameters& valve, bool smoothly) noexcept {
    const ValveConstants held = ValveConstants::from(valve, design_, sample_rate_ * oversampling_);
    steady_due_ = true;
    if (smoothly) {
      from_ = constants_;
      to_ = held;
      valve_moves_ = true;
      return;
    }
    const ValveConstants old = constants_;
    from_ = to_ = constants_ = held;
    reposition_valve(old);
  }

  void end_substeps() noexcept {
    if (!valve_moves_)
      return;
    valve_moves_ = false;
    steady_due_ = true;
    const ValveConstants old = constants_;
    from_ = constants_ = to_;
    reposition_valve(old);
  }

  /// The valve as it is held in the middle of a part of the control period.
  void substep(int step) noexcept {
    const double share = (step + 0.5) / kSubsteps;
    const ValveConstants old = constants_;
    constants_ = ValveConstants::interpolate(from_, to_, share);
    if (constants_.rest_opening != old.rest_opening || constants_.lowest != old.lowest ||
        constants_.highest != old.highest || constants_.inertance_rate != old.inertance_rate ||
        constants_.compliance_rate != old.compliance_rate)
      reposition_valve(old);
    steady_coefficients_ =
        ReedCoefficients<V>::at(constants_, omega_from_ + V(share) * (omega_to_ - omega_from_));
  }

  /// The bore sounds sharper by exp(logarithm) than one of the length chosen.
  void trim(double logarithm, double length) noexcept {
    trim_ = logarithm;
    const double acoustic = design_.air().sound_speed / design_.ideal_frequency(length) /
                            (glide_.current().shape == BoreShape::kCone ? 2 : 4);
    trim_delay_ = 2 * acoustic * std::expm1(-logarithm) / design_.air().sound_speed * sample_rate_ *
                  oversampling_;
  }

  void set_bore_length(double length) noexcept {
    delay_from_ = trip_.delay;
    if (length != length_to_ || trip_due_) {
      length_to_ = length;
      trip_ = design_.round_trip(length);
      untrimmed_delay_ = trip_.delay;
      trip_due_ = false;
    }
    // A trim changes the delay alone: what it would change in the losses is inaudible.
    trip_.delay = std::clamp(untrimmed_delay_ + trim_delay_, 3.0,
                             static_cast<double>(max_delay(sample_rate_ * oversampling_)));
    if (divided_)
      divide();
  }

  /// The two parts of the bore on both sides of the vent.
  void divide() noexcept {
    parts_ = design_.parts(trip_, length_to_, vent_.position);
    // Some samples of the line are below the vent, whatever the bore's length.
    parts_.above.delay =
        std::clamp(parts_.above.delay, 3.0, std::max(3.0, std::min(delay_from_, trip_.delay) - 4));
  }

  /// The vent opens and closes within kVentTime. The line is in two parts from its first opening
  /// until what was sent while it was open has passed.
  void move_vent(double open) noexcept {
    const bool vent_usable = vent_.share > 0 && !(parameters_.scalar_reflection > 0) &&
                             length_to_ > vent_.position + kMinLengthBelowVent;
    const double target = vent_usable ? open : 0,
                 step = kControlPeriod / (kVentTime * sample_rate_);
    vent_from_ = vent_to_;
    vent_to_ = starting_ ? target : std::clamp(target, vent_to_ - step, vent_to_ + step);
    if (starting_)
      vent_from_ = vent_to_;
    samples_since_vent_ = vent_from_ > 0 || vent_to_ > 0 ? 0 : samples_since_vent_ + kControlPeriod;
    if (!divided_ && vent_to_ > 0) {
      divided_ = true;
      divide();
      below_.follow(line_, parts_.above.delay, static_cast<int>(trip_.delay) + 8);
      // Both parts' filters have the same poles: what is in them goes as the losses do.
      above_filter_ = filter_;
      scale_losses(parts_.above, trip_, parts_.below, trip_);
      vent_filter_.reset();
    } else if (divided_ && samples_since_vent_ * oversampling_ > 2 * trip_.delay + kControlPeriod) {
      divided_ = false;
      scale_losses({}, trip_, trip_, parts_.below);
    }
  }
  void scale_losses(const RoundTrip& above, const RoundTrip& above_before, const RoundTrip& below,
                    const RoundTrip& below_before) noexcept {
    const auto share = [](const RoundTrip& current, const RoundTrip& before) {
      const double size = before.loss_residue[0];
      return size != 0 ? current.loss_residue[0] / size : 0.0;
    };
    const double more = share(above, above_before), less = share(below, below_before);
    above_filter_.each_loss([more](auto& value) { value = value * more; });
    filter_.each_loss([less](auto& value) { value = value * less; });
  }

  /// What brassiness counts: the bore's own length, or a share of a player's wavelength.
  void update_steepening_length(double note) noexcept {
    if (!(parameters_.steepening > 0) || !(note > 0)) {
      steepening_length_ = length_to_;
      return;
    }
    const double length = parameters_.steepening * design_.air().sound_speed / note;
    steepening_length_ += (starting_ ? 1 : slew_) * (length - steepening_length_);
  }

  void clear_air() noexcept {
    line_.clear();
    below_.clear();
    filter_.reset();
    above_filter_.reset();
    vent_filter_.reset();
    radiation_.reset();
    holes_.reset();
    const V deflection = state_.deflection(), velocity = state_.velocity();
    state_ = {};
    state_.move(deflection, velocity);
    radiated_decimator_.reset();
    for (auto& decimator : decimators_)
      decimator.reset();
  }

  static void flush_denormals(V& value) noexcept {
    value = simd::select(simd::absolute(value) < V(kDenormalLimit), V(0.0), value);
  }
  void flush_denormals() noexcept {
    for (V* value : {&state_.jet, &state_.jet_history, &state_.flow, &state_.inertance_flow,
                     &state_.compliance_flow, &state_.port_history, &state_.position,
                     &state_.base_velocity, &state_.base_pressure, &state_.pending_flow})
      flush_denormals(*value);
    filter_.each([](auto& value) { flush_denormals(value); });
    if (divided_) {
      above_filter_.each([](auto& value) { flush_denormals(value); });
      vent_filter_.each([](V& value) { flush_denormals(value); });
    }
    radiation_.flush_denormals();
    if (holes_.active()) {
      holes_.proceed();
      holes_.each([](V& value) { flush_denormals(value); });
      holes_.each_radiation([](double& value) {
        if (std::abs(value) < kDenormalLimit)
          value = 0;
      });
    }
  }

  void chunk(const V* mouth_pressure, const Outputs& out, int samples) noexcept {
    if (oversampling_ == 1) {
      mouth_ = mouth_pressure[samples - 1];
      advance(mouth_pressure, out, samples);
    } else {
      const int count = samples * oversampling_;
      Signal mouth{}, angle, bore, flow;
      std::array<double, kChunk> radiated;
      // The mouth pressure runs straight from sample to sample.
      const V share(1.0 / oversampling_);
      for (int n = 0, i = 0; n < samples; ++n) {
        const V rise = share * (mouth_pressure[n] - mouth_);
        for (int k = 1; k < oversampling_; ++k)
          mouth[index(i++)] = mouth_ + V(static_cast<double>(k)) * rise;
        mouth[index(i++)] = mouth_ = mouth_pressure[n];
      }
      advance(mouth.data(), {radiated.data(), angle.data(), bore.data(), flow.data()}, count);
      radiated_decimator_.run(oversampling_, radiated.data(), out.radiated, samples);
      decimators_[0].run(oversampling_, angle.data(), out.angle, samples);
      decimators_[1].run(oversampling_, bore.data(), out.bore_pressure, samples);
      decimators_[2].run(oversampling_, flow.data(), out.flow, samples);
    }
    if (player_.tracks_pitch()) {
      std::array<double, kChunk> pitch_samples;
      for (int i = 0; i < samples; ++i)
        pitch_samples[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      player_.track_pitch(pitch_samples.data(), samples);
    }
  }

  /// count internal samples.
  void advance(const V* mouth, const Outputs& out, int count) noexcept {
    std::array<double, kChunk> noise;
    Signal breath;
    const double share = glide_.current().breath_noise;
    const bool noisy = share > kFaintNoise;
    // The same power in each hertz at any rate.
    const double strength = share * std::sqrt(sample_rate_ * oversampling_ / 48e3);
    if (noisy) { // never more than what drives the jet
      for (int i = 0; i < count; ++i)
        noise[index(i)] = std::clamp(strength * random_.normal(), -0.9, 0.9);
    } else if (strength > 0) {
      const double amplitude = strength * std::numbers::sqrt3;
      for (int i = 0; i < count; ++i)
        breath[index(i)] = mouth[i] * V(1 + amplitude * (2 * random_.uniform() - 1));
      mouth = breath.data();
    }
    for (int done = 0; done < count;) {
      const int phase = phase_ * oversampling_ + done;
      const double first = delay_from_ + phase / period() * (trip_.delay - delay_from_);
      const double above = divided_ ? parts_.above.delay : 0;
      int room = line_.max_block(std::min(first, trip_.delay) - above);
      if (divided_)
        room = std::min({room, line_.max_block(above), below_.room()});
      const int part = std::min({count - done, room, line_.room()});
      V* wave = line_.next();
      BoreLine<V, kChunk>& last = divided_ ? below_ : line_; // to the bore's end
      V* bore_end_wave = last.next();
      if (delay_from_ == trip_.delay)
        last.read(first - above, kDenormalLimit, bore_end_wave, part);
      else
        last.read_moving(delay_from_ - above, trip_.delay - above, phase, period(), kDenormalLimit,
                         bore_end_wave, part);
      if (gliding_)
        travel_gliding(bore_end_wave, out.radiated + done, phase, part);
      else
        steepen_wave(bore_end_wave, divided_ ? parts_.below : trip_, out.radiated + done, part);
      if (divided_)
        pass_vent(wave, bore_end_wave, phase, part);
      if (reed_moves_)
        for (int i = 0; i < part; ++i)
          moving_coefficients_[index(i)] = ReedCoefficients<V>::at(
              constants_, omega_from_ + V((phase + i + 1) / period()) * (omega_to_ - omega_from_));
      const int substep_size = valve_moves_ ? kControlPeriod / kSubsteps * oversampling_ : part;
      for (int i = 0; i < part;) {
        const int offset = valve_moves_ ? (phase + i) % substep_size : 0, at = done + i;
        if (valve_moves_ && offset == 0)
          substep((phase + i) / substep_size);
        const int size = std::min(part - i, substep_size - offset);
        step(reed_moves_ ? moving_coefficients_.data() : &steady_coefficients_, reed_moves_ ? 1 : 0,
             {mouth + at, noisy ? noise.data() + at : nullptr, wave + i, out.angle + at,
              out.bore_pressure + at, out.flow + at},
             size);
        i += size;
      }
      line_.advance(part);
      done += part;
    }
    if (holes_.active()) {
      radiation_.steepen_wave(out.radiated, count, steepening_length_);
      holes_.radiate(out.radiated, count);
    } else if (radiation_.steepens()) {
      radiation_.run(out.radiated, count, steepening_length_);
    }
    guard(out, count);
  }

  /// What the bore sends back, in place of what its end received, and what leaves it. Because the
  /// wave takes at least count samples through the bore, that is known before the valve moves.
  [[gnu::noinline, gnu::flatten]] void steepen_wave(V* wave, const RoundTrip& trip,
                                                    double* radiated, int count) noexcept {
    typename RoundTripFilter<V>::BlockFilter filter(filter_, trip, radiation_.reflected_weight());
    if (holes_.active()) {
      for (int i = 0; i < count; ++i) {
        wave[i] = filter.incident(wave[i]);
        radiated[i] = static_cast<double>(simd::lane(wave[i], 0));
      }
      holes_.reflect(wave, count);
    } else if (radiation_.steepens()) {
      for (int i = 0; i < count; ++i)
        wave[i] = filter(wave[i], radiated[i]);
    } else {
      RadiationPath::OutputFilter output_filter(radiation_);
      for (int i = 0; i < count; ++i) {
        double leaving;
        wave[i] = filter(wave[i], leaving);
        radiated[i] = output_filter(leaving);
      }
    }
  }

  /// The same while bore and radiation change: their numbers run straight from sample to sample.
  void travel_gliding(V* wave, double* radiated, int phase, int count) noexcept {
    for (int i = 0; i < count; ++i) {
      const double share = (phase + i + 1) / period();
      radiation_.set(RadiationConstants::interpolate(radiation_from_, radiation_to_, share));
      steepen_wave(wave + i,
                   divided_ ? parts_.below : RoundTrip::interpolate(trip_from_, trip_, share),
                   radiated + i, 1);
    }
  }

  /// What the line above the vent sends back, and what the line below it receives.
  [[gnu::noinline, gnu::flatten]] void pass_vent(V* wave, V* below, int phase, int count) noexcept {
    line_.read(parts_.above.delay, kDenormalLimit, wave, count);
    typename RoundTripFilter<V>::BlockFilter losses(above_filter_, parts_.above, 0);
    const double step = (vent_to_ - vent_from_) / period();
    vent_filter_.pass(losses, wave, below, vent_from_ + step * phase, step, count);
    below_.advance(count);
  }

  void step(const ReedCoefficients<V>* coefficients, int stride, const ValveSignals<V>& signal,
            int count) noexcept {
    using Yes = std::true_type;
    using No = std::false_type;
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

  /// The paper's explicit flow and the force of the flow (mu) can feed energy in without bound,
  /// with absurd enough parameters: then the model starts anew from rest.
  void guard(const Outputs& out, int count) noexcept {
    const auto beyond = [](const V& value, double limit) { // or no number
      return simd::any(!(simd::absolute(value) < V(limit)));
    };
    bool sane = true;
    if constexpr (std::is_same_v<V, double>) {
      V even(0.0), odd(0.0); // side by side: each has to wait for itself
      int i = 0;
      for (; i + 1 < count; i += 2) {
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
        odd = simd::maximum(simd::absolute(out.bore_pressure[i + 1]), odd);
      }
      if (i < count)
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
      peak_pressure_ = std::max({peak_pressure_, even, odd});
      sane = !beyond(simd::maximum(even, odd), 1e9);
    } else { // lanes have masks, which do not wait
      const V limit(1e9);
      auto within = simd::absolute(out.bore_pressure[0]) < limit;
      for (int i = 1; i < count; ++i)
        within = within & (simd::absolute(out.bore_pressure[i]) < limit);
      sane = !simd::any(!within);
    }
    if (sane && !beyond(state_.bore_pressure(), 1e9) && !beyond(state_.jet, 1e6) &&
        !beyond(state_.velocity(), 1e9) && radiation_.sane())
      return;
    std::fill_n(out.radiated, count, 0.0);
    for (V* signal : {out.angle, out.bore_pressure, out.flow})
      std::fill_n(signal, count, V(0.0));
    state_ = {};
    clear_air();
  }

  [[nodiscard]] double period() const noexcept {
    return static_cast<double>(kControlPeriod * oversampling_);
  }
  static std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }

  double sample_rate_ = 0, slew_ = 1, max_immediate_step_ = 0;
  int oversampling_ = 1, phase_ = kControlPeriod;
  bool starting_ = true, reed_moves_ = false, valve_moves_ = false, gliding_ = false,
       trip_due_ = true, steady_due_ = true;
  Parameters requested_{}, parameters_{}; // the second with the tube that is played, if one is
  BoreDesign design_{};
  ValveConstants constants_{};
  ValveConstants from_{}, to_{}; // while the player moves the valve
  RoundTrip trip_{}, trip_from_{};
  RadiationConstants radiation_from_{}, radiation_to_{};
  double length_to_ = 0.48, delay_from_ = 3;
  double peak_pressure_ = 0; // bore pressure since the last control period, Pa
  double steepening_length_ = 0.48;
  V omega_from_{1.0}, omega_to_{1.0}, mouth_{0.0};
  ReedCoefficients<V> steady_coefficients_{};                     // while f_r stands
  std::array<ReedCoefficients<V>, kChunk> moving_coefficients_{}; // while it moves
  ValveState<V> state_{};
  RoundTripFilter<V> filter_{};
  RadiationPath radiation_{};
  Player player_{};
  ParameterGlide glide_{};
  double trim_ = 0, trim_delay_ = 0, untrimmed_delay_ = 3;
  ToneHoleEnd<V> holes_{};
  RegisterVent vent_{};
  VentFilter<V> vent_filter_{};
  RoundTripFilter<V> above_filter_{}; // of the line above the vent
  BoreDesign::Parts parts_{};         // while it is divided there
  bool divided_ = false;
  int samples_since_vent_ = 0;         // samples since the vent was open
  double vent_from_ = 0, vent_to_ = 0; // share that is open
  BoreLine<V, kChunk> line_, below_;
  Decimator<double, kChunk> radiated_decimator_{};
  std::array<Decimator<V, kChunk>, 3> decimators_{};
  Random random_{};
};

} // namespace tactus::reed
