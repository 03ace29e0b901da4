#pragma once

#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/steepening.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// Coefficients of the filter from the wave a at the end of the bore to the sound pressure p at d =
/// 1 m, averaged over all directions (Pa to Pa), for one internal sample rate.
///
/// Plain open end (bell = 0): a point source of the flow that leaves it, b the reflected wave,
///   p = rho/(4 pi d) d/dt (a - b)/Z_0.
/// Bell or open tone holes, cut-off w_c = 2 pi bell: r is the bore's input radius, r_1 its radius
/// at the opening, k = w/c. Two limits follow from conservation of mass and of energy,
///   w << w_c: point source of twice the flow,   |p| = a r/(2d) k r_1,
///   w >> w_c: all the power leaves,             |p| = a r/(2d),
/// and the transition is the simplest rational function with both,
///   p = r/(2d) s (s + w_c^2 r_1/c)/(s^2 + s w_c/Q + w_c^2) a,   Q = bell_quality.
/// Cut-offs of bells and lattices: Benade 1976, Fundamentals of Musical Acoustics, ch. 20 and 21.
///
/// A wave of finite amplitude steepens on its way out, because it travels faster where the pressure
/// is higher. A piece at the pressure a arrives earlier by (simple wave in a tube; Hirschberg,
/// Gilbert, Msallam & Wijnands 1996)
///   (gamma + 1)/(2 gamma P_0 c) * brassiness * L * a   seconds.
/// Steepening computes it, shocks included. The bore itself is linear: in it the return path undoes
/// the steepening of the outward path (docs/results/greed.md). brassiness > 1 represents a wave
/// that is louder than the wave in the bore.
struct RadiationConstants {
  bool plain = true; // bell = 0
  // y = b0 x + b1 x_1 + b2 x_2 - a1 y_1 - a2 y_2: poles, slope at 0 Hz and gain at 8 kHz are exact.
  double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  double lead = 0; // internal samples per Pa and metre of bore
  double rate = 0; // Hz, internal

  static RadiationConstants from(const Parameters& parameters, const BoreDesign& bore,
                                 double internal_rate) noexcept;
  /// Linear interpolation, share in 0..1, between two sets of constants of the same kind.
  static RadiationConstants interpolate(const RadiationConstants& from,
                                        const RadiationConstants& to, double share) noexcept;
};

/// The filter of RadiationConstants with its state: from the wave that leaves the bore to the sound
/// at 1 m.
class RadiationPath {
public:
  static constexpr int kMaxRun = Steepening::kMaxRun; // internal samples of one run

  /// Allocates for internal rates up to highest_rate, Hz.
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
  /// Weight of the reflected wave b in the input: 1 for the plain end (a - b), else 0 (a).
  [[nodiscard]] double reflected_weight() const noexcept { return constants_.plain ? 1 : 0; }
  /// False when a state is NaN or above 1e9.
  [[nodiscard]] bool is_bounded() const noexcept {
    return size(wave1_) < 1e9 && size(sound1_) < 1e9 && size(sound2_) < 1e9 &&
           steepening_.is_bounded();
  }
  void flush_denormals() noexcept {
    for (double* value : {&wave1_, &wave2_, &sound1_, &sound2_})
      if (size(*value) < 1e-20)
        *value = 0;
  }
  /// True if steepen() changes the wave.
  [[nodiscard]] bool steepens() const noexcept { return constants_.lead > 0; }

  /// The filter for a block of samples, with coefficients and state in registers; its destructor
  /// stores the state.
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
    /// Pressure at 1 m, Pa, of the next sample of the wave, Pa.
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

  /// Replaces count <= kMaxRun samples of the wave by their sound; length: of the bore, m.
  void run(double* wave, int count, double length) noexcept {
    steepen(wave, count, length);
    OutputFilter output_filter(*this);
    for (int i = 0; i < count; ++i)
      wave[i] = output_filter(wave[i]);
  }

  /// The steepening of run() alone, if another filter follows.
  void steepen(double* wave, int count, double length) noexcept {
    if (steepens())
      steepening_.run(wave, count, constants_.lead * length);
  }

private:
  static double size(double x) noexcept { return x < 0 ? -x : x; }

  RadiationConstants constants_{};
  double wave1_ = 0, wave2_ = 0;   // input one and two samples ago
  double sound1_ = 0, sound2_ = 0; // output
  Steepening steepening_{};
};

} // namespace tactus::reed
