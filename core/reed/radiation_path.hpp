#pragma once

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
/// (Hirschberg, Gilbert, Msallam & Wijnands 1996). The bore inside is linear, for there the way
/// back undoes the way out. Above 1, brassiness stands for a louder wave than the bore's own.
struct RadiationConstants {
  bool plain = true;
  // Bilinear, exact at w_c; the plain end as the difference between samples.
  double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  double lead = 0; // internal samples for each Pa and metre of bore

  static RadiationConstants from(const Parameters& parameters, const BoreDesign& bore,
                                 double internal_rate) noexcept;
};

/// Computes it.
class RadiationPath {
public:
  static constexpr int kLongest = 64; // internal samples of one run

  void set(const RadiationConstants& constants) noexcept {
    if (constants.plain != constants_.plain)
      reset();
    constants_ = constants;
  }
  void reset() noexcept {
    wave_ = before_ = sound_ = last_ = 0;
    past_ = {};
  }
  /// Share of the returning wave b that counts: a - b for the plain end, else a alone.
  [[nodiscard]] double returning_share() const noexcept { return constants_.plain ? 1 : 0; }
  [[nodiscard]] bool sane() const noexcept {
    return size(wave_) < 1e9 && size(sound_) < 1e9 && size(last_) < 1e9;
  }
  void quieten() noexcept {
    for (double* value : {&wave_, &before_, &sound_, &last_})
      if (size(*value) < 1e-20)
        *value = 0;
  }
  /// Loud waves change their shape: steepen() goes before the rest.
  [[nodiscard]] bool steepens() const noexcept { return constants_.lead > 0; }

  /// The way out of the bore, sample by sample; its state goes back into the path at the end of
  /// its life.
  class Exit {
  public:
    [[gnu::always_inline]] explicit Exit(RadiationPath& path) noexcept
        : path_(path), c_(path.constants_), wave_(path.wave_), before_(path.before_),
          sound_(path.sound_), last_(path.last_) {}
    Exit(const Exit&) = delete;
    Exit& operator=(const Exit&) = delete;
    [[gnu::always_inline]] ~Exit() {
      path_.wave_ = wave_;
      path_.before_ = before_;
      path_.sound_ = sound_;
      path_.last_ = last_;
    }
    /// From the wave at the end to the pressure at 1 m, Pa.
    [[gnu::always_inline]] double operator()(double wave) noexcept {
      const double sound =
          ((c_.b0 * wave + c_.b1 * wave_) + (c_.b2 * before_ - c_.a2 * last_)) - c_.a1 * sound_;
      before_ = wave_;
      wave_ = wave;
      last_ = sound_;
      sound_ = sound;
      return sound;
    }

  private:
    RadiationPath& path_;
    RadiationConstants c_;
    double wave_, before_, sound_, last_;
  };

  /// Replaces count <= kLongest samples of wave by the sound of a bore of that length, m.
  void run(double* wave, int count, double length) noexcept {
    if (steepens())
      steepen(wave, count, constants_.lead * length);
    Exit exit(*this);
    for (int i = 0; i < count; ++i)
      wave[i] = exit(wave[i]);
  }

private:
  static constexpr int kReach = 24; // internal samples by which a piece may be early or late
  static constexpr std::size_t kMemory = 2 * kReach + 3;

  static double size(double x) noexcept { return x < 0 ? -x : x; }

  /// y(t) = a(t + lead y(t)), the lead found from the wave at t, then once more from what was
  /// found there. Whatever the lead, y is a value that the wave had (interpolated by Hermite's
  /// cubic), so that nothing grows; where pieces would overtake one another a jump stays.
  void steepen(double* sound, int count, double lead) noexcept {
    if (count < 1 || count > kLongest)
      return;
    std::array<double, kMemory + kLongest> wave;
    for (std::size_t i = 0; i < kMemory; ++i)
      wave[i] = past_[i];
    for (int i = 0; i < count; ++i)
      wave[kMemory + static_cast<std::size_t>(i)] = sound[i];
    // In three passes: a processor looks ahead within each, but not across so long a way.
    std::array<double, kLongest> place;
    const auto find = [&](double value, int i) {
      constexpr double kFarthest = kReach;
      const double shift = lead * value, early = shift < kFarthest ? shift : kFarthest;
      // Samples after the oldest that counts for sample i; of no number: as early as can be.
      place[static_cast<std::size_t>(i)] = (early > -kFarthest ? early : -kFarthest) + kFarthest;
    };
    const auto piece = [&](int i, double& f) {
      const double at = place[static_cast<std::size_t>(i)];
      const int whole = static_cast<int>(at);
      f = at - whole;
      return wave.data() + i + whole;
    };
    for (int i = 0; i < count; ++i)
      find(wave[static_cast<std::size_t>(i + kReach + 1)], i);
    for (int i = 0; i < count; ++i) {
      double f;
      const double* at = piece(i, f);
      find(at[1] + f * (at[2] - at[1]), i);
    }
    for (int i = 0; i < count; ++i) {
      double f;
      const double* at = piece(i, f);
      const double a = at[0], b = at[1], c = at[2], d = at[3];
      sound[i] =
          b + 0.5 * f * (c - a + f * (2 * a - 5 * b + 4 * c - d + f * (3 * (b - c) + d - a)));
    }
    for (std::size_t i = 0; i < kMemory; ++i)
      past_[i] = wave[static_cast<std::size_t>(count) + i];
  }

  RadiationConstants constants_{};
  double wave_ = 0, before_ = 0, sound_ = 0,
         last_ = 0; // the last wave, the one before; so the sound
  std::array<double, kMemory> past_{};
};

} // namespace tactus::reed
