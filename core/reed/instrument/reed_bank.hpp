#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_waveguide.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/instrument/breath_noise.hpp"
#include "core/reed/instrument/change_fade.hpp"
#include "core/reed/instrument/control_slew.hpp"
#include "core/reed/instrument/moving_valve.hpp"
#include "core/reed/instrument/oversampler.hpp"
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
/// The parts are MovingValve (equations in valve_bore_step.hpp), BoreWaveguide and BreathNoise;
/// Player, ControlSlew, ParameterGlide and ChangeFade, which move their settings; and Oversampler.
/// This class has the clock that drives them and the check that keeps the state bounded.
///
/// Controls are read once every kControlPeriod samples, counted from reset(), whatever the size of
/// the blocks. They are low-passed with 5 ms and interpolated for each sample in between:
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

  using Outputs = ReedOutputs<V>;

  /// Allocates room for the longest bore at this sample rate, Hz. The same rate again changes
  /// nothing; another rate starts the air from rest.
  void prepare(double sample_rate) {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    bore_.prepare(sample_rate * kMaxOversampling);
    slew_.prepare(sample_rate);
    player_.prepare(sample_rate);
    glide_.prepare(sample_rate / kControlPeriod);
    fade_.prepare(sample_rate / kControlPeriod);
    starting_ = true;
    apply(parameters_);
    reset();
  }

  /// Takes the nearest usable parameters (clamped()). While a single reed sounds, numbers reach
  /// their new values within about 16 ms, and switches change in a short fade (ChangeFade). Several
  /// reeds side by side take all changes at once. The state continues, within the new stops.
  void set(const Parameters& parameters) noexcept {
    requested_ = clamped(parameters);
    const Parameters target = with_brass_tube(requested_);
    if (kSeveral || starting_ || !(sample_rate_ > 0))
      return apply(target);
    if (target == parameters_)
      return;
    parameters_ = target;
    if (fade_.fades_out() || !can_interpolate(glide_.parameters(), target))
      return fade_.begin();
    glide_.begin(target);
    update_player();
  }
  [[nodiscard]] const Parameters& parameters() const noexcept { return requested_; }
  /// Sets holes fingered one by one (Player::finger).
  void finger(const Termination* holes, double vent = 0) noexcept { player_.finger(holes, vent); }
  /// The notes that the player refused.
  [[nodiscard]] const Refusal& refusal() const noexcept { return player_.refusal(); }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return bore_.length(); }

  /// Sets valve and air to rest and restarts the noise sequence, at once.
  void reset() noexcept {
    starting_ = true;
    phase_ = kControlPeriod;
    noise_.seed(parameters_.seed);
    valve_.reset();
    oversampler_.set_mouth_pressure(V(0.0));
    player_.reset();
    peak_pressure_ = 0;
    fade_.end_silence();
    if (sample_rate_ > 0)
      apply(parameters_);
    clear_air();
  }

  /// reset() of a single reed that sounds, without a click: the sound fades out first.
  void restart() noexcept {
    if (kSeveral || starting_)
      return reset();
    fade_.begin_restart();
  }

  /// Whether the sound fades out for a change that cannot be interpolated.
  [[nodiscard]] bool fades_out() const noexcept { return fade_.fades_out(); }
  /// The player's tongue stops the breath for a moment and releases it.
  void articulate() noexcept { player_.articulate(); }
  /// Samples that run() may compute before control() is due.
  [[nodiscard]] int until_control() const noexcept { return kControlPeriod - phase_; }

  /// f_r in Hz for each lane (0 or less: that of the parameters), f_b in Hz (0 or less: the
  /// parameters' length). breath: the mouth pressure that the player's lips follow, Pa; below 0
  /// they follow none.
  void control(const V& reed_frequency, double bore_frequency, double breath = -1) noexcept {
    phase_ = 0;
    flush_denormals();
    update_fade();
    const V nominal_frequency = simd::select((reed_frequency > V(0.0)) & (reed_frequency < V(1e9)),
                                             reed_frequency, V(glide_.current().reed_frequency));
    const Player::Configuration& configuration = player_.control(
        bore_frequency, static_cast<double>(simd::lane(nominal_frequency, 0)), breath);
    bore_.set_end(configuration.end);
    // A scalar reflection replaces losses and radiation, so there is nothing to vent.
    bore_.set_vent(parameters_.scalar_reflection > 0 ? 0 : configuration.vent, starting_);
    valve_.end_period(starting_);
    bore_.end_period();
    const bool gliding = glide_.is_moving() && !fade_.fades_out();
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
    bore_.update_steepening_length(parameters_.steepening, player_.note(),
                                   starting_ ? 1 : slew_.gain());
    starting_ = false;
  }

  /// Computes count <= until_control() samples; mouth pressures in Pa, finite, within +-50 kPa.
  void run(const V* mouth_pressure, const Outputs& out, int count) noexcept {
    const int max_samples = kChunk / oversampling_, phase = phase_;
    std::array<V, kControlPeriod> breath;
    std::copy_n(mouth_pressure, count, breath.begin());
    player_.apply_tongue(breath.data(), count, kHighestPressure);
    fade_.apply_to_breath(breath.data(), phase, count);
    for (int done = 0; done < count;) {
      const int samples = std::min(count - done, max_samples);
      run_chunk(breath.data() + done,
                {out.radiated + done, out.angle + done, out.bore_pressure + done, out.flow + done},
                samples);
      done += samples;
      phase_ += samples;
    }
    fade_.apply_to(out, phase, count);
  }

private:
  static constexpr bool kSeveral = !std::is_same_v<V, double>;
  static constexpr int kChunk = 64; // internal samples computed in one go
  static constexpr int kMaxOversampling = 4;
  static constexpr double kSilencePressure = 0.1; // Pa in the bore and the mouth: nothing sounds

  /// Takes over clamped parameters at once.
  void apply(const Parameters& parameters) noexcept {
    const int before = oversampling_;
    parameters_ = parameters;
    if (!(sample_rate_ > 0))
      return;
    glide_.jump(parameters_);
    fade_.changed();
    oversampling_ = oversampling_of(parameters_);
    bore_.set(parameters_, sample_rate_, oversampling_);
    update_player();
    valve_.restart_at(valve_constants(parameters_), starting_);
    if (oversampling_ != before)
      clear_air();
    bore_.set_length(std::clamp(bore_.length(), 5e-3, bore_.max_length()));
    bore_.jump_to_length();
  }

  /// Advances the fade, and makes a waiting change once nothing is heard.
  void update_fade() noexcept {
    const bool silent = !kSeveral && peak_pressure_ < kSilencePressure &&
                        simd::lane(oversampler_.mouth_pressure(), 0) < kSilencePressure;
    peak_pressure_ = 0;
    if (fade_.step() || (silent && fade_.fades_out()))
      change_in_silence();
    if (silent)
      fade_.end_silence();
    valve_.rest(silent);
  }

  void change_in_silence() noexcept {
    const bool restarted = fade_.restarts() || !can_continue(glide_.parameters(), parameters_);
    if (fade_.restarts())
      noise_.seed(parameters_.seed);
    if (restarted)
      player_.reset();
    apply(parameters_);
    if (restarted) {
      valve_.reset();
      clear_air();
    }
    fade_.begin_silence(restarted);
  }

  void update_player() noexcept {
    BoreDesign bore;
    bore.set(parameters_, sample_rate_ * oversampling_);
    player_.set(parameters_, bore);
  }

  [[nodiscard]] ValveConstants valve_constants(const Parameters& parameters) const noexcept {
    return ValveConstants::from(parameters, bore_.design(), sample_rate_ * oversampling_);
  }

  /// Moves valve, bore and radiation by one step towards the target of the glide.
  void advance_glide(const Parameters& target) noexcept {
    glide_.move(target);
    bore_.glide_to(glide_.current());
    valve_.move_to(valve_constants(glide_.current()));
  }

  /// Sets lips and valve as the player chooses: within this control period while a note sounds,
  /// else at once.
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
    V to = from + slew_.step(target - from, from, played);
    to = simd::select(simd::absolute(target - to) < V(1e-6) * target, target, to);
    valve_.set_omega(from, to, played, starting_);
  }

  void update_length(double target) noexcept {
    const double current = bore_.length();
    const double next =
        starting_
            ? target
            : current + simd::lane(slew_.step(V(target - current), V(current), player_.plays()), 0);
    bore_.set_length(std::abs(target - next) < 1e-7 * target ? target : next);
    if (starting_)
      bore_.jump_to_length();
  }

  void clear_air() noexcept {
    bore_.clear();
    valve_.clear_air();
    oversampler_.reset();
  }

  void flush_denormals() noexcept {
    constexpr double kLimit = BoreWaveguide<V, kChunk>::kDenormalLimit;
    valve_.each(
        [](V& value) { value = simd::select(simd::absolute(value) < V(kLimit), V(0.0), value); });
    bore_.flush_denormals();
  }

  /// Computes samples of the host, at most kChunk internal samples in all.
  void run_chunk(const V* mouth_pressure, const Outputs& out, int samples) noexcept {
    oversampler_.run(oversampling_, mouth_pressure, out, samples,
                     [this](const V* mouth, const Outputs& internal, int count) {
                       advance(mouth, internal, count);
                     });
    if (player_.tracks_pitch()) {
      std::array<double, kChunk> pitch_samples;
      for (int i = 0; i < samples; ++i)
        pitch_samples[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      player_.track_pitch(pitch_samples.data(), samples);
    }
  }

  /// Computes `count` internal samples.
  void advance(const V* mouth, const Outputs& out, int count) noexcept {
    const auto [breath, noise] =
        noise_.draw(mouth, glide_.current().breath_noise, sample_rate_ * oversampling_, count);
    for (int done = 0; done < count;) {
      const int phase = phase_ * oversampling_ + done;
      const int part = bore_.block_size(phase, count - done);
      V* wave = bore_.propagate(phase, out.radiated + done, part);
      valve_.run({breath + done, noise != nullptr ? noise + done : nullptr, wave, out.angle + done,
                  out.bore_pressure + done, out.flow + done},
                 phase, part, oversampling_);
      bore_.advance(part);
      done += part;
    }
    bore_.radiate(out.radiated, count);
    restart_if_unbounded(out, count);
  }

  /// The paper's explicit flow and the force of the flow (mu) can feed in energy without bound for
  /// extreme parameters. Then the model restarts from rest.
  void restart_if_unbounded(const Outputs& out, int count) noexcept {
    constexpr double kMaxPressure = 1e9; // Pa
    bool bounded = true;
    if constexpr (std::is_same_v<V, double>) {
      V even(0.0), odd(0.0); // two maxima, neither of which waits for the other
      int i = 0;
      for (; i + 1 < count; i += 2) {
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
        odd = simd::maximum(simd::absolute(out.bore_pressure[i + 1]), odd);
      }
      if (i < count)
        even = simd::maximum(simd::absolute(out.bore_pressure[i]), even);
      peak_pressure_ = std::max({peak_pressure_, even, odd});
      bounded = simd::maximum(even, odd) < kMaxPressure;
    } else { // a mask per comparison, without any dependency chain
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

  double sample_rate_ = 0;
  int oversampling_ = 1, phase_ = kControlPeriod; // phase_: samples since control()
  bool starting_ = true;                          // nothing has sounded yet
  Parameters requested_{}, parameters_{}; // parameters_: with the tube of a brass instrument, if
                                          // one is played
  double trim_ = 0;
  double peak_pressure_ = 0; // bore pressure since the last control period, Pa
  MovingValve<V, kChunk> valve_{};
  BoreWaveguide<V, kChunk> bore_{};
  Player player_{};
  ControlSlew<V> slew_{};
  ParameterGlide glide_{};
  ChangeFade fade_{};
  BreathNoise<V, kChunk> noise_{};
  Oversampler<V, kChunk> oversampler_{};
};

} // namespace tactus::reed
