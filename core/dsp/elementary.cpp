#include "core/dsp/elementary.hpp"

#include "core/dsp/complex.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

namespace tactus::math {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMax = std::numeric_limits<double>::max();
constexpr double kMin = std::numeric_limits<double>::min(); // the smallest normal number

constexpr std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
constexpr double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }
constexpr double size_of(double x) { return from_bits(bits_of(x) & ~(1ULL << 63)); }
constexpr bool is_negative(double x) { return bits_of(x) >> 63; }
/// x with the sign of `from`.
constexpr double with_sign(double x, double from) {
  return from_bits((bits_of(x) & ~(1ULL << 63)) | (bits_of(from) & (1ULL << 63)));
}
/// 2^k for -1022 <= k <= 1023.
constexpr double power_of_two(std::int64_t k) {
  return from_bits(static_cast<std::uint64_t>(k + 1023) << 52);
}
/// The upper 26 bits of x: the product of two such numbers is exact.
constexpr double upper_half(double x) { return from_bits(bits_of(x) & ~((1ULL << 27) - 1)); }

/// hi + lo, with |lo| of at most about half a unit in the last place of hi.
struct Pair {
  double hi = 0, lo = 0;
};
/// a + b for |a| >= |b|, or for an a that is a multiple of b's last place.
constexpr Pair ordered_sum(double a, double b) {
  const double hi = a + b;
  return {hi, b - (hi - a)};
}
constexpr Pair sum(double a, double b) {
  const double hi = a + b, part = hi - a;
  return {hi, (a - (hi - part)) + (b - part)};
}
constexpr Pair sum(Pair a, Pair b) {
  const Pair s = sum(a.hi, b.hi);
  return ordered_sum(s.hi, s.lo + (a.lo + b.lo));
}
constexpr Pair product(double a, double b) {
  const double hi = a * b, a1 = upper_half(a), b1 = upper_half(b), a2 = a - a1, b2 = b - b1;
  return {hi, ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2};
}
constexpr Pair product(Pair a, Pair b) {
  const Pair p = product(a.hi, b.hi);
  return ordered_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
constexpr Pair quotient(Pair a, Pair b) {
  const double inverse = 1 / b.hi, first = a.hi * inverse;
  const Pair p = product(first, b.hi);
  return ordered_sum(first, (((a.hi - p.hi) - p.lo) + (a.lo - first * b.lo)) * inverse);
}
constexpr double value(Pair a) { return a.hi + a.lo; }

constexpr Pair kLn2{std::numbers::ln2, 0x1.abc9e3b39803fp-56};
constexpr Pair kLn10{std::numbers::ln10, -0x1.f48ad494ea3e9p-53};
constexpr Pair kLog2e{std::numbers::log2e, 0x1.777d0ffda0d24p-56};
constexpr Pair kLog10e{std::numbers::log10e, 0x1.95355baaafad3p-57};
constexpr Pair kHalfPi{std::numbers::pi / 2, 0x1.1a62633145c07p-54};
constexpr Pair kHalfLogTwoPi{0x1.d67f1c864beb5p-1, -0x1.65b5a1b7ff5dfp-55};

// ---- exponentials ----------------------------------------------------------------------------

/// 2^(j/128) = power[j] (1 + rest[j]).
struct Powers {
  static constexpr std::size_t kCount = 128;
  std::array<double, kCount> power{}, rest{};
};
constexpr Powers power_table() {
  Pair step{1, 0}, term{1, 0}; // step = 2^(1/128) by its Taylor series
  for (int n = 1; n < 16; ++n) {
    term = quotient(product(term, kLn2), {128.0 * n, 0});
    step = sum(step, term);
  }
  Powers table;
  Pair p{1, 0};
  for (std::size_t j = 0; j < Powers::kCount; ++j, p = product(p, step)) {
    table.power[j] = p.hi;
    table.rest[j] = p.lo / p.hi;
  }
  return table;
}
constexpr Powers kPowers = power_table();

constexpr double kRound = 0x1.8p52; // x + kRound has the integer nearest to x in its last bits

/// 2^(steps/128) (1 + part): its steps, the last 7 bits of which are the table's, and its part.
struct Exponential {
  std::uint64_t steps;
  double part;

  [[nodiscard]] double power() const { return kPowers.power[steps % Powers::kCount]; }
  [[nodiscard]] std::int64_t exponent() const { return static_cast<std::int64_t>(steps) >> 7; }
  /// 2^(steps/128), normal.
  [[nodiscard]] double scale() const {
    return from_bits(bits_of(power()) + (static_cast<std::uint64_t>(exponent()) << 52));
  }
  /// Rounds once, also when the result is subnormal.
  [[nodiscard]] double value() const {
    const std::int64_t k = exponent();
    if (k > -1021 && k < 1023)
      return scale() + scale() * part;
    return (power() + power() * part) * power_of_two(k / 2) * power_of_two(k - k / 2);
  }
};

/// 2^(steps/128) e^r for |r| < 0.0028.
inline Exponential exponential(std::uint64_t steps, double r) {
  const double r2 = r * r;
  return {steps, kPowers.rest[steps % Powers::kCount] +
                     (r + r2 * (0.5 + r * (1.0 / 6)) + (r2 * r2) * (1.0 / 24 + r * (1.0 / 120)))};
}

/// e^(x + low) for |x| < 800 and a small low.
inline Exponential exp_of(double x, double low = 0) {
  constexpr double kPerStep = 128 * std::numbers::log2e;
  constexpr double kStepHigh = from_bits(bits_of(std::numbers::ln2 / 128) & ~((1ULL << 20) - 1));
  constexpr double kStepLow = (std::numbers::ln2 / 128 - kStepHigh) + kLn2.lo / 128;
  const double shifted = x * kPerStep + kRound, steps = shifted - kRound;
  return exponential(bits_of(shifted) - bits_of(kRound),
                     (x - steps * kStepHigh) + (low - steps * kStepLow));
}

} // namespace

double exp(double x) noexcept {
  if (!(size_of(x) < 745.2)) // e^-745.14 is half the smallest subnormal number
    return x > 0 ? kInfinity : (x < 0 ? 0 : x);
  return exp_of(x).value();
}

double exp2(double x) noexcept {
  if (!(size_of(x) < 1080))
    return x > 0 ? kInfinity : (x < 0 ? 0 : x);
  const double shifted = x + kRound / 128, r = x - (shifted - kRound / 128); // |r| <= 1/256, exact
  return exponential(bits_of(shifted) - bits_of(kRound / 128), r * std::numbers::ln2).value();
}

double exp10(double x) noexcept {
  if (!(size_of(x) < 330))
    return x > 0 ? kInfinity : (x < 0 ? 0 : x);
  // 10^r for r = x - steps log10(2)/128: by e^(r ln 10)
  constexpr Pair kStep = quotient({kLn2.hi / 128, kLn2.lo / 128}, kLn10);
  constexpr double kHigh = from_bits(bits_of(kStep.hi) & ~((1ULL << 20) - 1));
  constexpr double kLow = (kStep.hi - kHigh) + kStep.lo;
  const double shifted = x * (128 / std::numbers::ln2 * std::numbers::ln10) + kRound;
  const double steps = shifted - kRound;
  const double r = ((x - steps * kHigh) - steps * kLow) * std::numbers::ln10;
  return exponential(bits_of(shifted) - bits_of(kRound), r).value();
}

double expm1(double x) noexcept {
  const double size = size_of(x);
  if (size < 0x1p-54)
    return x;
  if (size < 0.25) {
    // x + x^2/2! + ... + x^13/13!
    const double x2 = x * x, x4 = x2 * x2;
    const double a = 1.0 / 6 + x * (1.0 / 24), b = 1.0 / 120 + x * (1.0 / 720);
    const double c = 1.0 / 5040 + x * (1.0 / 40320), d = 1.0 / 362880 + x * (1.0 / 3628800);
    const double e = 1.0 / 39916800 + x * (1.0 / 479001600) + x2 * (1.0 / 6227020800);
    return x + (0.5 * x2 + x2 * x * ((a + x2 * b) + x4 * ((c + x2 * d) + x4 * e)));
  }
  if (!(size < 40))
    return x > 0 ? exp(x) : (x < 0 ? -1 : x);
  const Exponential power = exp_of(x);
  const double scale = power.scale();
  const Pair rest = sum(scale, -1);
  return rest.hi + (rest.lo + scale * power.part);
}

// ---- logarithms ------------------------------------------------------------------------------

namespace {

/// For each of 128 intervals of x, 1/c to 8 bits for a c in its middle, and log c.
struct Logarithms {
  static constexpr std::size_t kCount = 128;
  std::array<double, kCount> inverse{};
  std::array<Pair, kCount> log{}; ///< hi on the grid
};
/// The multiple of 2^-42 nearest to x. k log 2 + log c is exact in this grid.
constexpr double on_grid(double x) {
  constexpr double kShift = 1.5 * 0x1p52 * 0x1p-42;
  return (x + kShift) - kShift;
}
// The first interval begins at 0.697. One of them has 1 in its middle: there c = 1 and the result
// has no error by cancellation.
constexpr std::uint64_t kFirstInterval = bits_of(1.0) - (77ULL << 45) - (1ULL << 44);
constexpr Logarithms logarithm_table() {
  Logarithms table;
  for (std::size_t j = 0; j < Logarithms::kCount; ++j) {
    const double middle = from_bits(kFirstInterval + (std::uint64_t{j} << 45) + (1ULL << 44));
    const double inverse = static_cast<double>(static_cast<int>(256 / middle + 0.5)) / 256;
    // -log a = 2 artanh s, s = (1 - a)/(1 + a).
    const Pair s = quotient({1 - inverse, 0}, {1 + inverse, 0}), square = product(s, s);
    Pair result{}, power = s;
    for (int n = 1; n < 50; n += 2, power = product(power, square))
      result = sum(result, quotient(power, {0.5 * n, 0}));
    table.inverse[j] = inverse;
    table.log[j] = {on_grid(result.hi), (result.hi - on_grid(result.hi)) + result.lo};
  }
  return table;
}
constexpr Logarithms kLogarithms = logarithm_table();

/// For x = 2^k c (1 + r), |r| < 0.006: log 2^k c, and r.
struct NearCentre {
  Pair log; ///< hi on the grid
  Pair r;
};
/// Of a normal number x > 0 times 2^exponent.
inline NearCentre near_centre(double x, std::int64_t exponent) {
  constexpr double kLn2High = on_grid(std::numbers::ln2);
  constexpr double kLn2Low = (std::numbers::ln2 - kLn2High) + kLn2.lo;
  const std::uint64_t from_first = bits_of(x) - kFirstInterval;
  const std::size_t j = (from_first >> 45) % Logarithms::kCount;
  const double inverse = kLogarithms.inverse[j];
  const Pair centre = kLogarithms.log[j];
  const double z = from_bits(bits_of(x) - (from_first & ~((1ULL << 52) - 1)));
  const auto k = static_cast<double>((static_cast<std::int64_t>(from_first) >> 52) + exponent);
  // z/c - 1 in two parts, exact: 1/c has 9 bits and z's upper part, rounded, 24. So the square of
  // r.hi is exact, too.
  const double upper = from_bits((bits_of(z) + (1ULL << 29)) & ~((1ULL << 30) - 1));
  return {{k * kLn2High + centre.hi, k * kLn2Low + centre.lo},
          {upper * inverse - 1, (z - upper) * inverse}};
}

/// log(2^exponent x) for a normal number x > 0, with 67 bits. lo may be larger than hi's last
/// place.
inline Pair log_of(double x, std::int64_t exponent = 0) {
  const NearCentre at = near_centre(x, exponent);
  const double r1 = at.r.hi, r2 = at.r.lo;
  const Pair r = ordered_sum(r1, r2), first = ordered_sum(at.log.hi, r.hi);
  const Pair second = ordered_sum(first.hi, -0.5 * (r1 * r1));
  const double rest = r.lo - r2 * (r1 + 0.5 * r2), square = r.hi * r.hi;
  const double tail =
      square * r.hi *
      ((1.0 / 3 - r.hi * (1.0 / 4)) +
       square * ((1.0 / 5 - r.hi * (1.0 / 6)) + square * (1.0 / 7 - r.hi * (1.0 / 8))));
  return {second.hi, ((first.lo + second.lo) + at.log.lo) + (rest + tail)};
}

/// log x for any x > 0 that is finite.
inline Pair log_of_positive(double x) { return x < kMin ? log_of(x * 0x1p52, -52) : log_of(x); }
/// log of 0, negative numbers, infinity and NaN.
double log_of_other(double x) { return x == 0 ? -kInfinity : (x > 0 ? x : (x < 0 ? kNan : x)); }
inline bool is_positive(double x) { return x > 0 && x <= kMax; }
/// The product of a sum and a constant.
inline double times(Pair a, Pair b) {
  const double a1 = upper_half(a.hi + a.lo), a2 = (a.hi - a1) + a.lo;
  const double b1 = upper_half(b.hi), b2 = (b.hi - b1) + b.lo;
  return a1 * b1 + (a1 * b2 + a2 * b.hi);
}

} // namespace

double log(double x) noexcept {
  std::int64_t exponent = 0;
  if (!(x >= kMin && x <= kMax)) {
    if (!is_positive(x))
      return log_of_other(x);
    x *= 0x1p52;
    exponent = -52;
  }
  const NearCentre at = near_centre(x, exponent);
  const Pair r = ordered_sum(at.r.hi, at.r.lo), first = ordered_sum(at.log.hi, r.hi);
  const double square = r.hi * r.hi;
  return first.hi +
         (((first.lo + r.lo) + at.log.lo) +
          square * ((r.hi * (1.0 / 3) - 0.5) + square * ((r.hi * (1.0 / 5) - 1.0 / 4) +
                                                         square * (r.hi * (1.0 / 7) - 1.0 / 6))));
}

double log2(double x) noexcept {
  return is_positive(x) ? times(log_of_positive(x), kLog2e) : log_of_other(x);
}

double log10(double x) noexcept {
  return is_positive(x) ? times(log_of_positive(x), kLog10e) : log_of_other(x);
}

double log1p(double x) noexcept {
  if (size_of(x) < 0x1p-54)
    return x;
  const Pair y = sum(1, x);
  if (!is_positive(y.hi))
    return log_of_other(y.hi);
  const Pair result = log_of(y.hi);
  return result.hi + (result.lo + y.lo / y.hi);
}

// ---- powers and roots ------------------------------------------------------------------------

namespace {

enum class Parity { kFraction, kEven, kOdd };
/// Of a finite number.
Parity parity_of(double y) {
  const double size = size_of(y);
  if (size >= 0x1p53)
    return Parity::kEven;
  if (size != std::floor(size))
    return Parity::kFraction;
  return static_cast<std::uint64_t>(size) % 2 ? Parity::kOdd : Parity::kEven;
}

/// e^(log y) for a y from 2^-64 to 2^64.
inline double power_of(Pair log, double y) {
  // The product of the upper halves is exact.
  const double log1 = upper_half(log.hi + log.lo), log2 = (log.hi - log1) + log.lo;
  const double y1 = upper_half(y), upper = log1 * y1, lower = log1 * (y - y1) + log2 * y;
  if (!(size_of(upper) < 745.5))
    return upper > 0 ? kInfinity : 0;
  return exp_of(upper, lower).value();
}

} // namespace

double pow(double x, double y) noexcept {
  if (x >= kMin && x <= kMax && size_of(y) >= 0x1p-64 && size_of(y) <= 0x1p64)
    return power_of(log_of(x), y);
  if (y == 0 || x == 1)
    return 1;
  if (x != x || y != y)
    return kNan;
  const double size = size_of(x);
  if (size_of(y) > kMax)
    return size == 1 ? 1 : ((size > 1) == (y > 0) ? kInfinity : 0);
  double sign = 1;
  if (is_negative(x)) {
    const Parity parity = parity_of(y);
    if (parity == Parity::kFraction && size > 0 && size <= kMax)
      return kNan;
    sign = parity == Parity::kOdd ? -1 : 1;
  }
  if (size == 0 || size > kMax)
    return sign * ((size == 0) == (y > 0) ? 0 : kInfinity);
  if (size_of(y) > 0x1p64) // the result is 1, 0 or infinite
    return size == 1 ? sign : sign * ((size > 1) == (y > 0) ? kInfinity : 0);
  if (size_of(y) < 0x1p-64)
    return sign;
  return sign * power_of(log_of_positive(size), y);
}

double cbrt(double x) noexcept {
  if (x == 0 || !(size_of(x) <= kMax))
    return x;
  double size = size_of(x), scale = 1;
  if (size < kMin) {
    size *= 0x1p54;
    scale = 0x1p-18;
  } else if (size > 0x1p1000) {
    size *= 0x1p-54;
    scale = 0x1p18;
  }
  // A third of the exponent and of the mantissa: 5 %. Halley's step triples the digits (1e-4,
  // 1e-12); the second leaves 26 bits, so that t^2 is exact, and Newton's corrects the rest.
  constexpr std::uint64_t kBias = 0x2a9f7893ULL << 32; // (1023 - 1023/3 - 0.0331) 2^52
  double t = from_bits(bits_of(size) / 3 + kBias);
  for (int round = 0; round < 2; ++round) {
    const double cube = t * t * t;
    t *= (cube + 2 * size) / (2 * cube + size);
  }
  t = from_bits((bits_of(t) + (1ULL << 26)) & ~((1ULL << 27) - 1));
  const double other = size / (t * t);
  return with_sign(scale * (t + t * ((other - t) / (2 * t + other))), x);
}

double hypot(double x, double y) noexcept {
  double a = size_of(x), b = size_of(y);
  if (!(a <= kMax && b <= kMax))
    return a == kInfinity || b == kInfinity ? kInfinity : kNan;
  if (a < b) {
    const double other = a;
    a = b;
    b = other;
  }
  if (b <= a * 0x1p-54)
    return a + b;
  double scale = 1;
  if (a > 0x1p500) {
    scale = 0x1p600;
    a *= 0x1p-600;
    b *= 0x1p-600;
  } else if (b < 0x1p-450) {
    scale = 0x1p-600;
    a *= 0x1p600;
    b *= 0x1p600;
  }
  const Pair square = product(a, a), other = product(b, b);
  return scale * std::sqrt(((square.lo + other.lo) + other.hi) + square.hi);
}

// ---- circular functions ----------------------------------------------------------------------

namespace {

/// x = quadrant pi/2 + (hi + lo), |hi| <= pi/4 and a little.
struct Reduced {
  unsigned quadrant;
  double hi, lo;
};

/// The bits of 2/pi behind its binary point, after 64 zeros.
constexpr std::array<std::uint64_t, 21> kTwoOverPi{
    0,
    0xa2f9836e4e441529,
    0xfc2757d1f534ddc0,
    0xdb6295993c439041,
    0xfe5163abdebbc561,
    0xb7246e3a424dd2e0,
    0x06492eea09d1921c,
    0xfe1deb1cb129a73e,
    0xe88235f52ebb4484,
    0xe99c7026b45f7e41,
    0x3991d639835339f4,
    0x9c845f8bbdf9283b,
    0x1ff897ffde05980f,
    0xef2f118b5a0a6d1f,
    0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d,
    0x7527bac7ebe5f17b,
    0x3d0739f78a5292ea,
    0x6bfb5fb11f8d5d08,
    0x56033046fc7b6bab,
    0xf0cfbc209af4361d,
};

/// Payne & Hanek: of the product of x and 2/pi only 192 bits matter: two of the whole part, the
/// quadrant, and 190 of the fraction, of which up to 62 are 0 or 1 throughout. For pi/4 <= x.
Reduced reduce_by_digits(double x) {
  const std::uint64_t mantissa = (bits_of(x) & ((1ULL << 52) - 1)) | (1ULL << 52);
  const auto exponent =
      static_cast<std::int64_t>(bits_of(x) >> 52) - 1075; // x = mantissa 2^exponent
  // The digit of weight 2^(1 - exponent) is the first that matters; six words of 32 bits from it.
  const auto first = static_cast<std::size_t>(62 + exponent);
  std::array<std::uint64_t, 6> digits{};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t bit = first + 32 * i, word = bit / 64, offset = bit % 64;
    std::uint64_t both = kTwoOverPi[word] << offset;
    if (offset > 0 && word + 1 < kTwoOverPi.size())
      both |= kTwoOverPi[word + 1] >> (64 - offset);
    digits[i] = both >> 32;
  }
  // The product without its overflow, the last word first.
  std::array<std::uint64_t, 6> p{};
  const std::uint64_t low = mantissa & 0xffffffff, high = mantissa >> 32;
  std::uint64_t carry = 0;
  for (std::size_t i = 6; i-- > 0;) {
    const std::uint64_t one = digits[i] * low, two = i < 5 ? digits[i + 1] * high : 0;
    const std::uint64_t low_sum = (one & 0xffffffff) + (two & 0xffffffff) + (carry & 0xffffffff);
    p[i] = low_sum & 0xffffffff;
    carry = (carry >> 32) + (one >> 32) + (two >> 32) + (low_sum >> 32);
  }
  unsigned quadrant = static_cast<unsigned>(p[0] >> 30);
  p[0] &= 0x3fffffff;
  const bool negative = p[0] >> 29; // the fraction is 1/2 or more: to the next quadrant
  if (negative) {
    ++quadrant;
    for (auto& word : p) // 1 - fraction; what the last place is short of is below its error
      word ^= 0xffffffff;
    p[0] &= 0x3fffffff;
  }
  Pair fraction{};
  double weight = 0x1p-190;
  for (std::size_t i = 6; i-- > 0; weight *= 0x1p32) {
    const Pair next = ordered_sum(static_cast<double>(p[i]) * weight, fraction.hi);
    fraction = {next.hi, next.lo + fraction.lo};
  }
  const Pair y = product(ordered_sum(fraction.hi, fraction.lo), kHalfPi);
  return {quadrant, negative ? -y.hi : y.hi, negative ? -y.lo : y.lo};
}

inline Reduced reduce(double x) {
  const double size = size_of(x);
  if (size <= 0.7853981633974483) // pi/4
    return {0, x, 0};
  // pi/2 in three parts: the first two have 33 bits, so that n times these is exact for n < 2^20.
  constexpr double kFirst = 0x1.921fb544p+0, kSecond = 0x1.0b4611a6p-34,
                   kThird = 0x1.3198a2e037073p-69;
  if (size < 0x1p20) {
    const double shifted = x * (2 / std::numbers::pi) + kRound, n = shifted - kRound;
    // The first difference is exact, and a multiple of the last place of what follows.
    const Pair y = ordered_sum(x - n * kFirst, -(n * kSecond));
    if (size_of(y.hi) > 0x1p-20) { // else the three parts leave too few digits
      const Pair r = ordered_sum(y.hi, y.lo - n * kThird);
      return {static_cast<unsigned>(bits_of(shifted)), r.hi, r.lo};
    }
  }
  const Reduced r = reduce_by_digits(size);
  return is_negative(x) ? Reduced{0U - r.quadrant, -r.hi, -r.lo} : r;
}

/// sin(y + low) for |y| <= pi/4: a polynomial of degree 13, error 2^-57.9 of the result.
inline Pair sine_parts(double y, double low) {
  const double z = y * y, z2 = z * z, cube = z * y;
  const double r =
      (0.008333333333321903 - z * 0.0001984126982943917) +
      z2 * ((2.755731357400289e-06 - z * 2.505074084968086e-08) + z2 * 1.5895850296066635e-10);
  return {y, -((z * (0.5 * low - cube * r) - low) + cube * 0.1666666666666663)};
}
/// cos(y + low) for |y| <= pi/4: a polynomial of degree 14, error 2^-63.
inline Pair cosine_parts(double y, double low) {
  const double z = y * y, z2 = z * z, half = 0.5 * z, w = 1 - half;
  const double r = z * ((0.041666666666666595 - z * 0.0013888888888873448) +
                        z2 * ((2.480158728910544e-05 - z * 2.755731425306134e-07) +
                              z2 * (2.0875710774542552e-09 - z * 1.1359041439039709e-11)));
  return {w, ((1 - w) - half) + (z * r - y * low)};
}
inline double sine_of(const Reduced& r) { return value(sine_parts(r.hi, r.lo)); }
inline double cosine_of(const Reduced& r) { return value(cosine_parts(r.hi, r.lo)); }

} // namespace

SineCosine sincos(double x) noexcept {
  if (!(size_of(x) <= kMax))
    return {kNan, kNan};
  const Reduced r = reduce(x);
  const double s = sine_of(r), c = cosine_of(r);
  switch (r.quadrant % 4) {
  case 0:
    return {s, c};
  case 1:
    return {c, -s};
  case 2:
    return {-s, -c};
  default:
    return {-c, s};
  }
}

double sin(double x) noexcept {
  if (!(size_of(x) <= kMax))
    return kNan;
  const Reduced r = reduce(x);
  const double size = r.quadrant % 2 ? cosine_of(r) : sine_of(r);
  return r.quadrant & 2 ? -size : size;
}

double cos(double x) noexcept {
  if (!(size_of(x) <= kMax))
    return kNan;
  const Reduced r = reduce(x);
  const double size = r.quadrant % 2 ? sine_of(r) : cosine_of(r);
  return (r.quadrant + 1) & 2 ? -size : size;
}

double tan(double x) noexcept {
  if (!(size_of(x) <= kMax))
    return kNan;
  if (size_of(x) < 0x1p-28)
    return x;
  const Reduced r = reduce(x);
  const Pair s = sine_parts(r.hi, r.lo), c = cosine_parts(r.hi, r.lo);
  const Pair sine = ordered_sum(s.hi, s.lo), cosine = ordered_sum(c.hi, c.lo);
  return r.quadrant % 2 ? -value(quotient(cosine, sine)) : value(quotient(sine, cosine));
}

namespace {

/// atan(k/16), k = 0 .. 16.
constexpr std::array<Pair, 17> angle_table() {
  std::array<Pair, 17> angle{};
  for (int k = 1; k <= 16; ++k) {
    // atan(k/16) - atan((k - 1)/16) = atan s, s = (1/16)/(1 + k (k - 1)/256)
    const Pair s = quotient({16, 0}, {256.0 + k * (k - 1), 0}), square = product(s, s);
    Pair power = s, part{};
    for (int n = 1; n < 28; n += 2, power = product(power, square)) {
      const Pair term = quotient(power, {static_cast<double>(n % 4 == 1 ? n : -n), 0});
      part = sum(part, term);
    }
    angle[static_cast<std::size_t>(k)] = sum(angle[static_cast<std::size_t>(k - 1)], part);
  }
  return angle;
}
constexpr std::array<Pair, 17> kAngles = angle_table();

/// atan(y/x) for 0 <= y <= x, x > 0 and normal.
inline Pair atan_of(double y, double x) {
  // c = k/16 is the nearest to y/x; y/x = tan(atan c + atan u), u = (y - c x)/(x + c y).
  const double ratio = y / x;
  const std::size_t k = ratio < 3.0 / 32 ? 0 : static_cast<std::size_t>(ratio * 16 + 0.5);
  const double c = static_cast<double>(k) / 16, x1 = upper_half(x);
  const double u = k == 0 ? ratio : ((y - c * x1) - c * (x - x1)) / (x + c * y); // |u| < 1/31
  const double z = u * u, z2 = z * z;
  const double rest = z * u *
                      (((1.0 / 3 - z * (1.0 / 5)) + z2 * (1.0 / 7 - z * (1.0 / 9))) +
                       (z2 * z2) * ((1.0 / 11 - z * (1.0 / 13)) + z2 * (1.0 / 15)));
  const Pair angle = ordered_sum(kAngles[k].hi, u);
  return {angle.hi, angle.lo + (kAngles[k].lo - rest)};
}

} // namespace

double atan2(double y, double x) noexcept {
  if (x != x || y != y)
    return kNan;
  double a = size_of(x), b = size_of(y);
  if (a > kMax && b > kMax)
    a = b = 1;
  const bool steep = b > a;
  const double larger = steep ? b : a, smaller = steep ? a : b;
  const double scale = larger > 0x1p1000 ? 0x1p-100 : (larger < 0x1p-900 ? 0x1p100 : 1);
  Pair angle{};
  if (larger > kMax || larger == 0)
    angle = {0, 0};
  else
    angle = atan_of(smaller * scale, larger * scale);
  if (steep)
    angle = sum(kHalfPi, {-angle.hi, -angle.lo});
  if (is_negative(x))
    angle = sum({2 * kHalfPi.hi, 2 * kHalfPi.lo}, {-angle.hi, -angle.lo});
  return with_sign(value(angle), y);
}

double atan(double x) noexcept { return atan2(x, 1); }

// ---- hyperbolic functions, gamma, Bessel -------------------------------------------------------

double cosh(double x) noexcept {
  const double size = size_of(x);
  if (size < 0.35) {
    const double t = expm1(size);
    return 1 + t * t / (2 + 2 * t);
  }
  if (size < 700) {
    const double t = exp(size);
    return 0.5 * t + 0.5 / t;
  }
  if (!(size < 711))
    return x == x ? kInfinity : x;
  const Pair less = sum(size, -kLn2.hi);
  return exp_of(less.hi, less.lo - kLn2.lo).value();
}

double tanh(double x) noexcept {
  const double size = size_of(x);
  if (size < 0.625) {
    // Cody & Waite's rational function, error 2^-57 of the result.
    const double z = x * x;
    const double p = -0.3333333333333333 - z * (0.020498785675308686 + z * 0.00019917742187467818);
    const double q =
        1 + z * (0.46149635702592257 + z * (0.023291313171336696 + z * 0.00020653307162000844));
    return with_sign(size + size * (z * (p / q)), x);
  }
  if (x != x)
    return x;
  return with_sign(size > 20 ? 1 : 1 - 2 / (exp(2 * size) + 1), x);
}

double tgamma(double x) noexcept {
  if (!(x > 0))
    return x == 0 ? with_sign(kInfinity, x) : (x < 0 ? kNan : x);
  if (x > 172)
    return kInfinity;
  // gamma(x) = gamma(x + n)/(x (x + 1) ... (x + n - 1)); Stirling's series from 10 on.
  Pair z{x, 0}, factors{1, 0};
  for (double n = 1; z.hi < 10; ++n) {
    const Pair p = product(factors.hi, z.hi);
    factors = {p.hi, p.lo + (factors.lo * z.hi + factors.hi * z.lo)};
    z = sum(x, n);
  }
  const double inverse = 1 / z.hi, square = inverse * inverse, fourth = square * square;
  const double series =
      inverse *
      (((1.0 / 12 - square * (1.0 / 360)) + fourth * (1.0 / 1260 - square * (1.0 / 1680))) +
       fourth * fourth *
           ((1.0 / 1188 - square * (691.0 / 360360)) +
            fourth * (1.0 / 156 - square * (3617.0 / 122400))));
  // (z - 1/2) log z - z + log(2 pi)/2
  const Pair log = log_of(z.hi), whole = ordered_sum(log.hi, log.lo + z.lo * inverse);
  Pair power = product(whole, sum(z, {-0.5, 0}));
  power = sum(sum(power, {-z.hi, -z.lo}), kHalfLogTwoPi);
  power = ordered_sum(power.hi, power.lo + series);
  if (factors.hi == 1)
    return exp_of(power.hi, power.lo).value();
  const Exponential high = exp_of(power.hi, power.lo);
  return value(quotient(ordered_sum(high.scale(), high.scale() * high.part), factors));
}

Complex sqrt(Complex z) noexcept {
  const double size = 2 * (size_of(z.real()) + abs(z));
  if (!(size > 0))
    return {size, z.imag()};
  const double root = std::sqrt(size), other = z.imag() / root;
  return z.real() >= 0 ? Complex(0.5 * root, other)
                       : Complex(size_of(other), with_sign(0.5 * root, z.imag()));
}

double bessel_i0(double x) noexcept {
  // Sum of (x^2/4)^n/n!^2.
  const double quarter = 0.25 * x * x;
  double term = 1, sum = 1;
  for (int n = 1; term > 1e-17 * sum; ++n) {
    term *= quarter / (static_cast<double>(n) * n);
    sum += term;
  }
  return sum;
}

} // namespace tactus::math
