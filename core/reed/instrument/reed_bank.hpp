#pragma once

#include "core/dsp/random.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/bore/holed_end.hpp"
#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
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
    line_.prepare(longest_delay(sample_rate * kMaxOversampling));
    below_.prepare(longest_delay(sample_rate * kMaxOversampling));
    radiation_.prepare(sample_rate * kMaxOversampling);
    slew_ = 1 - std::exp(-kControlPeriod / (kSlewTime * sample_rate));
    at_once_ = kAtOnce * kControlPeriod / sample_rate;
    player_.prepare(sample_rate);
    glide_.prepare(sample_rate / kControlPeriod);
    fresh_ = true;
    apply(parameters_);
    reset();
  }

  /// Takes the nearest usable parameters. While one reed sounds, numbers get there within some
  /// 16 ms, and switches in a short fade (ParameterGlide); several side by side have them at once.
  /// The state goes on, within the new stops.
  void set(const Parameters& parameters) noexcept {
    given_ = clamped(parameters);
    const Parameters wanted = with_tube(given_);
    if (kSeveral || fresh_ || !(sample_rate_ > 0))
      return apply(wanted);
    if (wanted == parameters_)
      return;
    parameters_ = wanted;
    glide_.begin(parameters_);
    if (!glide_.fades_out())
      inform_player();
  }
  [[nodiscard]] const Parameters& parameters() const noexcept { return given_; }
  /// Holes fingered one by one (Player::finger).
  void finger(const Termination* holes, double vent = 0) noexcept { player_.finger(holes, vent); }
  /// What the player was asked for and does not play.
  [[nodiscard]] const Refusal& refusal() const noexcept { return player_.refusal(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return length_to_; }

  void reset() noexcept {
    fresh_ = true;
    phase_ = kControlPeriod;
    random_.seed(parameters_.seed);
    state_ = {};
    mouth_ = V(0.0);
    player_.reset();
    loudest_ = 0;
    glide_.full();
    if (sample_rate_ > 0)
      apply(parameters_);
    still_air();
  }

  /// reset() of one reed that sounds, without a click: the sound fades out, and it is blown anew.
  void restart() noexcept {
    if (kSeveral || fresh_)
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
    quieten();
    const bool quiet = !kSeveral && loudest_ < kQuiet && simd::lane(mouth_, 0) < kQuiet;
    loudest_ = 0;
    if (glide_.fade() || (quiet && glide_.fades_out()))
      change();
    if (quiet)
      glide_.full();
    constexpr double kTwoPi = 2 * std::numbers::pi;
    const V given = select((reed_frequency > V(0.0)) & (reed_frequency < V(1e9)), reed_frequency,
                           V(glide_.now().reed_frequency));
    const Player::Hold& hold =
        player_.control(bore_frequency, static_cast<double>(simd::lane(given, 0)), breath);
    if (hold.end != design_.end()) {
      design_.set_end(hold.end);
      holes_.finger(hold.end);
      trip_due_ = true;
    }
    move_vent(hold.vent);
    end_substeps();
    if (gliding_)
      radiation_.set(radiation_to_);
    gliding_ = false;
    if (glide_.moves())
      move_parameters(hold.valve);
    else if (hold.valve_changed)
      take(hold.valve);
    if (hold.trim != trim_ || hold.valve_changed || gliding_)
      trim(hold.trim, hold.length);
    const V target = V(kTwoPi * hold.reed_scale) *
                     simd::minimum(simd::maximum(given, V(1.0)), V(0.45 * sample_rate_));
    const bool played = player_.plays();
    omega_from_ = fresh_ ? target : omega_to_;
    omega_to_ = omega_from_ + followed(target - omega_from_, omega_from_, played);
    omega_to_ = select(absolute(target - omega_to_) < V(1e-6) * target, target, omega_to_);
    const bool moving = any((omega_from_ < omega_to_) | (omega_to_ < omega_from_));
    const bool moved = reed_moves_;
    reed_moves_ = moving && !played && !valve_moves_;
    valve_moves_ = valve_moves_ || (moving && played);
    if (!reed_moves_ && !valve_moves_ && (moved || steady_due_ || fresh_)) {
      steady_ = ReedCoefficients<V>::at(constants_, omega_to_);
      steady_due_ = false;
    }

    const double next =
        fresh_ ? hold.length
               : length_to_ +
                     simd::lane(followed(V(hold.length - length_to_), V(length_to_), played), 0);
    move_bore(std::abs(hold.length - next) < 1e-7 * hold.length ? hold.length : next);
    if (fresh_)
      delay_from_ = trip_.delay;
    steepen_over(player_.note());
    fresh_ = false;
  }

  /// Computes count <= until_control() samples; mouth pressures in Pa, finite, within +-50 kPa.
  void run(const V* mouth_pressure, const Outputs& out, int count) noexcept {
    const int most = kChunk / oversampling_;
    const double from = glide_.loudness_from(), to = glide_.loudness_to();
    const int before = phase_;
    const auto share = [before](int i) { return (before + i + 1.0) / kControlPeriod; };
    std::array<V, kControlPeriod> breath;
    std::copy_n(mouth_pressure, count, breath.begin());
    player_.breathe(breath.data(), count, kHighestPressure);
    const double blown_from = glide_.breath_from(), blown_to = glide_.breath_to();
    if (blown_from < 1 || blown_to < 1)
      for (int i = 0; i < count; ++i)
        breath[index(i)] = V(blown_from + (blown_to - blown_from) * share(i)) * breath[index(i)];
    mouth_pressure = breath.data();
    for (int done = 0; done < count;) {
      const int samples = std::min(count - done, most);
      chunk(mouth_pressure + done,
            {out.radiated + done, out.angle + done, out.bore_pressure + done, out.flow + done},
            samples);
      done += samples;
      phase_ += samples;
    }
    if (from < 1 || to < 1)
      for (int i = 0; i < count; ++i) {
        const double loudness = from + (to - from) * share(i);
        out.radiated[i] *= loudness;
        for (V* signal : {out.angle, out.bore_pressure, out.flow})
          signal[i] = V(loudness) * signal[i];
      }
  }

private:
  static constexpr bool kSeveral = !std::is_same_v<V, double>;
  static constexpr int kChunk = 64; // internal samples computed in one go
  static constexpr int kMaxOversampling = 4;
  static constexpr double kSlewTime = 5e-3; // s
  static constexpr int kSubsteps = 4;       // of the valve, in a control period
  static constexpr double kAtOnce = 25;     // 1/s: an octave in 30 ms is followed without delay
  /// Up to here noise is a share of the mouth pressure and even; it need not stop when the valve
  /// shuts, and costs a fraction of what the jet's own does.
  static constexpr double kFaintNoise = kSeveral ? 1e-3 : 1e-5;
  static constexpr double kQuiet = 0.1;      // Pa in the bore and the mouth: nothing sounds
  static constexpr double kVentTime = 5e-3;  // s
  static constexpr double kBelowVent = 0.03; // m of line that it needs beyond it
  static constexpr double kSilence = 1e-20;  // below, a state is nothing: denormals are dear
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
    inform_player();
    place_valve(old);
    from_ = to_ = constants_;
    valve_moves_ = false;
    steady_ = ReedCoefficients<V>::at(constants_, omega_to_);
    steady_due_ = trip_due_ = true;
    if (oversampling_ != before)
      still_air();
    length_to_ = std::clamp(length_to_, 5e-3, design_.longest());
    move_bore(length_to_);
    delay_from_ = trip_.delay;
  }

  /// What has no way in between, when nothing is heard.
  void change() noexcept {
    const bool anew = glide_.restarts() || !goes_on(glide_.parameters(), parameters_);
    if (glide_.restarts()) {
      random_.seed(parameters_.seed);
      player_.reset();
    }
    apply(parameters_);
    if (anew) {
      state_ = {};
      still_air();
    }
    glide_.proceed(anew);
  }

  void inform_player() noexcept {
    BoreDesign bore;
    bore.set(parameters_, sample_rate_ * oversampling_);
    player_.set(parameters_, bore);
  }

  /// Valve, bore and radiation go a step of the way to what they are to be.
  void move_parameters(const Parameters& target) noexcept {
    glide_.move(target);
    const double rate = sample_rate_ * oversampling_;
    design_.set(glide_.now(), rate);
    trip_from_ = trip_;
    radiation_from_ = radiation_to_;
    radiation_to_ = RadiationConstants::from(glide_.now(), design_, rate);
    trip_due_ = gliding_ = true;
    hold_valve(glide_.now(), true);
  }

  /// The valve stays where it was, unless the new stops or the new side are in its way.
  void place_valve(const ValveConstants& old) noexcept {
    if (fresh_) {
      state_ = {};
      return;
    }
    const double turn = old.direction * constants_.direction;
    const V wanted =
        V(turn) * (state_.deflection() + V(old.rest_opening)) - V(constants_.rest_opening);
    const V low(constants_.lowest), high(constants_.highest);
    state_.move(
        simd::minimum(simd::maximum(wanted, low), high),
        simd::select((wanted < low) | (wanted > high), V(0.0), V(turn) * state_.velocity()));
    // A cone's flow goes on; a cup's, C dp/dt, grows with the cup.
    if (!(constants_.inertance_rate > 0) || !(old.inertance_rate > 0))
      state_.inertance_flow = V(0.0);
    if (constants_.compliance_rate != old.compliance_rate)
      state_.compliance_flow =
          old.compliance_rate > 0
              ? state_.compliance_flow * V(constants_.compliance_rate / old.compliance_rate)
              : V(0.0);
    state_.remember(constants_);
  }

  /// How far something goes within a control period towards what it is to be. What a player moves
  /// steadily is there in time, so that glides and vibrato do not lag behind; the rest of a leap
  /// takes its time.
  [[nodiscard]] V followed(const V& way, const V& size, bool played) const noexcept {
    const V part = V(slew_) * way;
    if (!played)
      return part;
    const V room = simd::minimum(simd::absolute(way), V(at_once_) * simd::absolute(size));
    return simd::copy_sign(simd::maximum(simd::absolute(part), room), way);
  }

  void take(const Parameters& valve) noexcept {
    glide_.follow(valve);
    hold_valve(valve, player_.plays() && !fresh_);
  }

  /// The valve is to be held so: at once, or in kSubsteps within this control period.
  void hold_valve(const Parameters& valve, bool gently) noexcept {
    const ValveConstants held = ValveConstants::from(valve, design_, sample_rate_ * oversampling_);
    steady_due_ = true;
    if (gently) {
      from_ = constants_;
      to_ = held;
      valve_moves_ = true;
      return;
    }
    const ValveConstants old = constants_;
    from_ = to_ = constants_ = held;
    place_valve(old);
  }

  void end_substeps() noexcept {
    if (!valve_moves_)
      return;
    valve_moves_ = false;
    steady_due_ = true;
    const ValveConstants old = constants_;
    from_ = constants_ = to_;
    place_valve(old);
  }

  /// The valve as it is held in the middle of a part of the control period.
  void substep(int step) noexcept {
    const double share = (step + 0.5) / kSubsteps;
    const ValveConstants old = constants_;
    constants_ = ValveConstants::between(from_, to_, share);
    if (constants_.rest_opening != old.rest_opening || constants_.lowest != old.lowest ||
        constants_.highest != old.highest || constants_.inertance_rate != old.inertance_rate ||
        constants_.compliance_rate != old.compliance_rate)
      place_valve(old);
    steady_ =
        ReedCoefficients<V>::at(constants_, omega_from_ + V(share) * (omega_to_ - omega_from_));
  }

  /// The bore sounds sharper by exp(logarithm) than one of the length chosen.
  void trim(double logarithm, double length) noexcept {
    trim_ = logarithm;
    const double acoustic = design_.air().sound_speed / design_.ideal_frequency(length) /
                            (glide_.now().shape == BoreShape::kCone ? 2 : 4);
    trim_delay_ = 2 * acoustic * std::expm1(-logarithm) / design_.air().sound_speed * sample_rate_ *
                  oversampling_;
  }

  void move_bore(double length) noexcept {
    delay_from_ = trip_.delay;
    if (length != length_to_ || trip_due_) {
      length_to_ = length;
      trip_ = design_.round_trip(length);
      own_delay_ = trip_.delay;
      trip_due_ = false;
    }
    // A trim changes the delay alone: what it would change in the losses is inaudible.
    trip_.delay = std::clamp(own_delay_ + trim_delay_, 3.0,
                             static_cast<double>(longest_delay(sample_rate_ * oversampling_)));
    if (divided_)
      divide();
  }

  /// The two parts of the bore on both sides of the vent.
  void divide() noexcept {
    parts_ = design_.parts(trip_, length_to_, vent_.place);
    // Some samples of the line are below the vent, whatever the bore's length.
    parts_.above.delay =
        std::clamp(parts_.above.delay, 3.0, std::max(3.0, std::min(delay_from_, trip_.delay) - 4));
  }

  /// The vent opens and closes within kVentTime. The line is in two parts from its first opening
  /// until what was sent while it was open has passed.
  void move_vent(double open) noexcept {
    const bool has = vent_.share > 0 && !(parameters_.scalar_reflection > 0) &&
                     length_to_ > vent_.place + kBelowVent;
    const double wanted = has ? open : 0, step = kControlPeriod / (kVentTime * sample_rate_);
    vent_from_ = vent_to_;
    vent_to_ = fresh_ ? wanted : std::clamp(wanted, vent_to_ - step, vent_to_ + step);
    if (fresh_)
      vent_from_ = vent_to_;
    shut_ = vent_from_ > 0 || vent_to_ > 0 ? 0 : shut_ + kControlPeriod;
    if (!divided_ && vent_to_ > 0) {
      divided_ = true;
      divide();
      below_.follow(line_, parts_.above.delay, static_cast<int>(trip_.delay) + 8);
      // Both parts' filters have the same poles: what is in them goes as the losses do.
      above_filter_ = filter_;
      share_losses(parts_.above, trip_, parts_.below, trip_);
      vent_filter_.reset();
    } else if (divided_ && shut_ * oversampling_ > 2 * trip_.delay + kControlPeriod) {
      divided_ = false;
      share_losses({}, trip_, trip_, parts_.below);
    }
  }
  void share_losses(const RoundTrip& above, const RoundTrip& above_before, const RoundTrip& below,
                    const RoundTrip& below_before) noexcept {
    const auto share = [](const RoundTrip& now, const RoundTrip& before) {
      const double size = before.loss_residue[0];
      return size != 0 ? now.loss_residue[0] / size : 0.0;
    };
    const double more = share(above, above_before), less = share(below, below_before);
    above_filter_.each_loss([more](auto& value) { value = value * more; });
    filter_.each_loss([less](auto& value) { value = value * less; });
  }

  /// What brassiness counts: the bore's own length, or a share of a player's wavelength.
  void steepen_over(double note) noexcept {
    if (!(parameters_.steepening > 0) || !(note > 0)) {
      steepening_length_ = length_to_;
      return;
    }
    const double length = parameters_.steepening * design_.air().sound_speed / note;
    steepening_length_ += (fresh_ ? 1 : slew_) * (length - steepening_length_);
  }

  void still_air() noexcept {
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

  static void quieten(V& value) noexcept {
    value = simd::select(simd::absolute(value) < V(kSilence), V(0.0), value);
  }
  void quieten() noexcept {
    for (V* value : {&state_.jet, &state_.carried, &state_.flow, &state_.inertance_flow,
                     &state_.compliance_flow, &state_.past, &state_.place, &state_.speed,
                     &state_.pressure, &state_.moved_by})
      quieten(*value);
    filter_.each([](auto& value) { quieten(value); });
    if (divided_) {
      above_filter_.each([](auto& value) { quieten(value); });
      vent_filter_.each([](V& value) { quieten(value); });
    }
    radiation_.quieten();
    if (holes_.active()) {
      holes_.proceed();
      holes_.each([](V& value) { quieten(value); });
      holes_.each_outside([](double& value) {
        if (std::abs(value) < kSilence)
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
    if (player_.listens()) {
      std::array<double, kChunk> heard;
      for (int i = 0; i < samples; ++i)
        heard[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      player_.listen(heard.data(), samples);
    }
  }

  /// count internal samples.
  void advance(const V* mouth, const Outputs& out, int count) noexcept {
    std::array<double, kChunk> noise;
    Signal breath;
    const double share = glide_.now().breath_noise;
    const bool noisy = share > kFaintNoise;
    // The same power in each hertz at any rate.
    const double strength = share * std::sqrt(sample_rate_ * oversampling_ / 48e3);
    if (noisy) { // never more than what drives the jet
      for (int i = 0; i < count; ++i)
        noise[index(i)] = std::clamp(strength * random_.normal(), -0.9, 0.9);
    } else if (strength > 0) {
      const double reach = strength * std::numbers::sqrt3;
      for (int i = 0; i < count; ++i)
        breath[index(i)] = mouth[i] * V(1 + reach * (2 * random_.uniform() - 1));
      mouth = breath.data();
    }
    for (int done = 0; done < count;) {
      const int phase = phase_ * oversampling_ + done;
      const double first = delay_from_ + phase / period() * (trip_.delay - delay_from_);
      const double above = divided_ ? parts_.above.delay : 0;
      int room = line_.stretch(std::min(first, trip_.delay) - above);
      if (divided_)
        room = std::min({room, line_.stretch(above), below_.room()});
      const int part = std::min({count - done, room, line_.room()});
      V* wave = line_.next();
      BoreLine<V, kChunk>& last = divided_ ? below_ : line_; // to the bore's end
      V* ending = last.next();
      if (delay_from_ == trip_.delay)
        last.read(first - above, kSilence, ending, part);
      else
        last.read_moving(delay_from_ - above, trip_.delay - above, phase, period(), kSilence,
                         ending, part);
      if (gliding_)
        travel_gliding(ending, out.radiated + done, phase, part);
      else
        travel(ending, divided_ ? parts_.below : trip_, out.radiated + done, part);
      if (divided_)
        pass_vent(wave, ending, phase, part);
      if (reed_moves_)
        for (int i = 0; i < part; ++i)
          moving_[index(i)] = ReedCoefficients<V>::at(
              constants_, omega_from_ + V((phase + i + 1) / period()) * (omega_to_ - omega_from_));
      const int substep_size = valve_moves_ ? kControlPeriod / kSubsteps * oversampling_ : part;
      for (int i = 0; i < part;) {
        const int into = valve_moves_ ? (phase + i) % substep_size : 0, at = done + i;
        if (valve_moves_ && into == 0)
          substep((phase + i) / substep_size);
        const int size = std::min(part - i, substep_size - into);
        step(reed_moves_ ? moving_.data() : &steady_, reed_moves_ ? 1 : 0,
             {mouth + at, noisy ? noise.data() + at : nullptr, wave + i, out.angle + at,
              out.bore_pressure + at, out.flow + at},
             size);
        i += size;
      }
      line_.advance(part);
      done += part;
    }
    if (holes_.active()) {
      radiation_.travel(out.radiated, count, steepening_length_);
      holes_.radiate(out.radiated, count);
    } else if (radiation_.steepens()) {
      radiation_.run(out.radiated, count, steepening_length_);
    }
    guard(out, count);
  }

  /// What the bore sends back, in place of what its end received, and what leaves it. Because the
  /// wave takes at least count samples through the bore, that is known before the valve moves.
  [[gnu::noinline, gnu::flatten]] void travel(V* wave, const RoundTrip& trip, double* radiated,
                                              int count) noexcept {
    typename RoundTripFilter<V>::Stretch filter(filter_, trip, radiation_.returning_share());
    if (holes_.active()) {
      for (int i = 0; i < count; ++i) {
        wave[i] = filter.arriving(wave[i]);
        radiated[i] = static_cast<double>(simd::lane(wave[i], 0));
      }
      holes_.reflect(wave, count);
    } else if (radiation_.steepens()) {
      for (int i = 0; i < count; ++i)
        wave[i] = filter(wave[i], radiated[i]);
    } else {
      RadiationPath::Exit exit(radiation_);
      for (int i = 0; i < count; ++i) {
        double leaving;
        wave[i] = filter(wave[i], leaving);
        radiated[i] = exit(leaving);
      }
    }
  }

  /// The same while bore and radiation change: their numbers run straight from sample to sample.
  void travel_gliding(V* wave, double* radiated, int phase, int count) noexcept {
    for (int i = 0; i < count; ++i) {
      const double share = (phase + i + 1) / period();
      radiation_.set(RadiationConstants::between(radiation_from_, radiation_to_, share));
      travel(wave + i, divided_ ? parts_.below : RoundTrip::between(trip_from_, trip_, share),
             radiated + i, 1);
    }
  }

  /// What the line above the vent sends back, and what the line below it receives.
  [[gnu::noinline, gnu::flatten]] void pass_vent(V* wave, V* below, int phase, int count) noexcept {
    line_.read(parts_.above.delay, kSilence, wave, count);
    typename RoundTripFilter<V>::Stretch losses(above_filter_, parts_.above, 0);
    const double step = (vent_to_ - vent_from_) / period();
    vent_filter_.pass(losses, wave, below, vent_from_ + step * phase, step, count);
    below_.advance(count);
  }

  void step(const ReedCoefficients<V>* coefficients, int stride, const ValveSignals<V>& signal,
            int count) noexcept {
    using Yes = std::true_type;
    using No = std::false_type;
    const auto go = [&](auto swinging, auto paper, auto plain) {
      step_valve<decltype(swinging)::value, decltype(paper)::value, decltype(plain)::value>(
          constants_, coefficients, stride, state_, signal, count);
    };
    if (constants_.swinging)
      constants_.paper ? go(Yes{}, Yes{}, No{}) : go(Yes{}, No{}, No{});
    else if (constants_.paper)
      go(No{}, Yes{}, No{});
    else if (constants_.bare() && stride == 0 && signal.noise == nullptr)
      go(No{}, No{}, Yes{});
    else
      go(No{}, No{}, No{});
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
      loudest_ = std::max({loudest_, even, odd});
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
    still_air();
  }

  [[nodiscard]] double period() const noexcept {
    return static_cast<double>(kControlPeriod * oversampling_);
  }
  static std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }

  double sample_rate_ = 0, slew_ = 1, at_once_ = 0;
  int oversampling_ = 1, phase_ = kControlPeriod;
  bool fresh_ = true, reed_moves_ = false, valve_moves_ = false, gliding_ = false, trip_due_ = true,
       steady_due_ = true;
  Parameters given_{}, parameters_{}; // the second with the tube that is played, if one is
  BoreDesign design_{};
  ValveConstants constants_{};
  ValveConstants from_{}, to_{}; // while the player moves the valve
  RoundTrip trip_{}, trip_from_{};
  RadiationConstants radiation_from_{}, radiation_to_{};
  double length_to_ = 0.48, delay_from_ = 3;
  double loudest_ = 0; // bore pressure since the last control period, Pa
  double steepening_length_ = 0.48;
  V omega_from_{1.0}, omega_to_{1.0}, mouth_{0.0};
  ReedCoefficients<V> steady_{};                     // while f_r stands
  std::array<ReedCoefficients<V>, kChunk> moving_{}; // while it moves
  ValveState<V> state_{};
  RoundTripFilter<V> filter_{};
  RadiationPath radiation_{};
  Player player_{};
  ParameterGlide glide_{};
  double trim_ = 0, trim_delay_ = 0, own_delay_ = 3;
  HoledEnd<V> holes_{};
  RegisterVent vent_{};
  VentFilter<V> vent_filter_{};
  RoundTripFilter<V> above_filter_{}; // of the line above the vent
  BoreDesign::Parts parts_{};         // while it is divided there
  bool divided_ = false;
  int shut_ = 0;                       // samples since the vent was open
  double vent_from_ = 0, vent_to_ = 0; // share that is open
  BoreLine<V, kChunk> line_, below_;
  Decimator<double, kChunk> radiated_decimator_{};
  std::array<Decimator<V, kChunk>, 3> decimators_{};
  Random random_{};
};

} // namespace tactus::reed
