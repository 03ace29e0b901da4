#pragma once

#include "core/dsp/random.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore_design.hpp"
#include "core/reed/bore_line.hpp"
#include "core/reed/ear.hpp"
#include "core/reed/halfband.hpp"
#include "core/reed/holed_end.hpp"
#include "core/reed/parameters.hpp"
#include "core/reed/radiation_path.hpp"
#include "core/reed/round_trip_filter.hpp"
#include "core/reed/tuning.hpp"
#include "core/reed/valve_bore_step.hpp"

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
    line_.prepare(longest_delay(sample_rate * kMostOversampling));
    slew_ = 1 - std::exp(-kControlPeriod / (kSlewTime * sample_rate));
    ear_.prepare(sample_rate);
    apply(parameters_);
    reset();
  }

  /// Takes over clamped parameters; the state goes on, within the new stops.
  void set(const Parameters& parameters) noexcept { apply(parameters); }
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  /// L in use, m.
  [[nodiscard]] double length() const noexcept { return length_to_; }

  void reset() noexcept {
    fresh_ = true;
    phase_ = kControlPeriod;
    random_.seed(parameters_.seed);
    state_ = {};
    mouth_ = V(0.0);
    ear_.reset();
    still_air();
  }

  /// Samples that run() may compute before control() is due.
  [[nodiscard]] int until_control() const noexcept { return kControlPeriod - phase_; }

  /// f_r in Hz for each lane (not above 0: the parameters' own), f_b in Hz (not above 0: the
  /// parameters' length).
  void control(const V& reed_frequency, double bore_frequency) noexcept {
    using simd::absolute, simd::any, simd::select;
    phase_ = 0;
    quieten();
    constexpr double kTwoPi = 2 * std::numbers::pi;
    const V given = select((reed_frequency > V(0.0)) & (reed_frequency < V(1e9)), reed_frequency,
                           V(parameters_.reed_frequency));
    if (!(bore_frequency == bore_frequency_)) { // false also for a first NaN
      bore_frequency_ = bore_frequency > 0 && bore_frequency < 1e9 ? bore_frequency : 0;
      length_due_ = true;
    }
    if (length_due_)
      choose_length(static_cast<double>(simd::lane(given, 0)));
    if (listens_)
      trim(ear_.trim());
    const V target = V(kTwoPi * reed_scale_) *
                     simd::minimum(simd::maximum(given, V(1.0)), V(0.45 * sample_rate_));
    omega_from_ = fresh_ ? target : omega_to_;
    omega_to_ = omega_from_ + V(slew_) * (target - omega_from_);
    omega_to_ = select(absolute(target - omega_to_) < V(1e-6) * target, target, omega_to_);
    const auto moving = (omega_from_ < omega_to_) | (omega_to_ < omega_from_);
    const bool moved = reed_moves_;
    reed_moves_ = any(moving);
    if (!reed_moves_ && (moved || steady_due_ || fresh_)) {
      steady_ = ReedCoefficients<V>::at(constants_, omega_to_);
      steady_due_ = false;
    }

    const double next =
        fresh_ ? length_target_ : length_to_ + slew_ * (length_target_ - length_to_);
    move_bore(std::abs(length_target_ - next) < 1e-7 * length_target_ ? length_target_ : next);
    if (fresh_)
      delay_from_ = trip_.delay;
    fresh_ = false;
  }

  /// Computes count <= until_control() samples; mouth pressures in Pa, finite, within +-50 kPa.
  void run(const V* mouth_pressure, const Outputs& out, int count) noexcept {
    const int most = kChunk / oversampling_;
    for (int done = 0; done < count;) {
      const int samples = std::min(count - done, most);
      chunk(mouth_pressure + done,
            {out.radiated + done, out.angle + done, out.bore_pressure + done, out.flow + done},
            samples);
      done += samples;
      phase_ += samples;
    }
  }

private:
  static constexpr int kChunk = 64; // internal samples computed in one go
  static constexpr int kMostOversampling = 4;
  static constexpr double kSlewTime = 5e-3; // s
  static constexpr double kSilence = 1e-20; // below, a state is nothing: denormals are dear
  using Signal = std::array<V, kChunk>;

  void apply(const Parameters& parameters) noexcept {
    const int before = oversampling_;
    parameters_ = clamped(parameters);
    if (!(sample_rate_ > 0))
      return;
    oversampling_ = oversampling_of(parameters_);
    const double rate = sample_rate_ * oversampling_;
    design_.set(parameters_, rate);
    const ValveConstants old = constants_;
    constants_ = ValveConstants::from(parameters_, design_, rate);
    radiation_.set(RadiationConstants::from(parameters_, design_, rate));
    holes_.set(rate, design_.air().sound_speed / air_at(20).sound_speed, parameters_.input_radius);
    ear_.forget();
    place_valve(old);
    steady_ = ReedCoefficients<V>::at(constants_, omega_to_);
    steady_due_ = true;
    if (oversampling_ != before)
      still_air();
    length_due_ = true;
    length_to_ = std::clamp(length_to_, 5e-3, design_.longest());
    move_bore(length_to_);
    delay_from_ = trip_.delay;
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
    if (constants_.inertance_rate != old.inertance_rate)
      state_.inertance_flow = V(0.0);
    if (constants_.compliance_rate != old.compliance_rate)
      state_.compliance_flow = V(0.0);
    state_.remember(constants_);
  }

  void choose_length(double reed_frequency) noexcept {
    length_due_ = false;
    Playing playing{parameters_, parameters_.length};
    const double note = note_of(parameters_, bore_frequency_);
    const double f = std::clamp(note, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
    listens_ = parameters_.tune && note > 0 && !(parameters_.length_override > 0);
    if (listens_)
      playing = tuned(parameters_, f, reed_frequency);
    if (playing.end != design_.end()) {
      design_.set_end(playing.end);
      holes_.finger(playing.end);
      trip_due_ = true;
    }
    if (!listens_ && note > 0)
      playing.length = design_.length_for(f);
    if (parameters_.length_override > 0)
      playing.length = parameters_.length_override;
    length_target_ = std::clamp(playing.length, 5e-3, design_.longest());
    own_scale_ = playing.reed_scale;
    const ValveConstants old = constants_;
    constants_ = ValveConstants::from(playing.valve, design_, sample_rate_ * oversampling_);
    place_valve(old);
    steady_due_ = true;
    listens_ = listens_ && parameters_.ear;
    if (listens_)
      ear_.mean(f);
    trim(listens_ ? ear_.trim() : 0);
  }

  /// Plays sharper by exp(logarithm): the bore shorter, the lips tighter where they are the
  /// player's to choose. A change that nobody hears is left out, for a bore at rest is cheaper.
  void trim(double logarithm) noexcept {
    constexpr double kInaudible = 1e-4; // 0.17 cents
    if (std::abs(logarithm - trim_) < kInaudible && logarithm != 0 && trim_scale_ == own_scale_)
      return;
    trim_ = logarithm;
    trim_scale_ = own_scale_;
    reed_scale_ = parameters_.embouchure > 0 ? own_scale_ * std::exp(logarithm) : own_scale_;
    const double acoustic = design_.air().sound_speed / design_.ideal_frequency(length_target_) /
                            (parameters_.shape == BoreShape::kCone ? 2 : 4);
    trim_delay_ = 2 * acoustic * std::expm1(-logarithm) / design_.air().sound_speed * sample_rate_ *
                  oversampling_;
  }

  void move_bore(double length) noexcept {
    delay_from_ = trip_.delay;
    if (length != length_to_ || trip_due_ || length_due_) {
      length_to_ = length;
      trip_ = design_.round_trip(length);
      own_delay_ = trip_.delay;
      trip_due_ = false;
    }
    // A trim changes the delay alone: what it would change in the losses is inaudible.
    trip_.delay = std::clamp(own_delay_ + trim_delay_, 3.0,
                             static_cast<double>(longest_delay(sample_rate_ * oversampling_)));
  }

  void still_air() noexcept {
    line_.clear();
    filter_.reset();
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
    for (V* value :
         {&state_.jet_velocity, &state_.flow, &state_.inertance_flow, &state_.compliance_flow,
          &state_.past, &state_.place, &state_.speed, &state_.pressure, &state_.moved_by})
      quieten(*value);
    filter_.each([](auto& value) { quieten(value); });
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
      Signal mouth, angle, bore, flow;
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
    if (listens_) {
      std::array<double, kChunk> heard;
      for (int i = 0; i < samples; ++i)
        heard[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      ear_.listen(heard.data(), samples);
    }
  }

  /// count internal samples.
  void advance(const V* mouth, const Outputs& out, int count) noexcept {
    std::array<double, kChunk> noise;
    const bool noisy = parameters_.breath_noise > 0;
    if (noisy) {
      // The same power in each hertz at any rate; never more than what drives the jet.
      const double size = parameters_.breath_noise * std::sqrt(sample_rate_ * oversampling_ / 48e3);
      for (int i = 0; i < count; ++i)
        noise[index(i)] = std::clamp(size * random_.normal(), -0.9, 0.9);
    }
    for (int done = 0; done < count;) {
      const int phase = phase_ * oversampling_ + done;
      const double first = delay_from_ + phase / period() * (trip_.delay - delay_from_);
      const int room = static_cast<int>(std::min(first, trip_.delay)) - 1;
      const int part = std::min({count - done, room, line_.room()});
      V* wave = line_.next();
      if (delay_from_ == trip_.delay)
        line_.read(first, kSilence, wave, part);
      else
        line_.read_moving(delay_from_, trip_.delay, phase, period(), kSilence, wave, part);
      travel(wave, out.radiated + done, part);
      if (reed_moves_)
        for (int i = 0; i < part; ++i)
          moving_[index(i)] = ReedCoefficients<V>::at(
              constants_, omega_from_ + V((phase + i + 1) / period()) * (omega_to_ - omega_from_));
      step(reed_moves_ ? moving_.data() : &steady_, reed_moves_ ? 1 : 0,
           {mouth + done, noisy ? noise.data() + done : nullptr, wave, out.angle + done,
            out.bore_pressure + done, out.flow + done},
           part);
      line_.advance(part);
      done += part;
    }
    if (holes_.active()) {
      radiation_.travel(out.radiated, count, length_to_);
      holes_.radiate(out.radiated, count);
    } else if (radiation_.steepens()) {
      radiation_.run(out.radiated, count, length_to_);
    }
    guard(out, count);
  }

  /// What the bore sends back, in place of what its end received, and what leaves it. Because the
  /// wave takes at least count samples through the bore, that is known before the valve moves.
  [[gnu::noinline, gnu::flatten]] void travel(V* wave, double* radiated, int count) noexcept {
    typename RoundTripFilter<V>::Stretch filter(filter_, trip_, radiation_.returning_share());
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
      sane = !beyond(simd::maximum(even, odd), 1e9);
    } else { // lanes have masks, which do not wait
      const V limit(1e9);
      auto within = simd::absolute(out.bore_pressure[0]) < limit;
      for (int i = 1; i < count; ++i)
        within = within & (simd::absolute(out.bore_pressure[i]) < limit);
      sane = !simd::any(!within);
    }
    if (sane && !beyond(state_.bore_pressure(), 1e9) && !beyond(state_.jet_velocity, 1e6) &&
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

  double sample_rate_ = 0, slew_ = 1;
  int oversampling_ = 1, phase_ = kControlPeriod;
  bool fresh_ = true, reed_moves_ = false, length_due_ = true, trip_due_ = true, steady_due_ = true;
  Parameters parameters_{};
  BoreDesign design_{};
  ValveConstants constants_{};
  RoundTrip trip_{};
  double bore_frequency_ = 0, length_target_ = 0.48, length_to_ = 0.48, delay_from_ = 3;
  V omega_from_{1.0}, omega_to_{1.0}, mouth_{0.0};
  ReedCoefficients<V> steady_{};                     // while f_r stands
  std::array<ReedCoefficients<V>, kChunk> moving_{}; // while it moves
  ValveState<V> state_{};
  RoundTripFilter<V> filter_{};
  RadiationPath radiation_{};
  HoledEnd<V> holes_{};
  Ear ear_{};
  bool listens_ = false;
  double own_scale_ = 1, reed_scale_ = 1; // of f_r: the player's choice, and trimmed
  double trim_ = 0, trim_scale_ = 1, trim_delay_ = 0, own_delay_ = 3;
  BoreLine<V, kChunk> line_;
  Decimator<double, kChunk> radiated_decimator_{};
  std::array<Decimator<V, kChunk>, 3> decimators_{};
  Random random_{};
};

} // namespace tactus::reed
