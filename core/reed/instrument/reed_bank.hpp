#pragma once

#include "core/dsp/random.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_waveguide.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/instrument/control_period.hpp"
#include "core/reed/instrument/halfband.hpp"
#include "core/reed/instrument/moving_valve.hpp"
#include "core/reed/instrument/parameter_glide.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/player/player.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>

namespace tactus::reed {

/// One reed instrument (V = double), or several side by side in vector lanes (V = simd::Lanes):
/// valve, bore and player put together and advanced sample by sample. The lanes share parameters,
/// bore and player and differ in mouth pressure and reed frequency.
///
/// The parts are MovingValve (equations in valve_bore_step.hpp), BoreWaveguide, Player and
/// ParameterGlide; here are the clock that drives them, breath noise, oversampling and the checks
/// that keep the state bounded.
///
/// Controls are read once every kControlPeriod samples, counted from reset() whatever the blocks
/// are. They are low-passed with 5 ms and interpolated for each sample in between:
///
///   while samples are left:
///     if (bank.until_control() == 0) bank.control(reed frequency now, bore frequency now);
///     bank.run(mouth pressures, outputs, at most bank.until_control());
///
/// prepare() allocates; nothing else does.
template <class V> class ReedBank {
public:
  static constexpr int kControlPeriod = reed::kControlPeriod;
  static constexpr double kHighestPressure = 50e3; ///< Pa, of the mouth

  /// count samples each: radiated pressure at 1 m (Pa; of the first lane), theta (rad), p_b (Pa),
  /// U (m^3/s).
  struct Outputs {
    double* radiated;
    V* angle;
    V* bore_pressure;
    V* flow;
  };

  /// Allocates room for the longest bore at this sample rate, Hz. The same rate again changes
  /// nothing; another rate starts the air from rest.
  void prepare(double sample_rate) {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    bore_.prepare(sample_rate * kMaxOversampling);
    slew_ = 1 - std::exp(-kControlPeriod / (kSlewTime * sample_rate));
    max_immediate_step_ = kMaxImmediateRate * kControlPeriod / sample_rate;
    player_.prepare(sample_rate);
    glide_.prepare(sample_rate / kControlPeriod);
    starting_ = true;
    apply(parameters_);
    reset();
  }

  /// Takes the nearest usable parameters (clamped()). While a single reed sounds, numbers arrive
  /// within some 16 ms and switches in a short fade (ParameterGlide); several side by side take
  /// them at once. The state continues, within the new stops.
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
  /// The notes that the player refused.
  [[nodiscard]] const Refusal& refusal() const noexcept { return player_.refusal(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return bore_.length(); }

  /// Valve at rest, air still, noise from its beginning, at once.
  void reset() noexcept {
    starting_ = true;
    phase_ = kControlPeriod;
    random_.seed(parameters_.seed);
    valve_.reset();
    mouth_ = V(0.0);
    player_.reset();
    peak_pressure_ = 0;
    glide_.end_silence();
    if (sample_rate_ > 0)
      apply(parameters_);
    clear_air();
  }

  /// reset() of a single reed that sounds, without a click: the sound fades out first.
  void restart() noexcept {
    if (kSeveral || starting_)
      return reset();
    glide_.restart();
  }

  /// Whether the sound fades out for a change that cannot be interpolated.
  [[nodiscard]] bool fades_out() const noexcept { return glide_.fades_out(); }
  /// The player's tongue stops the breath for a moment and releases it.
  void articulate() noexcept { player_.articulate(); }
  /// Samples that run() may compute before control() is due.
  [[nodiscard]] int until_control() const noexcept { return kControlPeriod - phase_; }

  /// f_r in Hz for each lane (not above 0: the parameters' own), f_b in Hz (not above 0: the
  /// parameters' length).
  /// breath: the mouth pressure that the player's lips follow, Pa; below 0 they follow none.
  void control(const V& reed_frequency, double bore_frequency, double breath = -1) noexcept {
    phase_ = 0;
    flush_denormals();
    update_fades();
    const V nominal_frequency = simd::select((reed_frequency > V(0.0)) & (reed_frequency < V(1e9)),
                                             reed_frequency, V(glide_.current().reed_frequency));
    const Player::Configuration& configuration = player_.control(
        bore_frequency, static_cast<double>(simd::lane(nominal_frequency, 0)), breath);
    bore_.set_end(configuration.end);
    // A scalar reflection replaces losses and radiation: there is nothing to vent.
    bore_.set_vent(parameters_.scalar_reflection > 0 ? 0 : configuration.vent, starting_);
    valve_.end_period(starting_);
    bore_.end_period();
    const bool gliding = glide_.is_moving();
    if (gliding)
      advance_glide(configuration.valve);
    else if (configuration.valve_changed)
      follow_player(configuration.valve);
    if (configuration.trim != trim_ || configuration.valve_changed || gliding) {
      trim_ = configuration.trim;
      bore_.set_trim(trim_, configuration.length, glide_.current().shape);
    }
    update_omega(nominal_frequency, configuration.reed_scale);
    update_length(configuration.length);
    bore_.update_steepening_length(parameters_.steepening, player_.note(), starting_ ? 1 : slew_);
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
      run_chunk(mouth_pressure + done,
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
  /// 1/s: what moves by less than an octave in 30 ms is followed without delay.
  static constexpr double kMaxImmediateRate = 25;
  /// Up to this level noise is uniform and a share of the mouth pressure, which costs a fraction of
  /// the jet's own noise. It is too faint to matter that it continues when the valve shuts.
  static constexpr double kFaintNoise = kSeveral ? 1e-3 : 1e-5;
  static constexpr double kSilencePressure = 0.1; // Pa in the bore and the mouth: nothing sounds
  using Signal = std::array<V, kChunk>;

  /// Takes over clamped parameters at once.
  void apply(const Parameters& parameters) noexcept {
    const int before = oversampling_;
    parameters_ = parameters;
    if (!(sample_rate_ > 0))
      return;
    glide_.jump(parameters_);
    oversampling_ = oversampling_of(parameters_);
    bore_.set(parameters_, sample_rate_, oversampling_);
    update_player();
    valve_.restart_at(valve_constants(parameters_), starting_);
    if (oversampling_ != before)
      clear_air();
    bore_.set_length(std::clamp(bore_.length(), 5e-3, bore_.max_length()));
    bore_.jump_to_length();
  }

  /// Advances the fades of ParameterGlide; applies a change that waits until nothing is heard.
  void update_fades() noexcept {
    const bool silent =
        !kSeveral && peak_pressure_ < kSilencePressure && simd::lane(mouth_, 0) < kSilencePressure;
    peak_pressure_ = 0;
    if (glide_.fade() || (silent && glide_.fades_out()))
      change_in_silence();
    if (silent)
      glide_.end_silence();
    valve_.rest(silent);
  }

  void change_in_silence() noexcept {
    const bool restarted = glide_.restarts() || !can_continue(glide_.parameters(), parameters_);
    if (glide_.restarts())
      random_.seed(parameters_.seed);
    if (restarted)
      player_.reset();
    apply(parameters_);
    if (restarted) {
      valve_.reset();
      clear_air();
    }
    glide_.begin_silence(restarted);
  }

  void update_player() noexcept {
    BoreDesign bore;
    bore.set(parameters_, sample_rate_ * oversampling_);
    player_.set(parameters_, bore);
  }

  [[nodiscard]] ValveConstants valve_constants(const Parameters& parameters) const noexcept {
    return ValveConstants::from(parameters, bore_.design(), sample_rate_ * oversampling_);
  }

  /// One step of valve, bore and radiation towards the target of the glide.
  void advance_glide(const Parameters& target) noexcept {
    glide_.move(target);
    bore_.glide_to(glide_.current());
    valve_.move_to(valve_constants(glide_.current()));
  }

  /// Lips and valve as the player holds them: within this control period while a note sounds, else
  /// at once.
  void follow_player(const Parameters& valve) noexcept {
    glide_.follow(valve);
    if (player_.plays() && !starting_)
      valve_.move_to(valve_constants(valve));
    else
      valve_.jump_to(valve_constants(valve), starting_);
  }

  /// omega_r = 2 pi f_r, f_r within 1 Hz to 0.45 of the sample rate.
  void update_omega(const V& nominal_frequency, double reed_scale) noexcept {
    constexpr double kTwoPi = 2 * std::numbers::pi;
    const V target =
        V(kTwoPi * reed_scale) *
        simd::minimum(simd::maximum(nominal_frequency, V(1.0)), V(0.45 * sample_rate_));
    const bool played = player_.plays();
    const V from = starting_ ? target : valve_.omega();
    V to = from + slewed(target - from, from, played);
    to = simd::select(simd::absolute(target - to) < V(1e-6) * target, target, to);
    valve_.set_omega(from, to, played, starting_);
  }

  void update_length(double target) noexcept {
    const double current = bore_.length();
    const double next =
        starting_
            ? target
            : current + simd::lane(slewed(V(target - current), V(current), player_.plays()), 0);
    bore_.set_length(std::abs(target - next) < 1e-7 * target ? target : next);
    if (starting_)
      bore_.jump_to_length();
  }

  /// The step of a control period towards a target at this difference: a one-pole low-pass of
  /// kSlewTime. Of what a player moves, the part below kMaxImmediateRate is followed at once, so
  /// that glides and vibrato have no delay; only the rest of a leap is low-passed.
  [[nodiscard]] V slewed(const V& difference, const V& size, bool played) const noexcept {
    const V part = V(slew_) * difference;
    if (!played)
      return part;
    const V room =
        simd::minimum(simd::absolute(difference), V(max_immediate_step_) * simd::absolute(size));
    return simd::copy_sign(simd::maximum(simd::absolute(part), room), difference);
  }

  void clear_air() noexcept {
    bore_.clear();
    valve_.clear_air();
    radiated_decimator_.reset();
    for (auto& decimator : decimators_)
      decimator.reset();
  }

  void flush_denormals() noexcept {
    constexpr double kLimit = BoreWaveguide<V, kChunk>::kDenormalLimit;
    valve_.each(
        [](V& value) { value = simd::select(simd::absolute(value) < V(kLimit), V(0.0), value); });
    bore_.flush_denormals();
  }

  /// samples of the host, of at most kChunk internal samples in all.
  void run_chunk(const V* mouth_pressure, const Outputs& out, int samples) noexcept {
    if (oversampling_ == 1) {
      mouth_ = mouth_pressure[samples - 1];
      advance(mouth_pressure, out, samples);
    } else {
      advance_oversampled(mouth_pressure, out, samples);
    }
    if (player_.tracks_pitch()) {
      std::array<double, kChunk> pitch_samples;
      for (int i = 0; i < samples; ++i)
        pitch_samples[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      player_.track_pitch(pitch_samples.data(), samples);
    }
  }

  /// The mouth pressure is interpolated linearly, the outputs are decimated by half-band filters.
  void advance_oversampled(const V* mouth_pressure, const Outputs& out, int samples) noexcept {
    const int count = samples * oversampling_;
    Signal mouth{}, angle, bore, flow;
    std::array<double, kChunk> radiated;
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
      const int part = bore_.block_size(phase, count - done);
      V* wave = bore_.propagate(phase, out.radiated + done, part);
      valve_.run({mouth + done, noisy ? noise.data() + done : nullptr, wave, out.angle + done,
                  out.bore_pressure + done, out.flow + done},
                 phase, part, oversampling_);
      bore_.advance(part);
      done += part;
    }
    bore_.radiate(out.radiated, count);
    restart_if_unbounded(out, count);
  }

  /// The paper's explicit flow and the force of the flow (mu) can feed in energy without bound for
  /// absurd parameters: then the model restarts from rest.
  void restart_if_unbounded(const Outputs& out, int count) noexcept {
    constexpr double kMaxPressure = 1e9; // Pa
    bool bounded = true;
    if constexpr (std::is_same_v<V, double>) {
      V even(0.0), odd(0.0); // two maxima: each waits only for itself
      int i = 0;
      for (; i + 1 < count; i += 2) {
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
        odd = simd::maximum(simd::absolute(out.bore_pressure[i + 1]), odd);
      }
      if (i < count)
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
      peak_pressure_ = std::max({peak_pressure_, even, odd});
      bounded = simd::maximum(even, odd) < kMaxPressure;
    } else { // a mask per comparison: no chain at all
      const V limit(kMaxPressure);
      auto within = simd::absolute(out.bore_pressure[0]) < limit;
      for (int i = 1; i < count; ++i)
        within = within & (simd::absolute(out.bore_pressure[i]) < limit);
      bounded = !simd::any(!within);
    }
    if (bounded && valve_.is_bounded() && bore_.is_bounded())
      return;
    std::fill_n(out.radiated, count, 0.0);
    for (V* signal : {out.angle, out.bore_pressure, out.flow})
      std::fill_n(signal, count, V(0.0));
    valve_.reset();
    clear_air();
  }

  static std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }

  double sample_rate_ = 0, slew_ = 1, max_immediate_step_ = 0;
  int oversampling_ = 1, phase_ = kControlPeriod; // samples since control()
  bool starting_ = true;                          // nothing has sounded yet
  Parameters requested_{}, parameters_{}; // the second with the tube that is played, if one is
  double trim_ = 0;
  double peak_pressure_ = 0; // bore pressure since the last control period, Pa
  V mouth_{0.0};
  MovingValve<V, kChunk> valve_{};
  BoreWaveguide<V, kChunk> bore_{};
  Player player_{};
  ParameterGlide glide_{};
  Decimator<double, kChunk> radiated_decimator_{};
  std::array<Decimator<V, kChunk>, 3> decimators_{};
  Random random_{};
};

} // namespace tactus::reed
