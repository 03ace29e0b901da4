#include "core/reed/bore/termination.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/air.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace tactus::reed {
namespace {

/// 1/z for finite z, without the special cases of std::complex.
Complex inverse(Complex z) { return math::conj(z) / math::norm(z); }

/// r s/(s - p) and its derivative.
Termination::Value term(Complex s, Complex pole, Complex residue) {
  const Complex reciprocal = inverse(s - pole);
  return {residue * s * reciprocal, -residue * pole * reciprocal * reciprocal};
}

/// The values of a block's two terms.
std::array<Complex, 2> terms(const Termination::Block& block, Complex s) {
  if (block.oscillates)
    return {term(s, {block.a, block.b}, {block.c, block.d}).value,
            term(s, {block.a, -block.b}, {block.c, -block.d}).value};
  return {term(s, block.a, block.c).value, term(s, block.b, block.d).value};
}

} // namespace

Termination::Value Termination::reflectance(Complex s) const noexcept {
  Value sum{dc_value, 0};
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
  // R = R(0) exp(-2 s l/c) for long waves, evaluated at 150 Hz, above the range of the friction.
  constexpr double kOmega = 2 * 3.14159265358979 * 150;
  const Complex r = reflectance({0, kOmega}).value;
  return -math::arg(r / dc_value) * air_at(20).sound_speed / (2 * kOmega) + extra_length;
}

const Termination* fingering_for(BoreEnd end, double frequency_hz) noexcept {
  const auto rows = terminations(end);
  if (rows.empty())
    return nullptr;
  const double key = 69 + 12 * math::log2(std::max(frequency_hz, 1.0) / 440);
  const double last = static_cast<double>(rows.size() - 1);
  const double row = std::clamp(std::round(key - rows.front().key), 0.0, last);
  return &rows[static_cast<std::size_t>(row)];
}

namespace {

/// One free real number of a DigitalBlocks, which multiplies x/(1 - q x), x = z^-1, or the even or
/// odd combination of this term with the term for q*.
struct FreeParameter {
  enum class Kind { kReal, kEven, kOdd } kind;
  Complex digital_pole; // q
  double value = 0;     // value, at first that of a sampled impulse response
  [[nodiscard]] Complex at(Complex x) const {
    const Complex one = x * inverse(1.0 - digital_pole * x);
    if (kind == Kind::kReal)
      return one;
    const Complex other = x * inverse(1.0 - math::conj(digital_pole) * x);
    return kind == Kind::kEven ? one + other : Complex(0, 1) * (one - other);
  }
};

/// Solves the symmetric positive definite system a x = b, size by size, in place (Cholesky).
template <std::size_t capacity>
void solve(std::array<std::array<double, capacity>, capacity>& a, std::array<double, capacity>& b,
           std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = a[i][j];
      for (std::size_t k = 0; k < j; ++k)
        sum -= a[i][k] * a[j][k];
      a[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / a[j][j];
    }
    for (std::size_t k = 0; k < i; ++k)
      b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t k = i + 1; k < size; ++k)
      b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
}

constexpr double kLowestFitted = 2 * std::numbers::pi * 80; // rad/s

/// The free numbers of a DigitalBlocks, at first those of the sampled impulse response, and their
/// effects at 0 Hz.
template <std::size_t capacity> struct FreeParameters {
  std::array<FreeParameter, capacity> values;
  std::array<Complex, capacity> dc_response;
  std::size_t count = 0;

  FreeParameters(std::span<const Termination::Block> analog, double period) {
    for (const Termination::Block& block : analog)
      if (block.oscillates) {
        const Complex pole(block.a, block.b), digital_pole = math::exp(pole * period);
        const Complex sampled = Complex(block.c, block.d) * pole * digital_pole * period;
        values[count++] = {FreeParameter::Kind::kEven, digital_pole, sampled.real()};
        values[count++] = {FreeParameter::Kind::kOdd, digital_pole, sampled.imag()};
      } else {
        for (const auto& [pole, residue] : {std::pair{block.a, block.c}, {block.b, block.d}})
          if (residue != 0) {
            const double digital_pole = math::exp(pole * period);
            values[count++] = {FreeParameter::Kind::kReal, digital_pole,
                               residue * pole * digital_pole * period};
          }
      }
    for (std::size_t k = 0; k < count; ++k)
      dc_response[k] = values[k].at(1);
  }
};

/// Corrections of the free numbers: least squares of the error of the sampled impulse response from
/// 80 Hz to 12.5 kHz and, with a small weight, from there to the Nyquist frequency. The error at 0
/// Hz is left out, because `direct` corrects it.
template <std::size_t capacity>
std::array<double, capacity> residue_corrections(std::span<const Termination::Block> analog,
                                                 const FreeParameters<capacity>& free,
                                                 double dc_value, double period) {
  std::array<std::array<double, capacity>, capacity> normal{};
  std::array<double, capacity> correction{};
  const double nyquist = std::numbers::pi / period;
  const auto add = [&](double omega, double weight) {
    const Complex s(0, omega), x = math::polar(1.0, -omega * period);
    Complex residual = 0;
    for (const Termination::Block& block : analog)
      for (const Complex& part : terms(block, s))
        residual += part;
    if (dc_value == 0) // a radiated sound: relative errors count
      weight /= math::norm(residual) + 1e-12;
    std::array<Complex, capacity> shape;
    for (std::size_t k = 0; k < free.count; ++k) {
      shape[k] = free.values[k].at(x) - free.dc_response[k];
      residual -= free.values[k].value * shape[k];
    }
    for (std::size_t k = 0; k < free.count; ++k) {
      for (std::size_t j = 0; j <= k; ++j)
        normal[k][j] += weight * (math::conj(shape[k]) * shape[j]).real();
      correction[k] += weight * (math::conj(shape[k]) * residual).real();
    }
  };
  const double highest = std::min(2 * std::numbers::pi * 12.5e3, 0.9 * nyquist);
  constexpr int kPoints = 36;
  for (int i = 0; i < kPoints; ++i)
    add(kLowestFitted * math::pow(highest / kLowestFitted, i / (kPoints - 1.0)), 1);
  for (int i = 1; i <= 8; ++i)
    add(highest * math::pow(0.98 * nyquist / highest, i / 8.0), 1e-3);
  // More points at low frequencies and at the poles, where |R| might exceed 1.
  constexpr int kSlowPoints = 8;
  for (int i = 0; i < kSlowPoints; ++i)
    add(kLowestFitted * math::pow(0.01, (i + 0.5) / kSlowPoints), 10);
  for (const Termination::Block& block : analog)
    if (block.oscillates && block.b < highest)
      add(block.b, 1);
  for (std::size_t k = 0; k < free.count; ++k)
    normal[k][k] *= 1 + 1e-9; // poles may lie close together
  solve(normal, correction, free.count);
  return correction;
}

/// Largest |H|^2 on the unit circle, on a grid that is denser near the poles and towards 0 Hz.
template <int blocks>
double max_squared_magnitude(const DigitalBlocks<blocks>& filter,
                             std::span<const Termination::Block> analog, double rate,
                             double period) {
  double max_squared = 0;
  const auto check = [&](double angle) {
    max_squared = std::max(max_squared, math::norm(filter.at(math::polar(1.0, -angle))));
  };
  const int points = rate < 40e3 ? 400 : 60;
  for (int i = 1; i <= points; ++i)
    check(std::numbers::pi * i / points);
  double angle = kLowestFitted * period;
  while (angle > 1e-3 * kLowestFitted * period) {
    check(angle);
    angle *= 0.7;
  }
  for (const Termination::Block& block : analog)
    if (block.oscillates)
      for (const double side : {-2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0})
        check(std::min((block.b + side * block.a) * period, std::numbers::pi));
  return max_squared;
}

} // namespace

template <int blocks>
void DigitalBlocks<blocks>::set(const std::array<Termination::Block, blocks>& analog,
                                double dc_value, double rate, double speed_ratio,
                                double gain) noexcept {
  const double period = speed_ratio / rate; // at 20 deg C
  const FreeParameters<2 * blocks> free(analog, period);
  const auto correction = residue_corrections<2 * blocks>(analog, free, dc_value, period);

  direct = gain * dc_value;
  std::size_t next = 0;
  const auto next_residue = [&] {
    const double value = gain * (free.values[next].value + correction[next]);
    direct -= value * free.dc_response[next].real();
    ++next;
    return value;
  };
  for (std::size_t i = 0; i < analog.size(); ++i) {
    const Termination::Block& block = analog[i];
    if (block.oscillates) {
      // A state that is multiplied by q per sample has x + y = Re((1 - i) state); its input makes
      // that twice the real part of the term.
      const Complex digital_pole = free.values[next].digital_pole;
      const double even = next_residue(), odd = next_residue();
      const Complex input = 2.0 * Complex(even, odd) / Complex(1, -1);
      a[i] = e[i] = digital_pole.real();
      w[i] = digital_pole.imag();
      g[i] = input.real();
      h[i] = input.imag();
    } else {
      a[i] = e[i] = w[i] = g[i] = h[i] = 0;
      if (block.c != 0) {
        a[i] = free.values[next].digital_pole.real();
        g[i] = next_residue();
      }
      if (block.d != 0) {
        e[i] = free.values[next].digital_pole.real();
        h[i] = next_residue();
      }
    }
  }

  if (dc_value == 0)
    return;
  // A reflectance may still exceed 1 a little, above all at rates below 40 kHz.
  const double max_squared = max_squared_magnitude(*this, analog, rate, period);
  if (max_squared > 1) {
    // Between the points of the grid the excess may be twice as large.
    const double reduction = 1 / (1 + 2 * (std::sqrt(max_squared) - 1) + 1e-9);
    direct *= reduction;
    for (std::size_t i = 0; i < analog.size(); ++i) {
      g[i] *= reduction;
      h[i] *= reduction;
    }
  }
}

template struct DigitalBlocks<Termination::kReflectionBlocks>;
template struct DigitalBlocks<Termination::kRadiationBlocks>;

} // namespace tactus::reed
