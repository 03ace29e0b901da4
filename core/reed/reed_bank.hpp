#pragma once

#include "core/dsp/random.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore_design.hpp"
#include "core/reed/ear.hpp"
#include "core/reed/halfband.hpp"
#include "core/reed/parameters.hpp"
#include "core/reed/radiation_path.hpp"
#include "core/reed/tuning.hpp"
#include "core/reed/valve_bore_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

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

  /// count samples each: radiated pressure at 1 m (Pa; the first lane's, in all lanes), theta
  /// (rad), p_b (Pa), U (m^3/s).
  struct Outputs {
    V* radiated;
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
    const int longest = longest_delay(sample_rate * kMostOversampling) + kChunk + 8;
    std::size_t size = 1;
    while (size < static_cast<std::size_t>(longest))
      size *= 2;
    line_.assign(size, V(0.0));
    mask_ = static_cast<std::ptrdiff_t>(size) - 1;
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
    const V target =
        V(kTwoPi * reed_scale_) * simd::minimum(simd::maximum(given, V(1.0)), V(0.45 * sample_rate_));
    omega_from_ = fresh_ ? target : omega_to_;
    omega_to_ = omega_from_ + V(slew_) * (target - omega_from_);
    omega_to_ = select(absolute(target - omega_to_) < V(1e-6) * target, target, omega_to_);
    const auto moving = (omega_from_ < omega_to_) | (omega_to_ < omega_from_);
    reed_moves_ = any(moving);
    if (!reed_moves_)
      steady_ = ReedCoefficients<V>::at(constants_, omega_to_);

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
  using Stage1 = Halfband<V, 4, kChunk>;
  using Stage2 = Halfband<V, 8, kChunk>;

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
    place_valve(old);
    steady_ = ReedCoefficients<V>::at(constants_, omega_to_);
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
        V(turn) * (state_.deflection + V(old.rest_opening)) - V(constants_.rest_opening);
    const V low(constants_.lowest), high(constants_.highest);
    state_.velocity =
        simd::select((wanted < low) | (wanted > high), V(0.0), V(turn) * state_.velocity);
    state_.deflection = simd::minimum(simd::maximum(wanted, low), high);
    if (constants_.inertance_rate != old.inertance_rate)
      state_.inertance_flow = V(0.0);
    if (constants_.compliance_rate != old.compliance_rate)
      state_.compliance_flow = V(0.0);
    state_.remember(constants_);
  }

  void choose_length(double reed_frequency) noexcept {
    length_due_ = false;
    Playing playing{parameters_, parameters_.length};
    const double f =
        std::clamp(bore_frequency_, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
    listens_ = parameters_.tune && bore_frequency_ > 0 && !(parameters_.length_override > 0);
    if (listens_)
      playing = tuned(parameters_, f, reed_frequency);
    else if (bore_frequency_ > 0)
      playing.length = design_.length_for(f);
    if (parameters_.length_override > 0)
      playing.length = parameters_.length_override;
    length_target_ = std::clamp(playing.length, 5e-3, design_.longest());
    own_scale_ = playing.reed_scale;
    const ValveConstants old = constants_;
    constants_ = ValveConstants::from(playing.valve, design_, sample_rate_ * oversampling_);
    place_valve(old);
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
    trim_delay_ = 2 * acoustic * std::expm1(-logarithm) / design_.air().sound_speed *
                  sample_rate_ * oversampling_;
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
    trip_.delay =
        std::clamp(own_delay_ + trim_delay_, 3.0,
                   static_cast<double>(longest_delay(sample_rate_ * oversampling_)));
  }

  void still_air() noexcept {
    std::fill(line_.begin(), line_.end(), V(0.0));
    filter_ = {};
    radiation_.reset();
    const V deflection = state_.deflection, velocity = state_.velocity;
    state_ = {};
    state_.deflection = deflection;
    state_.velocity = velocity;
    for (auto& stage : stage1_)
      stage.reset();
    for (auto& stage : stage2_)
      stage.reset();
  }

  static void quieten(V& value) noexcept {
    value = simd::select(simd::absolute(value) < V(kSilence), V(0.0), value);
  }
  void quieten() noexcept {
    quieten(state_.deflection);
    quieten(state_.velocity);
    quieten(state_.jet_velocity);
    quieten(state_.flow);
    quieten(state_.bore_pressure);
    quieten(state_.inertance_flow);
    quieten(state_.compliance_flow);
    quieten(state_.past);
    for (V& value : filter_.state)
      quieten(value);
    radiation_.quieten();
  }

  void chunk(const V* mouth_pressure, const Outputs& out, int samples) noexcept {
    const int count = samples * oversampling_;
    Signal mouth, wave, radiated, deflection, bore, flow;
    std::array<double, kChunk> noise;
    // The mouth pressure runs straight from sample to sample.
    const V share(1.0 / oversampling_);
    for (int n = 0, i = 0; n < samples; ++n) {
      const V rise = share * (mouth_pressure[n] - mouth_);
      for (int k = 1; k < oversampling_; ++k)
        mouth[index(i++)] = mouth_ + V(static_cast<double>(k)) * rise;
      mouth[index(i++)] = mouth_ = mouth_pressure[n];
    }
    const bool noisy = parameters_.breath_noise > 0;
    if (noisy) {
      // The same power in each hertz at any rate; never more than what drives the jet.
      const double size = parameters_.breath_noise * std::sqrt(sample_rate_ * oversampling_ / 48e3);
      for (int i = 0; i < count; ++i)
        noise[index(i)] = std::clamp(size * random_.normal(), -0.9, 0.9);
    }
    for (int done = 0; done < count;) {
      const double phase = (phase_ * oversampling_ + done) / period();
      const double first = delay_from_ + phase * (trip_.delay - delay_from_);
      const int room = static_cast<int>(std::min(first, trip_.delay)) - 1;
      const int part = std::min(count - done, room);
      read_line(wave.data() + done, phase, part);
      filter_.run(trip_, wave.data() + done, radiated.data() + done, radiation_.returning_share(),
                  part);
      if (reed_moves_)
        for (int i = 0; i < part; ++i)
          moving_[index(i)] = ReedCoefficients<V>::at(
              constants_, omega_from_ + V(phase + (i + 1) / period()) * (omega_to_ - omega_from_));
      const ValveSignals<V> signal{mouth.data() + done, noisy ? noise.data() + done : nullptr,
                                   wave.data() + done,  deflection.data() + done,
                                   bore.data() + done,  flow.data() + done};
      step(reed_moves_ ? moving_.data() : &steady_, reed_moves_ ? 1 : 0, signal, part);
      write_line(wave.data() + done, part);
      done += part;
    }
    const V scale(constants_.angle_scale), rest(constants_.rest_opening);
    for (int i = 0; i < count; ++i)
      deflection[index(i)] = (deflection[index(i)] + rest) * scale;
    radiation_.run(radiated.data(), count, length_to_);
    guard(radiated, deflection, bore, flow, count);
    decimate(0, radiated.data(), out.radiated, samples);
    decimate(1, deflection.data(), out.angle, samples);
    decimate(2, bore.data(), out.bore_pressure, samples);
    decimate(3, flow.data(), out.flow, samples);
    if (listens_) {
      std::array<double, kChunk> heard;
      for (int i = 0; i < samples; ++i)
        heard[index(i)] = static_cast<double>(simd::lane(out.bore_pressure[i], 0));
      ear_.listen(heard.data(), samples);
    }
  }

  void step(const ReedCoefficients<V>* coefficients, int stride, const ValveSignals<V>& signal,
            int count) noexcept {
    const auto go = [&](auto swinging, auto paper) {
      step_valve<decltype(swinging)::value, decltype(paper)::value>(constants_, coefficients,
                                                                    stride, state_, signal, count);
    };
    using Yes = std::true_type;
    using No = std::false_type;
    if (constants_.swinging)
      constants_.paper ? go(Yes{}, Yes{}) : go(Yes{}, No{});
    else
      constants_.paper ? go(No{}, Yes{}) : go(No{}, No{});
  }

  /// Third-order Lagrange interpolation in the middle of its four points, where |H| <= 1.
  static std::array<double, 4> weights(double d) noexcept { // 1 <= d < 2
    return {-(d - 1) * (d - 2) * (d - 3) / 6, d * (d - 2) * (d - 3) / 2, -d * (d - 1) * (d - 3) / 2,
            d * (d - 1) * (d - 2) / 6};
  }

  void read_line(V* wave, double phase, int count) noexcept {
    if (delay_from_ == trip_.delay) {
      // The stretch of the line that these samples see, oldest first, in one piece.
      const int whole = static_cast<int>(trip_.delay) - 2;
      const std::array<double, 4> h = weights(trip_.delay - whole - 1);
      const V h0(h[0]), h1(h[1]), h2(h[2]), h3(h[3]);
      std::array<V, kChunk + 3> whole_piece;
      const std::size_t from = slot(written_ - whole - 4), length = index(count + 3);
      const V* seen = line_.data() + from;
      if (from + length > line_.size()) {
        const std::size_t first = line_.size() - from;
        std::copy_n(seen, first, whole_piece.data());
        std::copy_n(line_.data(), length - first, whole_piece.data() + first);
        seen = whole_piece.data();
      }
      for (int i = 0; i < count; ++i)
        wave[i] = (h0 * seen[i + 3] + h1 * seen[i + 2]) + (h2 * seen[i + 1] + h3 * seen[i]);
    } else {
      for (int i = 0; i < count; ++i) {
        const double delay = delay_from_ + (phase + i / period()) * (trip_.delay - delay_from_);
        const int whole = static_cast<int>(delay) - 2;
        const std::array<double, 4> h = weights(delay - whole - 1);
        const std::ptrdiff_t at = written_ + i - 1 - whole;
        wave[i] = (V(h[0]) * line_[slot(at)] + V(h[1]) * line_[slot(at - 1)]) +
                  (V(h[2]) * line_[slot(at - 2)] + V(h[3]) * line_[slot(at - 3)]);
      }
    }
    for (int i = 0; i < count; ++i)
      quieten(wave[i]);
  }

  void write_line(const V* wave, int count) noexcept {
    const std::size_t first = std::min(index(count), line_.size() - slot(written_));
    std::copy_n(wave, first, line_.data() + slot(written_));
    std::copy_n(wave + first, index(count) - first, line_.data());
    written_ = (written_ + count) & mask_;
  }

  /// The paper's explicit flow and the force of the flow (mu) can feed energy in without bound,
  /// with absurd enough parameters: then the model starts anew from rest.
  void guard(Signal& a, Signal& b, Signal& c, Signal& d, int count) noexcept {
    const auto beyond = [](const V& value, double limit) { // or no number
      return simd::any(!(simd::absolute(value) < V(limit)));
    };
    V highest(0.0);
    for (int i = 0; i < count; ++i)
      highest = simd::maximum(highest, simd::absolute(c[index(i)]));
    if (!beyond(highest, 1e9) && !beyond(state_.bore_pressure, 1e9) &&
        !beyond(state_.jet_velocity, 1e6) && !beyond(state_.velocity, 1e9) &&
        radiation_.sane())
      return;
    for (Signal* signal : {&a, &b, &c, &d})
      std::fill_n(signal->begin(), count, V(0.0));
    state_ = {};
    still_air();
  }

  void decimate(std::size_t channel, V* signal, V* out, int samples) noexcept {
    if (oversampling_ == 4)
      stage1_[channel].run(signal, signal, 2 * samples);
    if (oversampling_ > 1)
      stage2_[channel].run(signal, out, samples);
    else
      std::copy_n(signal, samples, out);
  }

  [[nodiscard]] double period() const noexcept {
    return static_cast<double>(kControlPeriod * oversampling_);
  }
  static std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }
  [[nodiscard]] std::size_t slot(std::ptrdiff_t i) const noexcept {
    return static_cast<std::size_t>(i & mask_);
  }

  double sample_rate_ = 0, slew_ = 1;
  int oversampling_ = 1, phase_ = kControlPeriod;
  bool fresh_ = true, reed_moves_ = false, length_due_ = true, trip_due_ = true;
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
  RadiationPath<V> radiation_{};
  Ear ear_{};
  bool listens_ = false;
  double own_scale_ = 1, reed_scale_ = 1;          // of f_r: the player's choice, and trimmed
  double trim_ = 0, trim_scale_ = 1, trim_delay_ = 0, own_delay_ = 3;
  std::vector<V> line_;
  std::ptrdiff_t mask_ = 0, written_ = 0;
  std::array<Stage1, 4> stage1_{};
  std::array<Stage2, 4> stage2_{};
  Random random_{};
};

} // namespace tactus::reed
