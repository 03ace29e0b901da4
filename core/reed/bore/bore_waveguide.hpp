#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/bore_line.hpp"
#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/bore/tone_hole_end.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace tactus::reed {

/// The bore of a ReedBank as a digital waveguide: from the wave p+ out of the valve to the wave p-
/// that returns to it, and to the sound outside.
///
///   p-(s) = R(s) exp(-2 s L/c - G sqrt(s)) p+(s)
///
/// One delay line holds the whole round trip (BoreLine), wall losses and open end are filters
/// behind it (RoundTripFilter; ToneHoleEnd for holes and bells), RadiationPath radiates the sound.
/// While the register vent is open, the line is in two parts that meet at the vent (VentFilter).
/// Length, filters and vent move linearly within a control period of kControlPeriod samples. A
/// round trip takes several samples, so that p- of a block is known before the valve moves.
///
/// V is double, or simd::Lanes for several reeds on equal bores; only the first lane is radiated.
/// Sample counts are internal ones, after oversampling, unless stated. Only prepare() allocates.
template <class V, int max_count> class BoreWaveguide {
public:
  static constexpr double kDenormalLimit = 1e-20; // smaller states become 0: denormals are slow

  /// Allocates room for the longest bore at internal rates up to highest_rate, Hz.
  void prepare(double highest_rate) {
    line_.prepare(max_delay(highest_rate));
    below_.prepare(max_delay(highest_rate));
    radiation_.prepare(highest_rate);
  }

  /// Sets shape, losses, end and radiation to these parameters at once; the length is set by
  /// set_length(). The air keeps its state.
  void set(const Parameters& parameters, double sample_rate, int oversampling) noexcept {
    sample_rate_ = sample_rate;
    oversampling_ = oversampling;
    design_.set(parameters, rate());
    radiation_to_ = RadiationConstants::from(parameters, design_, rate());
    radiation_.set(radiation_to_);
    gliding_ = false;
    holes_.set(rate(), design_.air().sound_speed / air_at(20).sound_speed, parameters.input_radius);
    vent_ = RegisterVent::of(parameters);
    vent_filter_.set(vent_, rate());
    trip_due_ = true;
  }
  /// As set(), but reached within the control period that begins now.
  void glide_to(const Parameters& parameters) noexcept {
    design_.set(parameters, rate());
    trip_from_ = trip_;
    radiation_from_ = radiation_to_;
    radiation_to_ = RadiationConstants::from(parameters, design_, rate());
    trip_due_ = gliding_ = true;
  }
  /// To be called at the end of a control period: completes glide_to().
  void end_period() noexcept {
    if (gliding_)
      radiation_.set(radiation_to_);
    gliding_ = false;
  }
  /// Sets the termination of the bore, which must outlive its use here; null: an open end.
  void set_end(const Termination* end) noexcept {
    if (end == design_.end())
      return;
    design_.set_end(end);
    holes_.finger(end);
    trip_due_ = true;
  }

  /// Shifts the pitch by the factor exp(logarithm), by the delay alone, because the change of the
  /// losses is inaudible. length: of the untrimmed bore, m.
  void set_trim(double logarithm, double length, BoreShape shape) noexcept {
    const double acoustic = design_.air().sound_speed / design_.ideal_frequency(length) /
                            (shape == BoreShape::kCone ? 2 : 4);
    trim_delay_ = 2 * acoustic * math::expm1(-logarithm) / design_.air().sound_speed *
                  sample_rate_ * oversampling_;
  }
  /// L at the end of the control period that begins now, m.
  void set_length(double length) noexcept {
    delay_from_ = trip_.delay;
    if (length != length_ || trip_due_) {
      length_ = length;
      trip_ = design_.round_trip(length);
      untrimmed_delay_ = trip_.delay;
      trip_due_ = false;
    }
    trip_.delay = std::clamp(untrimmed_delay_ + trim_delay_, 3.0,
                             static_cast<double>(max_delay(sample_rate_ * oversampling_)));
    if (divided_)
      divide();
  }
  /// The delay of the last set_length() holds from the beginning of the control period.
  void jump_to_length() noexcept { delay_from_ = trip_.delay; }
  /// L, m.
  [[nodiscard]] double length() const noexcept { return length_; }
  [[nodiscard]] double max_length() const noexcept { return design_.max_length(); }
  [[nodiscard]] const BoreDesign& design() const noexcept { return design_; }

  /// Share of the register vent that is open, 0 to 1, reached within kVentTime, or at once. The
  /// line is in two parts from the first opening until all waves sent with an open vent have
  /// passed.
  void set_vent(double open, bool at_once) noexcept {
    const bool vent_usable = vent_.share > 0 && length_ > vent_.position + kMinLengthBelowVent;
    const double target = vent_usable ? open : 0,
                 step = kControlPeriod / (kVentTime * sample_rate_);
    vent_from_ = vent_to_;
    vent_to_ = at_once ? target : std::clamp(target, vent_to_ - step, vent_to_ + step);
    if (at_once)
      vent_from_ = vent_to_;
    samples_since_vent_ = vent_from_ > 0 || vent_to_ > 0 ? 0 : samples_since_vent_ + kControlPeriod;
    if (!divided_ && vent_to_ > 0) {
      divided_ = true;
      divide();
      below_.follow(line_, parts_.above.delay, static_cast<int>(trip_.delay) + 8);
      // The filters of both parts have the same poles, so their states scale as the losses do.
      above_filter_ = filter_;
      scale_losses(parts_.above, trip_, parts_.below, trip_);
      vent_filter_.reset();
    } else if (divided_ && samples_since_vent_ * oversampling_ > 2 * trip_.delay + kControlPeriod) {
      divided_ = false;
      scale_losses({}, trip_, trip_, parts_.below);
    }
  }

  /// Length over which the sound steepens, m, reached by a one-pole low-pass of this gain. It is
  /// `wavelengths` times the wavelength of the note (Hz) if both are above 0, else the length of
  /// the bore.
  void update_steepening_length(double wavelengths, double note, double gain) noexcept {
    if (!(wavelengths > 0) || !(note > 0)) {
      steepening_length_ = length_;
      return;
    }
    const double length = wavelengths * design_.air().sound_speed / note;
    steepening_length_ += gain * (length - steepening_length_);
  }

  /// Number of samples, at most `wanted`, that propagate() may take in one piece, `phase` samples
  /// after the beginning of the control period.
  [[nodiscard]] int block_size(int phase, int wanted) noexcept {
    const double above = divided_ ? parts_.above.delay : 0;
    int room = line_.max_block(std::min(delay_at(phase), trip_.delay) - above);
    if (divided_)
      room = std::min({room, line_.max_block(above), below_.room()});
    return std::min({wanted, room, line_.room()});
  }
  /// Returns p- of the next count samples, Pa; p+ must be written in its place before advance().
  /// leaving: receives the wave that leaves the end of the bore, for radiate().
  [[nodiscard]] V* propagate(int phase, double* leaving, int count) noexcept {
    const double above = divided_ ? parts_.above.delay : 0;
    V* wave = line_.next();
    BoreLine<V, max_count>& last = divided_ ? below_ : line_; // the part up to the bore's end
    V* end_wave = last.next();
    if (delay_from_ == trip_.delay)
      last.read(delay_at(phase) - above, kDenormalLimit, end_wave, count);
    else
      last.read_moving({delay_from_ - above, trip_.delay - above, phase, period()}, kDenormalLimit,
                       end_wave, count);
    if (gliding_)
      reflect_gliding(end_wave, leaving, phase, count);
    else
      reflect(end_wave, divided_ ? parts_.below : trip_, leaving, count);
    if (divided_)
      pass_vent(wave, end_wave, phase, count);
    return wave;
  }
  void advance(int count) noexcept { line_.advance(count); }
  /// Converts the wave that leaves the bore to the pressure at 1 m, Pa, in place.
  void radiate(double* leaving, int count) noexcept {
    if (holes_.active()) {
      radiation_.steepen(leaving, count, steepening_length_);
      holes_.radiate(leaving, count);
    } else if (radiation_.steepens()) {
      radiation_.run(leaving, count, steepening_length_);
    }
  }

  /// Sets the air to rest.
  void clear() noexcept {
    line_.clear();
    below_.clear();
    filter_.reset();
    above_filter_.reset();
    vent_filter_.reset();
    radiation_.reset();
    holes_.reset();
  }
  /// To be called once per control period. Also begins the fade to a fingering that waited for the
  /// last fade.
  void flush_denormals() noexcept {
    const auto flush = [](auto& value) {
      using Value = std::remove_reference_t<decltype(value)>;
      value = simd::select(simd::absolute(value) < Value(kDenormalLimit), Value(0.0), value);
    };
    filter_.each(flush);
    if (divided_) {
      above_filter_.each(flush);
      vent_filter_.each(flush);
    }
    radiation_.flush_denormals();
    if (holes_.active()) {
      holes_.start_pending_fade();
      holes_.each(flush);
      holes_.each_radiation([](double& value) {
        if (std::abs(value) < kDenormalLimit)
          value = 0;
      });
    }
  }
  /// False when the radiated sound is NaN or beyond any physical value.
  [[nodiscard]] bool is_bounded() const noexcept { return radiation_.is_bounded(); }

private:
  static constexpr double kVentTime = 5e-3;           // s
  static constexpr double kMinLengthBelowVent = 0.03; // m of line

  /// Internal samples per second, and per control period.
  [[nodiscard]] double rate() const noexcept { return sample_rate_ * oversampling_; }
  [[nodiscard]] double period() const noexcept {
    return static_cast<double>(kControlPeriod * oversampling_);
  }
  [[nodiscard]] double delay_at(int phase) const noexcept {
    return delay_from_ + phase / period() * (trip_.delay - delay_from_);
  }

  void divide() noexcept {
    parts_ = design_.parts(trip_, length_, vent_.position);
    // Some samples of the line are below the vent, whatever the bore's length.
    parts_.above.delay =
        std::clamp(parts_.above.delay, 3.0, std::max(3.0, std::min(delay_from_, trip_.delay) - 4));
  }
  void scale_losses(const RoundTrip& above, const RoundTrip& above_before, const RoundTrip& below,
                    const RoundTrip& below_before) noexcept {
    const auto ratio = [](const RoundTrip& current, const RoundTrip& before) {
      const double size = before.loss_residue[0];
      return size != 0 ? current.loss_residue[0] / size : 0.0;
    };
    const double above_ratio = ratio(above, above_before), below_ratio = ratio(below, below_before);
    above_filter_.each_loss([above_ratio](auto& value) { value = value * above_ratio; });
    filter_.each_loss([below_ratio](auto& value) { value = value * below_ratio; });
  }

  /// At the end of the bore: turns the arriving wave into the returning wave, in place.
  [[gnu::noinline, gnu::flatten]] void reflect(V* wave, const RoundTrip& trip, double* leaving,
                                               int count) noexcept {
    typename RoundTripFilter<V>::BlockFilter filter(filter_, trip, radiation_.reflected_weight());
    if (holes_.active()) {
      for (int i = 0; i < count; ++i) {
        wave[i] = filter.incident(wave[i]);
        leaving[i] = static_cast<double>(simd::lane(wave[i], 0));
      }
      holes_.reflect(wave, count);
    } else if (radiation_.steepens()) {
      for (int i = 0; i < count; ++i)
        wave[i] = filter(wave[i], leaving[i]);
    } else {
      RadiationPath::OutputFilter output_filter(radiation_);
      for (int i = 0; i < count; ++i) {
        double transmitted;
        wave[i] = filter(wave[i], transmitted);
        leaving[i] = output_filter(transmitted);
      }
    }
  }
  /// As reflect(), during glide_to(): the coefficients move linearly from sample to sample.
  void reflect_gliding(V* wave, double* leaving, int phase, int count) noexcept {
    for (int i = 0; i < count; ++i) {
      const double share = (phase + i + 1) / period();
      radiation_.set(RadiationConstants::interpolate(radiation_from_, radiation_to_, share));
      reflect(wave + i, divided_ ? parts_.below : RoundTrip::interpolate(trip_from_, trip_, share),
              leaving + i, 1);
    }
  }
  /// wave: receives the wave that the line above the vent returns to the valve. below: the wave
  /// from the part below the vent is replaced by the wave into that part.
  [[gnu::noinline, gnu::flatten]] void pass_vent(V* wave, V* below, int phase, int count) noexcept {
    line_.read(parts_.above.delay, kDenormalLimit, wave, count);
    typename RoundTripFilter<V>::BlockFilter losses(above_filter_, parts_.above, 0);
    const double step = (vent_to_ - vent_from_) / period();
    vent_filter_.pass(losses, wave, below, {vent_from_ + step * phase, step}, count);
    below_.advance(count);
  }

  double sample_rate_ = 48000;
  int oversampling_ = 1;
  BoreDesign design_{};
  RoundTrip trip_{}, trip_from_{};
  bool gliding_ = false, trip_due_ = true; // trip_ is out of date
  double length_ = 0.48, delay_from_ = 3;  // delay at the beginning of the control period
  double trim_delay_ = 0, untrimmed_delay_ = 3;
  BoreLine<V, max_count> line_, below_; // the whole bore, or its parts above and below the vent
  RoundTripFilter<V> filter_{};         // filter to the end of the bore
  ToneHoleEnd<V> holes_{};

  RegisterVent vent_{};
  VentFilter<V> vent_filter_{};
  RoundTripFilter<V> above_filter_{}; // filter of the line above the vent
  BoreDesign::Parts parts_{};         // parts of the round trip while the line is divided at the
                                      // vent
  bool divided_ = false;
  int samples_since_vent_ = 0;         // host samples since the vent was open
  double vent_from_ = 0, vent_to_ = 0; // share that is open

  RadiationPath radiation_{};
  RadiationConstants radiation_from_{}, radiation_to_{};
  double steepening_length_ = 0.48; // m
};

} // namespace tactus::reed
