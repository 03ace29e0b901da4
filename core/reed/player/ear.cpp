#include "core/reed/player/ear.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kFarthest = 0.28; // four semitones, as relative frequency
constexpr double kLimit = 0.25;
constexpr double kInTune = 0.006;   // ten cents: what is remembered as right
constexpr double kQuiet = 10;       // Pa
constexpr double kShare = 0.1;      // of the whole pressure's rms: heard at all,
constexpr double kMain = 0.35;      // and so much that no other register sounds
constexpr double kLoud = 100;       // Pa, of a sound that has settled on another register
constexpr double kHaste = 2;        // times faster for so long after a leap, s:
constexpr double kHurryTime = 0.15; // a slur's first error is the largest
constexpr double kSlow = 2;         // 1/s, of ln f: what moves faster is heard with less trust

} // namespace

void Ear::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  power_pole_ = std::exp(-kPeriod / (0.02 * sample_rate));
  const double frequency = frequency_;
  frequency_ = 0;
  if (frequency > 0)
    mean(frequency);
  reset();
}

void Ear::reset() noexcept {
  phase_ = 1;
  smooth_ = smoother_ = 0;
  glide_ = smooth_glide_ = smoother_glide_ = 0;
  asked_ = smooth_asked_ = smoother_asked_ = heard_asked_ = 0;
  wait_ = astray_ = 0;
  even_ = odd_ = {};
  loudness_ = trim_ = 0;
  place_ = 0;
  forget();
}

void Ear::forget() noexcept {
  for (Known& known : known_)
    known = {trim_, false};
}

/// Finds the pitch meant among the known ones. What has not sounded there yet starts as it sounds
/// now; the farther away that is, the less it says.
void Ear::place(double frequency_hz, bool leap) noexcept {
  const double at = std::clamp(kSteps * std::log2(frequency_hz / kLowest), 0.0, kCount - 1.5);
  const auto note = static_cast<std::size_t>(at);
  const double start = leap && frequency_ > 0
                           ? trim_ / (1 + std::abs(std::log2(frequency_hz / frequency_)) * 3)
                           : trim_;
  for (std::size_t i = note; i <= note + 1; ++i)
    if (!known_[i].sure && (leap || (i != note_ && i != note_ + 1)))
      known_[i].trim = start;
  note_ = note;
  share_ = at - static_cast<double>(note);
  trim_ = known_[note].trim + share_ * (known_[note + 1].trim - known_[note].trim);
}

void Ear::start_over() noexcept {
  for (std::size_t i = note_; i <= note_ + 1; ++i)
    known_[i] = {};
  trim_ = 0;
  settle();
}

/// Counts hearings of something that no trim brings to the pitch meant, twice; good ones make up
/// for them.
void Ear::stray(bool astray) noexcept { astray_ = std::max(0, astray_ + (astray ? 2 : -1)); }

/// What was heard so far is no longer what sounds.
void Ear::settle() noexcept {
  smooth_ = smoother_ = smooth_glide_ = smoother_glide_ = 0;
  wait_ = static_cast<int>(delay_ * sample_rate_ / kPeriod);
  astray_ = 0;
}

/// The trim at the pitch meant, by what it is to change; pitches that have not sounded go along.
void Ear::change(double difference) noexcept {
  Known& below = known_[note_];
  Known& above = known_[note_ + 1];
  const double of_below = below.sure ? 1 - share_ : 1, of_above = above.sure ? share_ : 1;
  const double unit = difference / ((1 - share_) * of_below + share_ * of_above);
  below.trim = std::clamp(below.trim + unit * of_below, -kLimit, kLimit);
  above.trim = std::clamp(above.trim + unit * of_above, -kLimit, kLimit);
  trim_ = below.trim + share_ * (above.trim - below.trim);
}

void Ear::mean(double frequency_hz) noexcept {
  if (frequency_hz == frequency_) {
    glide_ = 0;
    return;
  }
  const bool leap = !(std::abs(frequency_hz - frequency_) < kLeap * frequency_);
  glide_ = leap ? 0 : frequency_hz / frequency_ - 1;
  place(frequency_hz, leap);
  frequency_ = frequency_hz;
  // exp(-i omega k) for a hearing, doubled up from its first.
  const double omega = kTwoPi * frequency_hz / sample_rate_;
  cosine_[0] = 1;
  sine_[0] = 0;
  double c = std::cos(omega), s = std::sin(omega);
  for (std::size_t size = 1; size < cosine_.size(); size *= 2) {
    for (std::size_t i = 0; i < size; ++i) {
      cosine_[size + i] = cosine_[i] * c - sine_[i] * s;
      sine_[size + i] = cosine_[i] * s + sine_[i] * c;
    }
    const double twice = 2 * c * s;
    c = c * c - s * s;
    s = twice;
  }
  turn_ = {c, -s};
  // Two poles at an eighth of the pitch leave 1/64 of what lies a pitch away.
  const double corner = std::clamp(frequency_hz / 8, 2.0, 100.0);
  pole_ = 1 / (1 + kTwoPi * corner * kPeriod / sample_rate_);
  delay_ = 2 / (kTwoPi * corner);
  time_ = std::max(1.5 * delay_, 0.012);
  sound_pole_ = 1 / (1 + frequency_hz * kPeriod / (2 * sample_rate_));
  if (leap) {
    settle();
    hurry_ = static_cast<int>(kHurryTime * sample_rate_ / kPeriod);
  }
}

void Ear::listen(const double* bore_pressure, int count) noexcept {
  count = std::min(count, kPeriod - place_);
  const auto add = [&](int i, Sums& sums) {
    const double pressure = bore_pressure[i];
    const auto at = static_cast<std::size_t>(place_ + i);
    sums.real += pressure * cosine_[at];
    sums.imaginary -= pressure * sine_[at];
    sums.power += pressure * pressure;
  };
  // Samples of even and of odd place side by side, for each sum has to wait for itself; which sum
  // takes a sample does not depend on how the stream is cut.
  Sums even = even_, odd = odd_;
  int i = 0;
  if (place_ % 2 == 1 && count > 0)
    add(i++, odd);
  for (; i + 1 < count; i += 2) {
    add(i, even);
    add(i + 1, odd);
  }
  if (i < count)
    add(i, even);
  even_ = even;
  odd_ = odd;
  place_ += count;
}

void Ear::hear() noexcept {
  if (place_ == 0)
    return;
  const std::complex<double> sum(even_.real + odd_.real, even_.imaginary + odd_.imaginary);
  const std::complex<double> heard = phase_ * sum / static_cast<double>(kPeriod);
  phase_ *= turn_;
  phase_ /= std::sqrt(std::norm(phase_));
  const std::complex<double> before = smoother_;
  smooth_ = heard + pole_ * (smooth_ - heard);
  smoother_ = smooth_ + pole_ * (smoother_ - smooth_);
  smooth_glide_ = glide_ + pole_ * (smooth_glide_ - glide_);
  smoother_glide_ = smooth_glide_ + pole_ * (smoother_glide_ - smooth_glide_);
  heard_asked_ = asked_ + sound_pole_ * (heard_asked_ - asked_);
  smooth_asked_ = heard_asked_ + pole_ * (smooth_asked_ - heard_asked_);
  smoother_asked_ = smooth_asked_ + pole_ * (smoother_asked_ - smooth_asked_);
  const double power = (even_.power + odd_.power) / kPeriod;
  loudness_ = power + power_pole_ * (loudness_ - power);
  even_ = odd_ = {};
  place_ = 0;
  const double amplitude = 2 * std::sqrt(std::norm(smoother_));
  if (!(amplitude < 1e9)) {
    const double kept = trim_;
    reset();
    trim_ = kept;
    forget();
    return;
  }
  if (amplitude < kQuiet || amplitude * amplitude < kShare * kShare * loudness_) {
    wait_ = std::max(wait_, static_cast<int>(time_ * sample_rate_ / kPeriod));
    stray(loudness_ > kLoud * kLoud);
    return;
  }
  if (wait_ > 0) {
    --wait_;
    return;
  }
  const double period = kPeriod / sample_rate_;
  const double heard_error =
      std::arg(smoother_ * std::conj(before)) / (kTwoPi * frequency_ * period);
  if (!(std::abs(heard_error) < kFarthest)) {
    stray(true);
    return;
  }
  const double error = heard_error + asked_ - smoother_asked_;
  const double speed = smoother_glide_ / (period * kSlow);
  const double haste = hurry_ > 0 ? kHaste : 1;
  hurry_ = std::max(0, hurry_ - 1);
  const double step = -error * haste * period / (time_ * (1 + speed * speed));
  asked_ += step;
  change(step);
  const bool other = loudness_ > kLoud * kLoud && amplitude * amplitude < kMain * kMain * loudness_;
  stray(other || (std::abs(trim_) > 0.98 * kLimit && trim_ * step > 0));
  if (std::abs(error) < kInTune) {
    known_[note_].sure |= share_ < 0.7;
    known_[note_ + 1].sure |= share_ > 0.3;
  }
}

} // namespace tactus::reed
