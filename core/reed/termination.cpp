#include "core/reed/termination.hpp"

#include "core/reed/air.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

using Complex = std::complex<double>;

/// r s/(s - p) and its derivative.
Termination::Value term(Complex s, Complex pole, Complex residue) {
  const Complex under = 1.0 / (s - pole);
  return {residue * s * under, -residue * pole * under * under};
}

} // namespace

Termination::Value Termination::reflectance(Complex s) const noexcept {
  Value sum{at_zero, 0};
  const auto add = [&](Complex pole, Complex residue) {
    const Value one = term(s, pole, residue);
    sum.value += one.value;
    sum.derivative += one.derivative;
  };
  for (const Block& block : reflection)
    if (block.oscillates) {
      add({block.a, block.b}, {block.c, block.d});
      add({block.a, -block.b}, {block.c, -block.d});
    } else {
      add(block.a, block.c);
      add(block.b, block.d);
    }
  return sum;
}

double Termination::length_correction() const noexcept {
  // R = R(0) exp(-2 s l/c) for long waves; looked at where the holes' friction is no longer all.
  constexpr double kOmega = 2 * 3.14159265358979 * 150;
  const Complex r = reflectance({0, kOmega}).value;
  return -std::arg(r / at_zero) * air_at(20).sound_speed / (2 * kOmega) + extra_length;
}

const Termination* fingering_for(BoreEnd end, double frequency_hz) noexcept {
  const auto rows = terminations(end);
  if (rows.empty())
    return nullptr;
  const double key = 69 + 12 * std::log2(std::max(frequency_hz, 1.0) / 440);
  const double last = static_cast<double>(rows.size() - 1);
  const double row = std::clamp(std::round(key - rows.front().key), 0.0, last);
  return &rows[static_cast<std::size_t>(row)];
}

template <int blocks>
void DigitalBlocks<blocks>::set(const std::array<Termination::Block, blocks>& analog,
                                double at_zero, double rate, double speed_ratio,
                                double gain) noexcept {
  // s = K (1 - z^-1)/(1 + z^-1): r s/(s - p) = r K/(K - p) (1 + (q - 1) z^-1/(1 - q z^-1)),
  // q = (K + p)/(K - p).
  const double k = 2 * rate / speed_ratio;
  direct = gain * at_zero;
  for (std::size_t i = 0; i < analog.size(); ++i) {
    const Termination::Block& block = analog[i];
    if (block.oscillates) {
      const Complex pole(block.a, block.b), residue(block.c, block.d);
      const Complex over = k / (k - pole), q = (k + pole) / (k - pole);
      direct += gain * 2 * (residue * over).real();
      // Of a state that turns by q: x + y = Re((1 - i) state), and its input is what makes that
      // twice the real part of the term.
      const Complex input = 2 * gain * residue * over * (q - 1.0) / Complex(1, -1);
      a[i] = e[i] = q.real();
      w[i] = q.imag();
      g[i] = input.real();
      h[i] = input.imag();
    } else {
      const auto section = [&](double pole, double residue, double& turn, double& input) {
        const double over = k / (k - pole);
        turn = (k + pole) / (k - pole);
        input = gain * residue * over * (turn - 1);
        direct += gain * residue * over;
      };
      section(block.a, block.c, a[i], g[i]);
      section(block.b, block.d, e[i], h[i]);
      w[i] = 0;
    }
  }
}

template struct DigitalBlocks<Termination::kReflectionBlocks>;
template struct DigitalBlocks<Termination::kRadiationBlocks>;

} // namespace tactus::reed
