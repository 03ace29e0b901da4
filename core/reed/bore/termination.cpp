#include "core/reed/bore/termination.hpp"

#include "core/reed/bore/air.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace tactus::reed {
namespace {

using Complex = std::complex<double>;

/// 1/z of an ordinary number, without what std::complex does for extraordinary ones.
Complex inverse(Complex z) { return std::conj(z) / std::norm(z); }

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
  // R = R(0) exp(-2 s l/c) for long waves; looked at where the holes' friction is no longer all.
  constexpr double kOmega = 2 * 3.14159265358979 * 150;
  const Complex r = reflectance({0, kOmega}).value;
  return -std::arg(r / dc_value) * air_at(20).sound_speed / (2 * kOmega) + extra_length;
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

namespace {

/// One real number that a DigitalBlocks is free to choose: the part of its response that grows with
/// it, for x = z^-1, either x/(1 - q x), or that and its mirror image with q*.
struct FreeParameter {
  enum class Kind { kReal, kEven, kOdd } kind;
  Complex digital_pole; // q
  double value = 0;     // at first that of a sampled impulse response
  [[nodiscard]] Complex at(Complex x) const {
    const Complex one = x * inverse(1.0 - digital_pole * x);
    if (kind == Kind::kReal)
      return one;
    const Complex other = x * inverse(1.0 - std::conj(digital_pole) * x);
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

} // namespace

template <int blocks>
void DigitalBlocks<blocks>::set(const std::array<Termination::Block, blocks>& analog,
                                double dc_value, double rate, double speed_ratio,
                                double gain) noexcept {
  const double period = speed_ratio / rate; // at 20 deg C
  constexpr std::size_t kCapacity = 2 * blocks;
  std::array<FreeParameter, kCapacity> free;
  std::size_t count = 0;
  for (const Termination::Block& block : analog)
    if (block.oscillates) {
      const Complex pole(block.a, block.b), digital_pole = std::exp(pole * period);
      const Complex sampled = Complex(block.c, block.d) * pole * digital_pole * period;
      free[count++] = {FreeParameter::Kind::kEven, digital_pole, sampled.real()};
      free[count++] = {FreeParameter::Kind::kOdd, digital_pole, sampled.imag()};
    } else {
      for (const auto& [pole, residue] : {std::pair{block.a, block.c}, {block.b, block.d}})
        if (residue != 0) {
          const double digital_pole = std::exp(pole * period);
          free[count++] = {FreeParameter::Kind::kReal, digital_pole,
                           residue * pole * digital_pole * period};
        }
    }

  // Least squares of what the sampled impulse response lacks from 80 Hz to 12.5 kHz, and a little
  // of it from there to the Nyquist frequency. Nothing is lacking at 0 Hz: `direct` sees to that.
  std::array<Complex, kCapacity> dc_response;
  for (std::size_t k = 0; k < count; ++k)
    dc_response[k] = free[k].at(1);
  std::array<std::array<double, kCapacity>, kCapacity> normal{};
  std::array<double, kCapacity> correction{};
  const double nyquist = std::numbers::pi / period;
  const auto add = [&](double omega, double weight) {
    const Complex s(0, omega), x = std::polar(1.0, -omega * period);
    Complex residual = 0;
    for (const Termination::Block& block : analog)
      for (const Complex& part : terms(block, s))
        residual += part;
    if (dc_value == 0) // from 0 up all levels are heard
      weight /= std::norm(residual) + 1e-12;
    std::array<Complex, kCapacity> shape;
    for (std::size_t k = 0; k < count; ++k) {
      shape[k] = free[k].at(x) - dc_response[k];
      residual -= free[k].value * shape[k];
    }
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t j = 0; j <= k; ++j)
        normal[k][j] += weight * (std::conj(shape[k]) * shape[j]).real();
      correction[k] += weight * (std::conj(shape[k]) * residual).real();
    }
  };
  const double lowest = 2 * std::numbers::pi * 80,
               highest = std::min(2 * std::numbers::pi * 12.5e3, 0.9 * nyquist);
  constexpr int kPoints = 36;
  for (int i = 0; i < kPoints; ++i)
    add(lowest * std::pow(highest / lowest, i / (kPoints - 1.0)), 1);
  for (int i = 1; i <= 8; ++i)
    add(highest * std::pow(0.98 * nyquist / highest, i / 8.0), 1e-3);
  // Where poles are slow or sharp, nothing may come out above 1.
  constexpr int kSlowPoints = 8;
  for (int i = 0; i < kSlowPoints; ++i)
    add(lowest * std::pow(0.01, (i + 0.5) / kSlowPoints), 10);
  for (const Termination::Block& block : analog)
    if (block.oscillates && block.b < highest)
      add(block.b, 1);
  for (std::size_t k = 0; k < count; ++k)
    normal[k][k] *= 1 + 1e-9; // poles may lie close together
  solve(normal, correction, count);

  direct = gain * dc_value;
  std::size_t next = 0;
  const auto next_residue = [&] {
    const double value = gain * (free[next].value + correction[next]);
    direct -= value * dc_response[next].real();
    ++next;
    return value;
  };
  for (std::size_t i = 0; i < analog.size(); ++i) {
    const Termination::Block& block = analog[i];
    if (block.oscillates) {
      // Of a state that turns by q: x + y = Re((1 - i) state), and its input is what makes that
      // twice the real part of the term.
      const Complex digital_pole = free[next].digital_pole;
      const double even = next_residue(), odd = next_residue();
      const Complex input = 2.0 * Complex(even, odd) / Complex(1, -1);
      a[i] = e[i] = digital_pole.real();
      w[i] = digital_pole.imag();
      g[i] = input.real();
      h[i] = input.imag();
    } else {
      a[i] = e[i] = w[i] = g[i] = h[i] = 0;
      if (block.c != 0) {
        a[i] = free[next].digital_pole.real();
        g[i] = next_residue();
      }
      if (block.d != 0) {
        e[i] = free[next].digital_pole.real();
        h[i] = next_residue();
      }
    }
  }

  if (dc_value == 0)
    return;
  // What little a reflectance may still come out above 1 by, above all at rates below 40 kHz.
  double max_squared = 0;
  const auto check_magnitude = [&](double angle) {
    max_squared = std::max(max_squared, std::norm(at(std::polar(1.0, -angle))));
  };
  const int points = rate < 40e3 ? 400 : 60;
  for (int i = 1; i <= points; ++i)
    check_magnitude(std::numbers::pi * i / points);
  for (double angle = lowest * period; angle > 1e-3 * lowest * period; angle *= 0.7)
    check_magnitude(angle);
  for (const Termination::Block& block : analog)
    if (block.oscillates)
      for (const double side : {-2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0})
        check_magnitude(std::min((block.b + side * block.a) * period, std::numbers::pi));
  if (max_squared > 1) {
    // Between the places looked at there may be twice as much.
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
