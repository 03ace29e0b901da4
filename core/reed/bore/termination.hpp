#pragma once

#include "core/dsp/complex.hpp"

#include <array>
#include <span>

namespace tactus::reed {

/// Termination of the bore, with `tune`: an unflanged open end, tone holes and bell of a woodwind,
/// or the bell of a brass instrument.
enum class BoreEnd { kOpen, kClarinet, kSaxophone, kOboe, kTrumpet, kTrombone };

/// Reflectance and radiation of one fingering, seen from the first open tone hole (or the beginning
/// of a brass bell): open holes, the rest of the bore and the bell.
///
/// Both are rational functions of s (rad/s) at 20 deg C, with poles p and residues r in `blocks`,
///   H(s) = dc_value + sum of r s/(s - p).
/// R(s) is the reflectance. T(s) gives the sound: the pressure at 1 m (root mean square over all
/// directions) is (input radius in m) * T(s) times the arriving wave, referred to the bore's input.
/// At another temperature H(s c_20/c) holds, because lengths scale with the speed of sound.
///
/// The tables are transfer matrices of documented bores, fitted by
/// bench/reed_bores/terminations.py, with |R| <= 1 at every frequency.
struct Termination {
  /// Poles a +- i b with residues c +- i d when it oscillates; else poles a and b with residues c
  /// and d. All poles lie in the left half plane.
  struct Block {
    bool oscillates = false;
    double a = -1, b = -1, c = 0, d = 0;
  };
  static constexpr int kReflectionBlocks = 6, kRadiationBlocks = 4; // even

  int key = 0;             // MIDI number of the note, as it sounds
  double dc_value = -1;    // R(0)
  double extra_length = 0; // m: pure delay, forth and back, that R does not contain
  std::array<Block, kReflectionBlocks> reflection{};
  std::array<Block, kRadiationBlocks> radiation{}; // T(0) = 0

  struct Value {
    Complex value, derivative;
  };
  /// R and dR/ds, without the extra length; s in rad/s as it would be at 20 deg C.
  [[nodiscard]] Value reflectance(Complex s) const noexcept;
  /// Length, m, of the lossless open tube with the same reflectance for long waves.
  [[nodiscard]] double length_correction() const noexcept;
};

/// Fingerings of an instrument, from low to high, one per semitone; empty for the open end.
[[nodiscard]] std::span<const Termination> terminations(BoreEnd end) noexcept;

/// The bell of a brass instrument, the same for every note (one row, key 0); empty for others.
/// Written by bench/reed_bores/bells.py.
[[nodiscard]] std::span<const Termination> bells(BoreEnd end) noexcept;

/// The fingering of the note nearest to a frequency in Hz, limited to the instrument's compass;
/// null for ends without fingerings.
[[nodiscard]] const Termination* fingering_for(BoreEnd end, double frequency_hz) noexcept;

/// Digital filter for H(s) of a Termination at one sample rate: parallel second-order sections,
///   x' = a x - w y + g in,   y' = w x + e y + h in,   out = direct in + sum (x + y).
/// The poles are exact, exp(p T); the residues are fitted to H from 80 Hz to 12.5 kHz (least
/// squares), H(0) is exact. Reflectances (dc_value != 0) are scaled to |R| <= 1.
template <int blocks> struct DigitalBlocks {
  double direct = 0;
  std::array<double, blocks> a{}, e{}, w{}, g{}, h{};

  /// Designs the filter: rate in Hz, speed_ratio = c/c_20, gain a factor on H. Takes about 25 us.
  void set(const std::array<Termination::Block, blocks>& analog, double dc_value, double rate,
           double speed_ratio, double gain) noexcept;
  /// Response at back = z^-1.
  [[nodiscard]] Complex at(Complex back) const noexcept {
    Complex sum = direct;
    for (std::size_t k = 0; k < a.size(); ++k) {
      // (1 - back M)^-1 back (g, h), summed.
      const Complex p = 1.0 - back * a[k], q = 1.0 - back * e[k], r = back * w[k];
      sum += back * ((q + r) * g[k] + (p - r) * h[k]) / (p * q + r * r);
    }
    return sum;
  }
};
using DigitalReflection = DigitalBlocks<Termination::kReflectionBlocks>;
using DigitalRadiation = DigitalBlocks<Termination::kRadiationBlocks>;

} // namespace tactus::reed
