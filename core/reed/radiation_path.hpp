#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore_design.hpp"
#include "core/reed/parameters.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// From the wave that arrives at the end of the bore to the pressure at 1 m, averaged over all
/// directions, as numbers for one internal sample rate.
///
/// A plain open end (bell 0) is a point source of the flow that leaves it:
///   p = rho/(4 pi d) d/dt (a - b)/Z_0.
/// A bell, or a row of open tone holes, lets pass above its cut-off w_c = 2 pi bell all that it
/// holds back below. Two limits fix what is heard of a wave a, r_1 being the bore's radius where
/// it opens and d = 1 m:
///   w << w_c: point source of the doubled flow,   |p| = a r/(2d) k r_1,
///   w >> w_c: all the power leaves,               |p| = a r/(2d),
/// and the simplest passage between them is
///   p = r/(2d) s (s + w_c^2 r_1/c)/(s^2 + s w_c/Q + w_c^2) a,
/// Q (bell_quality) saying how sharply it opens. Both limits follow from mass and energy; for the
/// cut-offs of bells and lattices see Benade, Fundamentals of Musical Acoustics, chapters 20, 21.
///
/// Loud waves steepen on their way, for they travel faster where the pressure is high: each piece
/// arrives earlier by
///   (gamma + 1)/(2 gamma P_0 c) * brassiness * L * a       (simple wave in a tube)
/// (Hirschberg, Gilbert, Msallam & Wijnands 1996). The bore inside is linear; a wave that leaves it
/// has travelled it several times over, so that brassiness may be above 1.
struct RadiationConstants {
  bool plain = true;
  double scale = 0;                                  // plain: of the difference between samples
  double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;     // else: bilinear, exact at w_c
  double lead = 0; // internal samples for each Pa and metre of bore

  static RadiationConstants from(const Parameters& parameters, const BoreDesign& bore,
                                 double internal_rate) noexcept;
};

/// Computes it, for the first lane of V alone.
template <class V> class RadiationPath {
public:
  static constexpr int kLongest = 64; // internal samples of one run

  void set(const RadiationConstants& constants) noexcept {
    if (constants.plain != constants_.plain)
      reset();
    constants_ = constants;
  }
  void reset() noexcept {
    before_ = first_ = second_ = 0;
    past_ = {};
  }
  /// Share of the returning wave b that counts: a - b for the plain end, else a alone.
  [[nodiscard]] double returning_share() const noexcept { return constants_.plain ? 1 : 0; }
  [[nodiscard]] bool sane() const noexcept {
    return size(before_) < 1e9 && size(first_) < 1e12 && size(second_) < 1e12;
  }
  void quieten() noexcept {
    for (double* value : {&before_, &first_, &second_})
      if (size(*value) < 1e-20)
        *value = 0;
  }

  /// count <= kLongest samples in place; length is the bore's, m.
  void run(V* wave, int count, double length) noexcept {
    double sound[kLongest];
    for (int i = 0; i < count; ++i)
      sound[i] = static_cast<double>(simd::lane(wave[i], 0));
    if (constants_.plain) {
      differentiate(sound, count);
    } else {
      if (constants_.lead > 0)
        steepen(sound, count, constants_.lead * length);
      let_out(sound, count);
    }
    for (int i = 0; i < count; ++i)
      wave[i] = V(sound[i]);
  }

private:
  static constexpr int kReach = 24; // internal samples by which a piece may be early or late
  static constexpr std::size_t kMemory = 2 * kReach + 3;

  static double size(double x) noexcept { return x < 0 ? -x : x; }

  void differentiate(double* sound, int count) noexcept {
    for (int i = 0; i < count; ++i) {
      const double now = sound[i];
      sound[i] = constants_.scale * (now - before_);
      before_ = now;
    }
  }

  void let_out(double* sound, int count) noexcept {
    const RadiationConstants c = constants_;
    double first = first_, second = second_;
    for (int i = 0; i < count; ++i) {
      const double in = sound[i], out = c.b0 * in + first;
      first = c.b1 * in - c.a1 * out + second;
      second = c.b2 * in - c.a2 * out;
      sound[i] = out;
    }
    first_ = first;
    second_ = second;
  }

  /// y(t) = a(t + lead y(t)), the lead found from the wave at t, then once more from what was
  /// found there. Whatever the lead, y is a value that the wave had (interpolated by Hermite's
  /// cubic), so that nothing grows; where pieces would overtake one another a jump stays.
  void steepen(double* sound, int count, double lead) noexcept {
    std::array<double, kMemory + kLongest> wave;
    for (std::size_t i = 0; i < kMemory; ++i)
      wave[i] = past_[i];
    for (int i = 0; i < count; ++i)
      wave[kMemory + static_cast<std::size_t>(i)] = sound[i];
    constexpr double kFarthest = kReach;
    for (int i = 0; i < count; ++i) {
      const double* oldest = wave.data() + i; // 2 kReach + 3 before the newest
      const auto place = [&](double value) {
        const double shift = lead * value;
        return (shift < -kFarthest ? -kFarthest : shift > kFarthest ? kFarthest : shift) + kReach;
      };
      double shift = place(oldest[kReach + 1]);
      int whole = static_cast<int>(shift);
      double f = shift - whole;
      shift = place(oldest[whole + 1] + f * (oldest[whole + 2] - oldest[whole + 1]));
      whole = static_cast<int>(shift);
      f = shift - whole;
      const double a = oldest[whole], b = oldest[whole + 1];
      const double c = oldest[whole + 2], d = oldest[whole + 3];
      sound[i] =
          b + 0.5 * f * (c - a + f * (2 * a - 5 * b + 4 * c - d + f * (3 * (b - c) + d - a)));
    }
    for (std::size_t i = 0; i < kMemory; ++i)
      past_[i] = wave[static_cast<std::size_t>(count) + i];
  }

  RadiationConstants constants_{};
  double before_ = 0, first_ = 0, second_ = 0;
  std::array<double, kMemory> past_{};
};

} // namespace tactus::reed
