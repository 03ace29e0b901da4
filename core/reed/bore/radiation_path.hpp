#pragma once

#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/steepening.hpp"
#include "core/reed/instrument/parameters.hpp"

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
/// back undoes the way out. Above 1, brassiness stands for a louder wave than the bore's own. Where
/// pieces overtake one another the wave breaks: Steepening.
struct RadiationConstants {
  bool plain = true;
  // Poles exact, slope from 0 Hz exact, level at 8 kHz exact.
  double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  double lead = 0; // internal samples for each Pa and metre of bore
  double rate = 0; // Hz, internal

  static RadiationConstants from(const Parameters& parameters, const BoreDesign& bore,
                                 double internal_rate) noexcept;
  /// A share of the way from one to another of the same kind.
  static RadiationConstants interpolate(const RadiationConstants& from,
                                        const RadiationConstants& to, double share) noexcept;
};

/// Computes it.
class RadiationPath {
public:
  static constexpr int kLongest = Steepening::kMaxRun; // internal samples of one run

  /// Allocates what steepening needs up to that internal rate, Hz.
  void prepare(double highest_rate) { steepening_.prepare(highest_rate); }
  void set(const RadiationConstants& constants) noexcept {
    steepening_.set_rate(constants.rate);
    if (constants.plain != constants_.plain)
      reset();
    constants_ = constants;
  }
  void reset() noexcept {
    wave1_ = wave2_ = sound1_ = sound2_ = 0;
    steepening_.reset();
  }
  /// Share of the returning wave b that counts: a - b for the plain end, else a alone.
  [[nodiscard]] double reflected_weight() const noexcept { return constants_.plain ? 1 : 0; }
  [[nodiscard]] bool sane() const noexcept {
    return size(wave1_) < 1e9 && size(sound1_) < 1e9 && size(sound2_) < 1e9 && steepening_.sane();
  }
  void flush_denormals() noexcept {
    for (double* value : {&wave1_, &wave2_, &sound1_, &sound2_})
      if (size(*value) < 1e-20)
        *value = 0;
  }
  /// Loud waves change their shape: steepen() goes before the rest.
  [[nodiscard]] bool steepens() const noexcept { return constants_.lead > 0; }

  /// The way out of the bore, sample by sample; its state goes back into the path at the end of
  /// its life.
  class OutputFilter {
  public:
    [[gnu::always_inline]] explicit OutputFilter(RadiationPath& path) noexcept
        : path_(path), c_(path.constants_), wave1_(path.wave1_), wave2_(path.wave2_),
          sound1_(path.sound1_), sound2_(path.sound2_) {}
    OutputFilter(const OutputFilter&) = delete;
    OutputFilter& operator=(const OutputFilter&) = delete;
    [[gnu::always_inline]] ~OutputFilter() {
      path_.wave1_ = wave1_;
      path_.wave2_ = wave2_;
      path_.sound1_ = sound1_;
      path_.sound2_ = sound2_;
    }
    /// From the wave at the end to the pressure at 1 m, Pa.
    [[gnu::always_inline]] double operator()(double wave) noexcept {
      const double sound =
          ((c_.b0 * wave + c_.b1 * wave1_) + (c_.b2 * wave2_ - c_.a2 * sound2_)) - c_.a1 * sound1_;
      wave2_ = wave1_;
      wave1_ = wave;
      sound2_ = sound1_;
      sound1_ = sound;
      return sound;
    }

  private:
    RadiationPath& path_;
    RadiationConstants c_;
    double wave1_, wave2_, sound1_, sound2_;
  };

  /// Replaces count <= kLongest samples of wave by the sound of a bore of that length, m.
  void run(double* wave, int count, double length) noexcept {
    if (steepens())
      steepening_.run(wave, count, constants_.lead * length);
    OutputFilter output_filter(*this);
    for (int i = 0; i < count; ++i)
      wave[i] = output_filter(wave[i]);
  }

  /// The first half of run() alone: what steepens on the way, before another filter lets it out.
  void steepen_wave(double* wave, int count, double length) noexcept {
    if (steepens())
      steepening_.run(wave, count, constants_.lead * length);
  }

private:
  static double size(double x) noexcept { return x < 0 ? -x : x; }

  RadiationConstants constants_{};
  double wave1_ = 0, wave2_ = 0, sound1_ = 0,
         sound2_ = 0; // the last wave, the one before; so the sound
  Steepening steepening_{};
};

} // namespace tactus::reed
