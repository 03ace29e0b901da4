#pragma once

#include <array>
#include <complex>
#include <span>

namespace tactus::reed {

/// What the bore's line ends in, with `tune`: an unflanged open end, an instrument's own holes and
/// bell, or the bell of a brass instrument.
enum class BoreEnd { kOpen, kClarinet, kSaxophone, kOboe, kTrumpet, kTrombone };

/// One fingering: what an arriving wave meets where the line ends, at the first open tone hole (or
/// at the beginning of the bell): a lattice of open holes, what bore is left, the bell. As
/// functions of s at 20 deg C,
///   H(s) = dc_value + sum over the blocks' poles p and residues r of  r s/(s - p),
/// the reflectance R(s) and what is heard: the pressure at 1 m (root mean square over all
/// directions) is (input radius in m) * T(s) times the arriving wave, referred to the bore's input.
/// Lengths of air scale with its speed of sound, so that H(s c_20/c) holds at another temperature.
///
/// The tables are transfer matrices of documented bores, fitted by
/// bench/reed_bores/terminations.py; |R| <= 1 at every frequency.
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
  double extra_length = 0; // m: path that R leaves out, a pure delay there and back
  std::array<Block, kReflectionBlocks> reflection{};
  std::array<Block, kRadiationBlocks> radiation{}; // T(0) = 0

  struct Value {
    std::complex<double> value, derivative;
  };
  /// R and dR/ds, without the extra length; s in rad/s as it would be at 20 deg C.
  [[nodiscard]] Value reflectance(std::complex<double> s) const noexcept;
  /// Length, m, of open tube without losses that reflects long waves as this does.
  [[nodiscard]] double length_correction() const noexcept;
};

/// Fingerings of an instrument, from low to high, one a semitone; empty for the open end.
[[nodiscard]] std::span<const Termination> terminations(BoreEnd end) noexcept;

/// The bell of a brass instrument, the same for every note (one row, key 0); empty for others.
/// Written by bench/reed_bores/bells.py.
[[nodiscard]] std::span<const Termination> bells(BoreEnd end) noexcept;

/// The fingering of the note nearest to a frequency in Hz, or the first or last where there is
/// none; null for the open end.
[[nodiscard]] const Termination* fingering_for(BoreEnd end, double frequency_hz) noexcept;

/// The same sum at one sample rate, sections side by side, two of a block being
///   x' = a x - w y + g in,   y' = w x + e y + h in,   out = direct in + sum (x + y):
/// with the poles exp(p T) themselves and residues fitted to H from 80 Hz to 12.5 kHz (least
/// squares; H(0) is exact).
template <int blocks> struct DigitalBlocks {
  double direct = 0;
  std::array<double, blocks> a{}, e{}, w{}, g{}, h{};

  /// rate in Hz; speed_ratio = c/c_20.
  void set(const std::array<Termination::Block, blocks>& analog, double dc_value, double rate,
           double speed_ratio, double gain) noexcept;
  /// At exp(i 2 pi f/rate) = 1/back.
  [[nodiscard]] std::complex<double> at(std::complex<double> back) const noexcept {
    std::complex<double> sum = direct;
    for (std::size_t k = 0; k < a.size(); ++k) {
      // (1 - back M)^-1 back (g, h), summed.
      const std::complex<double> p = 1.0 - back * a[k], q = 1.0 - back * e[k], r = back * w[k];
      sum += back * ((q + r) * g[k] + (p - r) * h[k]) / (p * q + r * r);
    }
    return sum;
  }
};
using DigitalReflection = DigitalBlocks<Termination::kReflectionBlocks>;
using DigitalRadiation = DigitalBlocks<Termination::kRadiationBlocks>;

} // namespace tactus::reed
