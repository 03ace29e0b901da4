#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/simd.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace tactus::reed {

/// Parameters of the playability estimator, docs/theory/playability.md.
struct PlayabilityParameters {
  enum class Mode { kPaper, kRobust };
  double attack_s = 5e-3;      // envelope's time constant on rise
  double release_s = 80e-3;    // time constant on fall
  double highpass_hz = 10;     // removes the static angle
  double reference_rad = 0.03; // envelope at which A = 1/2
  double window_s = 50e-3;     // time over which zero crossings are counted, at most 0.25
  double hysteresis = 0.2;     // hysteresis of the counter, relative to the envelope
  Mode mode = Mode::kRobust;
};

/// Playability f_p of an oscillating valve from amplitude and zero crossings, sample by sample, for
/// one valve (V = double) or several in vector lanes (V = simd::Lanes):
///   t~   = one-pole high-pass of the angle t,
///   y(n) = (1 - v)|t~(n)| + v y(n - 1),  v = exp(-1/(tau fs)), tau the attack while |t~| > y,
///          else the release (Smyth, Smyth & Kirkpatrick, eq. 3, on the alternating part),
///   a zero crossing whenever t~ goes from below -h to above +h, h = hysteresis y,
///   A    = y/(y + reference),
///   J    = clip((z/z_mean - 1.5)/1.5, 0, 1), z crossings per second in the window, z_mean their
///          mean over 0.5 s of sound: a jump to twice the usual rate or more. It is 0 until one
///          window of sound has passed, so that the start of a note is no jump.
///   H    = clip((z - 4000 Hz)/2000 Hz, 0, 1), more crossings than any note has,
///   C    = max(J, H), the paper's "suddenly jumps to a very high number".
/// No allocation. For V = double, an input that is NaN is replaced by the last number; the angles
/// of several lanes must be numbers, as those of a ReedBank are.
template <class V> class PlayabilityFollower {
public:
  using Scalar = typename simd::LaneTraits<V>::Scalar;
  static constexpr int lanes = simd::LaneTraits<V>::count;

  void prepare(double sample_rate) noexcept {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    set(parameters_);
    reset();
  }

  void set(const PlayabilityParameters& parameters) noexcept {
    parameters_ = parameters;
    if (!(sample_rate_ > 0))
      return;
    pole_ = math::exp(-2 * std::numbers::pi * parameters.highpass_hz / sample_rate_);
    attack_ = math::exp(-1 / (parameters.attack_s * sample_rate_));
    release_ = math::exp(-1 / (parameters.release_s * sample_rate_));
    hop_ = static_cast<int>(std::lround(sample_rate_ * kHopTime));
    if (hop_ < 1)
      hop_ = 1;
    const double hops = parameters.window_s * sample_rate_ / hop_;
    const int window = hops < 2 ? 2 : hops > kMaxHops ? kMaxHops : static_cast<int>(hops + 0.5);
    if (window != window_) {
      window_ = window;
      clear_counts();
    }
    rate_per_crossing_ = sample_rate_ / (static_cast<double>(window_) * hop_);
    mean_gain_ = 1 - math::exp(-hop_ / (kMeanTime * sample_rate_));
  }

  void reset() noexcept {
    primed_ = false;
    high_ = envelope_ = last_ = V(0.0);
    armed_ = V(0.0) > V(0.0);
    sample_index_ = 0;
    hop_position_ = 0;
    clear_counts();
    for (int i = 0; i < lanes; ++i) {
      crossings_[i] = 0;
      sounding_[i] = 0;
      mean_[i] = rate_[i] = 0;
    }
  }

  /// Limits the counting to the first 1 <= count <= lanes; f_p of the other lanes is undefined.
  void set_active_lanes(int count) noexcept { active_lanes_ = count; }

  /// The next angle, rad.
  void tick(const V& angle) noexcept { run(&angle, 1); }
  /// Processes the next count angles, as that many calls of tick() would.
  void run(const V* angles, int count) noexcept {
    if (!primed_ && count > 0) { // the high-pass starts settled at the first angle
      primed_ = true;
      last_ = usable(angles[0], last_);
    }
    while (count > 0) {
      const int part = count < hop_ - hop_position_ ? count : hop_ - hop_position_;
      process_hop(angles, part);
      angles += part;
      count -= part;
      hop_position_ += part;
      if (hop_position_ == hop_) {
        hop_position_ = 0;
        end_hop();
      }
    }
  }

  /// y, rad.
  [[nodiscard]] double envelope(int i = 0) const noexcept { return simd::lane(envelope_, i); }
  /// z, crossings per second, updated every half millisecond.
  [[nodiscard]] double crossing_rate(int i = 0) const noexcept { return rate_[i]; }
  /// J.
  [[nodiscard]] double jump(int i = 0) const noexcept {
    if (sounding_[i] <= window_ || !(mean_[i] > 0))
      return 0;
    const double c = (rate_[i] / mean_[i] - 1.5) / 1.5;
    return c < 0 ? 0 : c > 1 ? 1 : c;
  }
  /// C.
  [[nodiscard]] double crossing_penalty(int i = 0) const noexcept {
    double high = (rate_[i] - kMaxRate) / kMaxRateWidth;
    high = high < 0 ? 0 : high > 1 ? 1 : high;
    const double sudden = jump(i);
    return sudden > high ? sudden : high;
  }
  /// Standard deviation over mean of the last intervals between crossings, up to 16 and no older
  /// than half a second; 0 when there are fewer than three.
  [[nodiscard]] double interval_variation(int i = 0) const noexcept {
    double sum = 0, squares = 0;
    int n = 0;
    const std::uint32_t available = crossings_[i] < kMaxTimes ? crossings_[i] : kMaxTimes;
    for (std::uint32_t k = 1; k < available; ++k) {
      const double end = times_[i][(crossings_[i] - k) % kMaxTimes];
      const double start = times_[i][(crossings_[i] - k - 1) % kMaxTimes];
      if (static_cast<double>(sample_index_) - start > kMeanTime * sample_rate_)
        break;
      sum += end - start;
      squares += (end - start) * (end - start);
      ++n;
    }
    if (n < 3)
      return 0;
    const double mean = sum / n, variance = squares / n - mean * mean;
    return variance > 0 ? std::sqrt(variance) / mean : 0;
  }
  /// f_p in [0, 1) given the aperiodicity that an analysis measures (0 without one):
  /// A (1 - C) in the paper's mode, A (1 - max(C, smoothstep(0.04, 0.25, aperiodicity))) in the
  /// robust mode. Without an analysis the two are the same.
  [[nodiscard]] double playability(int i = 0, double aperiodicity = 0) const noexcept {
    const double y = envelope(i);
    double penalty = crossing_penalty(i);
    if (parameters_.mode == PlayabilityParameters::Mode::kRobust) {
      double t = (aperiodicity - 0.04) / (0.25 - 0.04);
      t = t < 0 ? 0 : t > 1 ? 1 : t;
      const double smooth = t * t * (3 - 2 * t);
      if (smooth > penalty)
        penalty = smooth;
    }
    return y / (y + parameters_.reference_rad) * (1 - penalty);
  }
  [[nodiscard]] const PlayabilityParameters& parameters() const noexcept { return parameters_; }

private:
  static constexpr double kHopTime = 0.5e-3; // s between updates of the counts
  static constexpr int kMaxHops = 500;       // the longest window, in hops
  static constexpr double kMeanTime = 0.5;   // s
  // Highest rate of a periodic reed, that of the highest f_b, and width of the ramp of H. White
  // noise at 44.1 kHz and above crosses 8000 times a second or more with hysteresis 0.2.
  static constexpr double kMaxRate = 4000, kMaxRateWidth = 2000; // Hz
  static constexpr double kAudible = 0.02; // share of the reference; above it the valve sounds
  static constexpr std::uint32_t kMaxTimes = 17;

  static V usable(const V& angle, const V& fallback) noexcept {
    return simd::select(simd::absolute(angle) < V(1e6), angle, fallback);
  }

  /// Samples of one hop.
  void process_hop(const V* angles, int count) noexcept {
    using namespace simd;
    const V pole(pole_), attack(attack_), release(release_);
    const V rising(1 - attack_), falling(1 - release_);
    const V hysteresis(parameters_.hysteresis), min_threshold(1e-9);
    const bool attack_is_faster = attack_ <= release_;
    V last = last_, high = high_, envelope = envelope_;
    auto armed = armed_;
    const std::uint32_t lane_mask = (1u << active_lanes_) - 1;
    for (int i = 0; i < count; ++i) {
      const V angle = lanes == 1 ? usable(angles[i], last) : angles[i], before = high;
      high = angle - last + pole * high;
      last = angle;
      const V size = absolute(high);
      // Attack on rise, release on fall, without a branch. If the attack is the faster of the two,
      // its result is the larger one on rise, and the result of the slower release is the larger
      // one on fall.
      const V rise = rising * size + attack * envelope;
      const V fall = falling * size + release * envelope;
      envelope = attack_is_faster ? maximum(rise, fall) : minimum(rise, fall);
      const V h = hysteresis * envelope + min_threshold;
      const auto above = high > h;
      armed = armed | (high < -h);
      const typename LaneTraits<V>::MaskType crossing = armed & above;
      armed = armed & !above;
      if constexpr (lanes == 1) {
        if (crossing)
          record_crossing(0, before, high, h, i);
      } else {
        const std::uint32_t crossed = bits(crossing) & lane_mask;
        if (crossed != 0) [[unlikely]] {
          for (int k = 0; crossed >> k != 0; ++k)
            if ((crossed >> k & 1) != 0)
              record_crossing(k, static_cast<double>(lane(before, k)),
                              static_cast<double>(lane(high, k)), static_cast<double>(lane(h, k)),
                              i);
        }
      }
    }
    last_ = last;
    high_ = high;
    envelope_ = envelope;
    armed_ = armed;
    sample_index_ += count;
  }

  /// Records a crossing of lane i, offset samples after sample_index_, at the interpolated time.
  [[gnu::noinline]] void record_crossing(int i, double from, double to, double level,
                                         int offset) noexcept {
    const double part = to > from ? (level - from) / (to - from) : 1;
    times_[i][crossings_[i] % kMaxTimes] =
        static_cast<double>(sample_index_ + offset) + (part > 0 ? part : 0);
    ++crossings_[i];
    ++counts_[i][hop_index_];
  }

  void end_hop() noexcept {
    hop_index_ = hop_index_ + 1 < window_ ? hop_index_ + 1 : 0;
    for (int i = 0; i < active_lanes_; ++i) {
      // Sliding sum: the hop that ended is added, the oldest subtracted.
      const int ended = hop_index_ > 0 ? hop_index_ - 1 : window_ - 1;
      total_[i] += counts_[i][ended];
      rate_[i] = total_[i] * rate_per_crossing_;
      total_[i] -= counts_[i][hop_index_];
      counts_[i][hop_index_] = 0;
      if (envelope(i) < kAudible * parameters_.reference_rad) {
        sounding_[i] = 0;
      } else if (++sounding_[i] > window_) {
        const int counted_hops = sounding_[i] - window_;
        const double gain = counted_hops * mean_gain_ < 1 ? 1.0 / counted_hops : mean_gain_;
        mean_[i] = counted_hops == 1 ? rate_[i] : mean_[i] + gain * (rate_[i] - mean_[i]);
        if (sounding_[i] > kMaxSoundingHops)
          sounding_[i] = kMaxSoundingHops;
      }
      if (envelope(i) < 1e-20) {
        simd::set_lane(envelope_, i, Scalar(0));
        if (std::abs(static_cast<double>(simd::lane(high_, i))) < 1e-20)
          simd::set_lane(high_, i, Scalar(0));
      }
    }
  }

  void clear_counts() noexcept {
    hop_index_ = 0;
    for (int i = 0; i < lanes; ++i) {
      total_[i] = 0;
      for (int k = 0; k < kMaxHops; ++k)
        counts_[i][k] = 0;
    }
  }

  static constexpr int kMaxSoundingHops = 1 << 20; // hops, where counting of sound stops
  PlayabilityParameters parameters_{};
  double sample_rate_ = 0;
  double pole_ = 0, attack_ = 0, release_ = 0, mean_gain_ = 0, rate_per_crossing_ = 0;
  int hop_ = 24, window_ = 0, hop_position_ = 0, hop_index_ = 0;
  int active_lanes_ = lanes;
  bool primed_ = false;
  V last_{0.0}, high_{0.0}, envelope_{0.0};
  typename simd::LaneTraits<V>::MaskType armed_{};
  std::int64_t sample_index_ = 0;
  std::uint16_t counts_[lanes][kMaxHops] = {};
  std::uint32_t crossings_[lanes] = {};
  int total_[lanes] = {}, sounding_[lanes] = {};
  double times_[lanes][kMaxTimes] = {}, rate_[lanes] = {}, mean_[lanes] = {};
};

} // namespace tactus::reed
