#include "core/reed/bore/pole_fit.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr std::size_t kMaxPoles = 2 * Termination::kReflectionBlocks;
constexpr std::size_t kMaxUnknowns = 2 * kMaxPoles + 1;
constexpr std::size_t kMaxRows = 2 * kMaxResponsePoints + 1;
constexpr int kIterations = 12;    // iterations that move the poles
constexpr int kRootSteps = 60;     // steps of Aberth's iteration
constexpr double kRealRoot = 1e-6; // |imaginary part|/|root| below which a root is real
// Bounds of the poles. A pole nearer to the frequency axis than the spacing of the points, or
// beyond all points, is not determined by the points and may make |R| > 1.
constexpr double kMinDamping = 4e-3;      // share of the pole's size
constexpr double kMaxPoleMagnitude = 2e5; // rad/s

/// Poles; of each conjugate pair the one with the positive imaginary part comes first.
struct Poles {
  std::array<Complex, kMaxPoles> pole{};
  std::size_t count = 0;

  [[nodiscard]] bool pairs(std::size_t i) const { return pole[i].imag() != 0; }
};

/// Overdetermined linear equations, solved by Householder's reflections.
class LeastSquares {
public:
  explicit LeastSquares(std::size_t unknowns) : unknowns_(unknowns) {}
  [[nodiscard]] double* row(double rhs) {
    rhs_[rows_] = rhs;
    return matrix_[rows_++].data();
  }
  /// An unknown that is linearly dependent on those before it (two equal poles) becomes 0. False
  /// when one appears in no equation.
  [[nodiscard]] bool solve(std::span<double> x) {
    // Columns are normalised, because their units differ.
    std::array<double, kMaxUnknowns> scale{};
    for (std::size_t k = 0; k < unknowns_; ++k) {
      for (std::size_t i = 0; i < rows_; ++i)
        scale[k] += matrix_[i][k] * matrix_[i][k];
      if (!(scale[k] > 0 && scale[k] < 1e200))
        return false;
      scale[k] = 1 / std::sqrt(scale[k]);
    }
    for (std::size_t i = 0; i < rows_; ++i)
      for (std::size_t k = 0; k < unknowns_; ++k)
        matrix_[i][k] *= scale[k];
    for (std::size_t k = 0; k < unknowns_; ++k) {
      double length = 0;
      for (std::size_t i = k; i < rows_; ++i)
        length += matrix_[i][k] * matrix_[i][k];
      length = std::sqrt(length);
      diagonal_[k] = 0;
      if (!(length > 1e-14))
        continue;
      const double pivot = matrix_[k][k], diagonal = pivot > 0 ? -length : length;
      matrix_[k][k] = pivot - diagonal; // this column holds the vector of the reflection
      const double factor = 1 / (diagonal * (pivot - diagonal));
      std::array<double, kMaxUnknowns> projections{};
      double rhs = 0;
      for (std::size_t i = k; i < rows_; ++i) {
        const double v = matrix_[i][k];
        for (std::size_t j = k + 1; j < unknowns_; ++j)
          projections[j] += v * matrix_[i][j];
        rhs += v * rhs_[i];
      }
      for (std::size_t i = k; i < rows_; ++i) {
        const double v = factor * matrix_[i][k];
        for (std::size_t j = k + 1; j < unknowns_; ++j)
          matrix_[i][j] += v * projections[j];
        rhs_[i] += v * rhs;
      }
      diagonal_[k] = diagonal;
    }
    for (std::size_t k = unknowns_; k-- > 0;) {
      double sum = rhs_[k];
      for (std::size_t j = k + 1; j < unknowns_; ++j)
        sum -= matrix_[k][j] * x[j];
      x[k] = diagonal_[k] != 0 ? sum / diagonal_[k] : 0;
    }
    for (std::size_t k = 0; k < unknowns_; ++k)
      x[k] *= scale[k];
    return true;
  }

private:
  std::size_t unknowns_, rows_ = 0;
  std::array<std::array<double, kMaxUnknowns>, kMaxRows> matrix_;
  std::array<double, kMaxRows> rhs_;
  std::array<double, kMaxUnknowns> diagonal_;
};

/// s/(s - p) for a real pole; the sum and i times the difference of both members for a pair.
void basis(Complex s, const Poles& poles, std::array<Complex, kMaxPoles>& columns) {
  for (std::size_t k = 0; k < poles.count; ++k) {
    const Complex one = s / (s - poles.pole[k]);
    if (!poles.pairs(k)) {
      columns[k] = one;
      continue;
    }
    const Complex other = s / (s - poles.pole[k + 1]);
    columns[k] = one + other;
    columns[k + 1] = Complex(0, 1) * (one - other);
    ++k;
  }
}

/// The residue of each pole, from the unknowns of the real basis.
std::array<Complex, kMaxPoles> residues_of(const Poles& poles, std::span<const double> x) {
  std::array<Complex, kMaxPoles> residues{};
  for (std::size_t k = 0; k < poles.count; ++k) {
    if (!poles.pairs(k)) {
      residues[k] = x[k];
      continue;
    }
    residues[k] = {x[k], x[k + 1]};
    residues[k + 1] = {x[k], -x[k + 1]};
    ++k;
  }
  return residues;
}

/// Zeros of d + sum r s/(s - p), all at once (Aberth 1973), turned into the left half plane. False
/// if they are not found.
bool zeros_of(double d, const Poles& poles, const std::array<Complex, kMaxPoles>& residues,
              Poles& zeros) {
  std::array<Complex, kMaxPoles> z{};
  const std::size_t n = poles.count;
  for (std::size_t k = 0; k < n; ++k) // off the axis and off the poles
    z[k] = poles.pole[k] * math::polar(1.0 + 1e-3, 0.01 + 1e-3 * static_cast<double>(k));
  double max_change = 1;
  for (int step = 0; step < kRootSteps && max_change > 1e-12; ++step) {
    max_change = 0;
    for (std::size_t k = 0; k < n; ++k) {
      Complex value = d, slope = 0, others = 0;
      for (std::size_t j = 0; j < n; ++j) {
        const Complex reciprocal = 1.0 / (z[k] - poles.pole[j]);
        value += residues[j] * z[k] * reciprocal;
        slope -= residues[j] * poles.pole[j] * reciprocal * reciprocal;
        others += reciprocal;
        if (j != k)
          others -= 1.0 / (z[k] - z[j]);
      }
      const Complex change = 1.0 / (slope / value + others);
      if (!(math::abs(change) < 1e300))
        return false;
      z[k] -= change;
      max_change = std::max(max_change, math::abs(change) / math::abs(z[k]));
    }
  }
  if (!(max_change < 1e-6))
    return false;
  zeros.count = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double size = math::abs(z[k]);
    const Complex left =
        Complex(-std::max(std::abs(z[k].real()), kMinDamping * size), z[k].imag()) *
        std::min(1.0, kMaxPoleMagnitude / size);
    if (std::abs(z[k].imag()) <= kRealRoot * math::abs(z[k])) {
      if (zeros.count < n)
        zeros.pole[zeros.count++] = left.real();
    } else if (z[k].imag() > 0) {
      if (zeros.count + 2 > n)
        return false;
      zeros.pole[zeros.count++] = left;
      zeros.pole[zeros.count++] = math::conj(left);
    }
  }
  return zeros.count == n;
}

/// One iteration of vector fitting: the poles move to the zeros of sigma, where sigma H and sigma
/// are fitted as sums over the present poles.
bool relocate_poles(std::span<const ResponsePoint> points, double dc_value, Poles& poles) {
  const std::size_t n = poles.count;
  LeastSquares equations(2 * n + 1);
  std::array<Complex, kMaxPoles> columns;
  std::array<double, kMaxUnknowns> relaxation_row{}, x{};
  double size = 0;
  for (const ResponsePoint& point : points) {
    basis({0, point.omega}, poles, columns);
    double* const real = equations.row(0);
    double* const imaginary = equations.row(0);
    const auto set_entry = [&](std::size_t at, Complex value) {
      real[at] = point.weight * value.real();
      imaginary[at] = point.weight * value.imag();
    };
    set_entry(n, dc_value - point.response);
    relaxation_row[n] += 1;
    for (std::size_t k = 0; k < n; ++k) {
      set_entry(k, columns[k]);
      set_entry(n + 1 + k, -point.response * columns[k]);
      relaxation_row[n + 1 + k] += columns[k].real();
    }
    size += math::norm(point.weight * point.response);
  }
  const auto number = static_cast<double>(points.size());
  size = std::sqrt(size) / number;
  double* const row = equations.row(size * number);
  for (std::size_t k = 0; k < 2 * n + 1; ++k)
    row[k] = size * relaxation_row[k];
  if (!equations.solve(std::span(x).first(2 * n + 1)))
    return false;
  Poles zeros;
  if (!zeros_of(x[n], poles, residues_of(poles, std::span(x).subspan(n + 1, n)), zeros))
    return false;
  poles = zeros;
  return true;
}

} // namespace

Complex response_of(double dc_value, std::span<const Termination::Block> blocks,
                    Complex s) noexcept {
  Complex sum = dc_value;
  for (const Termination::Block& block : blocks)
    if (block.oscillates) {
      const Complex pole(block.a, block.b), residue(block.c, block.d);
      sum += s * (residue / (s - pole) + math::conj(residue) / (s - math::conj(pole)));
    } else {
      sum += s * (block.c / (s - block.a) + block.d / (s - block.b));
    }
  return sum;
}

bool fit_poles(std::span<const ResponsePoint> points, double dc_value, double max_omega,
               std::span<Termination::Block> blocks) noexcept {
  Poles poles;
  const std::size_t pairs = std::min(blocks.size(), kMaxPoles / 2);
  if (points.size() > kMaxResponsePoints || points.size() < 2 * pairs + 1)
    return false;
  for (const ResponsePoint& point : points)
    if (!(math::norm(point.response) < 1e100))
      return false;
  for (std::size_t k = 0; k < pairs; ++k) {
    const double share = static_cast<double>(k) / std::max(1.0, static_cast<double>(pairs) - 2);
    const Complex start = k + 1 < pairs ? max_omega / 4 * math::pow(4.0, share) * Complex(-0.15, 1)
                                        : 2 * std::numbers::pi * Complex(-4000, 2000);
    poles.pole[poles.count++] = start;
    poles.pole[poles.count++] = math::conj(start);
  }
  for (int round = 0; round < kIterations; ++round)
    if (!relocate_poles(points, dc_value, poles))
      break;

  LeastSquares equations(poles.count);
  std::array<Complex, kMaxPoles> columns;
  for (const ResponsePoint& point : points) {
    basis({0, point.omega}, poles, columns);
    const Complex rhs = point.weight * (point.response - dc_value);
    double* const real = equations.row(rhs.real());
    double* const imaginary = equations.row(rhs.imag());
    for (std::size_t k = 0; k < poles.count; ++k) {
      real[k] = point.weight * columns[k].real();
      imaginary[k] = point.weight * columns[k].imag();
    }
  }
  std::array<double, kMaxUnknowns> x{};
  if (!equations.solve(std::span(x).first(poles.count)))
    return false;
  const auto residues = residues_of(poles, x);
  std::size_t block = 0;
  double single_pole = 0, single_residue = 0; // a real pole that waits for a second one
  bool has_single = false;
  for (std::size_t k = 0; k < poles.count; ++k)
    if (poles.pairs(k)) {
      blocks[block++] = {true, poles.pole[k].real(), poles.pole[k].imag(), residues[k].real(),
                         residues[k].imag()};
      ++k;
    } else if (has_single) {
      blocks[block++] = {false, single_pole, poles.pole[k].real(), single_residue,
                         residues[k].real()};
      has_single = false;
    } else {
      single_pole = poles.pole[k].real();
      single_residue = residues[k].real();
      has_single = true;
    }
  return true;
}

double largest_response(double dc_value, std::span<const Termination::Block> blocks) noexcept {
  constexpr int kPoints = 600;
  constexpr double kLowest = 0.1, kHighest = 1e7; // rad/s
  const auto size = [&](double logarithm) {
    return math::abs(response_of(dc_value, blocks, {0, math::exp(logarithm)}));
  };
  const double low = math::log(kLowest), step = (math::log(kHighest) - low) / kPoints;
  double largest = std::abs(dc_value), before = largest, here = size(low);
  const auto refine_peak = [&](double a, double b) { // golden section
    for (int k = 0; k < 24; ++k) {
      const double inner = b - 0.618034 * (b - a), outer = a + 0.618034 * (b - a);
      const bool lower = size(inner) > size(outer);
      (lower ? b : a) = lower ? outer : inner;
    }
    largest = std::max(largest, size(0.5 * (a + b)));
  };
  for (int i = 1; i <= kPoints; ++i) {
    const double next = size(low + step * i);
    if (here >= before && here >= next)
      refine_peak(low + step * (i - 2), low + step * i);
    largest = std::max(largest, next);
    before = here;
    here = next;
  }
  for (const Termination::Block& block : blocks) // the peak may be narrower than the steps
    if (block.oscillates && std::abs(block.a) < 0.1 * std::abs(block.b)) {
      const double width = -2 * block.a / std::abs(block.b), at = math::log(std::abs(block.b));
      for (int k = -2; k < 2; ++k)
        refine_peak(at + k * width, at + (k + 1) * width);
    }
  return largest;
}

} // namespace tactus::reed
